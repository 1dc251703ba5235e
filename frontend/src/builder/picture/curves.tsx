/** Curves of the last simulation, in step with the picture. */

import { useEffect, useMemo, useRef, useState, type ReactElement } from "react";
import { api, problemsOf } from "../api";
import { CurvesPanel } from "../../player/curves_panel";
import { inPrint, plainReading } from "../../player/readable";
import { decodeMotion, decodeScene, sourceOf, type MotionCurve, type StateSource } from "../../viewer";
import { useShownTheme } from "../shell/theme";
import { useStore, type Simulated } from "../store";
import type { JsonObject } from "../types";
import { isArray, isObject } from "../model/pointers";
import { curveTree, firstTicks, shortName, type Branch, type Offered } from "../model/curve_tree";
import { textOf } from "../model/entries";
import { pictureNow } from "./shown";

/** What was ticked, also for the next run; null: nothing was chosen yet. */
let lastTicks: readonly string[] | null = null;

export function Curves(): ReactElement {
  const simulated = useStore((state) => state.simulated);
  const stale = useStore((state) => state.simulated !== null && state.simulated.of !== state.data);
  if (simulated === null) return <p className="soft pad">Curves of the motion appear here after a simulation (F5).</p>;
  return (
    <div className="curves">
      <RunLine simulated={simulated} stale={stale} />
      <ChosenCurves key={simulated.job} simulated={simulated} />
    </div>
  );
}

function offeredBy(simulated: Simulated): readonly Offered[] {
  const offered = simulated.result?.["curves"];
  const listed = (isArray(offered) ? offered : []) as unknown as readonly Offered[];
  const more = (simulated.motion as { readonly curves: readonly Offered[] }).curves;
  return [...listed, ...more.filter(({ name }) => !listed.some((each) => each.name === name))];
}

/** The tree of what can be drawn, and what is ticked in it. */
function ChosenCurves({ simulated }: { readonly simulated: Simulated }): ReactElement {
  const offered = useMemo(() => offeredBy(simulated), [simulated]);
  const tree = useMemo(() => curveTree(offered), [offered]);
  const [ticks, setTicks] = useState<readonly string[]>(() => {
    const still = (lastTicks ?? []).filter((each) => offered.some(({ name }) => name === each));
    return still.length > 0 ? still : firstTicks(tree);
  });
  const choose = (names: readonly string[]): void => {
    lastTicks = names;
    setTicks(names);
  };
  useEffect(() => { void load(simulated.job, ticks); }, [simulated.job, ticks]);
  return (
    <div className="curve-choice">
      <div className="curve-tree" role="group" aria-label="Curves that can be drawn" data-testid="curve-tree">
        {tree.map((each) => <TreeBranch key={each.title} branch={each} ticks={ticks} choose={choose} />)}
        <MoreOutputs simulated={simulated} added={(name) => { choose([...ticks, name]); }} />
      </div>
      {ticks.length === 0 ? <p className="soft pad">Select curves to draw.</p> : <Plots simulated={simulated} names={ticks} />}
    </div>
  );
}

function TreeBranch({ branch, ticks, choose }: { readonly branch: Branch; readonly ticks: readonly string[]; readonly choose: (names: readonly string[]) => void }): ReactElement {
  const any = (each: Branch): boolean => each.curves.some(({ name }) => ticks.includes(name)) || each.branches.some(any);
  const [open, setOpen] = useState(() => any(branch));
  const toggle = (name: string): void => { choose(ticks.includes(name) ? ticks.filter((each) => each !== name) : [...ticks, name]); };
  return (
    <details open={open} onToggle={(event) => { setOpen(event.currentTarget.open); }}>
      <summary>{branch.title}</summary>
      {open && branch.curves.map(({ name, unit, group = "" }) => (
        <label key={name} title={name}><input type="checkbox" aria-label={name} checked={ticks.includes(name)} onChange={() => { toggle(name); }} /> <span>{plainReading(shortName({ name, unit, group }))}</span> <span className="unit">{unit}</span></label>
      ))}
      {open && branch.branches.map((each) => <TreeBranch key={each.title} branch={each} ticks={ticks} choose={choose} />)}
    </details>
  );
}

function curvesOf(motion: unknown): readonly { readonly name: string }[] {
  return (motion as { readonly curves: readonly { readonly name: string }[] }).curves;
}

/** Ask for curves that did not come with the motion. */
async function load(job: string, names: readonly string[]): Promise<void> {
  const { simulated } = useStore.getState();
  if (simulated === null) return;
  const missing = names.filter((name) => !curvesOf(simulated.motion).some((each) => each.name === name));
  if (missing.length === 0) return;
  try {
    const answer = await api.outputs(job, missing);
    const more = isArray(answer["curves"]) ? answer["curves"] : [];
    const now = useStore.getState().simulated;
    if (now?.job !== job) return; // a newer run took its place
    useStore.setState({ simulated: { ...now, motion: { ...(now.motion as object), curves: [...curvesOf(now.motion), ...more] } } });
  } catch (error) {
    useStore.setState({ notice: problemsOf(error) });
  }
}

function RunLine({ simulated, stale }: { readonly simulated: Simulated; readonly stale: boolean }): ReactElement {
  const run = simulated.result?.["run"];
  const facts: JsonObject = isObject(run) ? run : {};
  const parts = [
    facts["energy_drift"] == null ? "" : `energy drift ${inPrint(Number(facts["energy_drift"]))} J`,
    facts["violation"] == null || Number(facts["violation"]) === 0 ? "" : `constraint error ${inPrint(Number(facts["violation"]))}`,
    facts["seconds"] == null ? "" : `computed in ${durationText(Number(facts["seconds"]))}`,
  ];
  return (
    <p className="run-line soft">
      {facts["success"] === false && <b className="failed" title={textOf(facts["status"])}>It did not reach its end: {textOf(facts["advice"])}.</b>}
      {stale && <b className="stale">Computed before the last edits.</b>} {parts.filter((each) => each !== "").join(" · ")}
    </p>
  );
}

function durationText(seconds: number): string {
  return seconds < 0.1 ? `${(1000 * seconds).toFixed(1)} ms` : `${seconds.toFixed(2)} s`;
}

/** Ask for another curve by its name, or a formula of names. */
function MoreOutputs({ simulated, added }: { readonly simulated: Simulated; readonly added: (name: string) => void }): ReactElement {
  const [text, setText] = useState("");
  const add = async (): Promise<void> => {
    const name = text.trim();
    if (name === "") return;
    await load(simulated.job, [name]);
    const now = useStore.getState().simulated;
    if (now === null || !curvesOf(now.motion).some((each) => each.name === name)) return; // the notice says why
    added(name);
    setText("");
  };
  return (
    <input
      className="more-outputs" placeholder="add, such as sin(theta)" aria-label="Add a curve" value={text}
      onChange={(event) => { setText(event.target.value); }} onKeyDown={(event) => { if (event.key === "Enter") void add(); }}
    />
  );
}

function withCurves(source: StateSource, curves: readonly MotionCurve[]): StateSource {
  return { ...source, start: source.start, end: source.end, times: source.times, events: source.events, vectors: source.vectors, curves, poseAt: source.poseAt.bind(source), vectorAt: source.vectorAt.bind(source), placeAt: source.placeAt.bind(source), touches: source.touches.bind(source), timeShown: source.timeShown.bind(source) };
}

function Plots({ simulated, names }: { readonly simulated: Simulated; readonly names: readonly string[] }): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const theme = useShownTheme();
  useEffect(() => {
    const root = host.current;
    if (root === null) return undefined;
    const scene = decodeScene(simulated.scene);
    const motion = decodeMotion(simulated.motion, scene.bodies.length);
    const seek = (time: number): void => { pictureNow.shown?.player.seek(time); };
    const curves = names.flatMap((name) => motion.curves.find((each) => each.name === name) ?? []);
    const panel = new CurvesPanel(withCurves(sourceOf(scene, motion), curves), simulated.title, names, seek);
    root.replaceChildren(panel.element);
    pictureNow.curves = panel;
    panel.showTime(pictureNow.shown?.player.time ?? 0);
    return () => {
      pictureNow.curves = null;
      panel.dispose();
    };
  }, [simulated, names]);
  useEffect(() => { pictureNow.curves?.repaint(); }, [theme]);
  return <div ref={host} className="sb-player sb-curves-only" data-theme={theme} />;
}
