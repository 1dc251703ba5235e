/** Curves of the last simulation, in step with the picture. */

import { useEffect, useRef, useState, type ReactElement } from "react";
import { api, problemsOf } from "../api";
import { CurvesPanel } from "../../player/curves_panel";
import { decodeMotion, decodeScene, sourceOf, type MotionCurve, type StateSource } from "../../viewer";
import { useShownTheme } from "../shell/theme";
import { useStore, type Simulated } from "../store";
import type { JsonObject } from "../types";
import { isArray, isObject } from "../model/pointers";
import { textOf } from "../model/entries";
import { pictureNow } from "./shown";

export function Curves(): ReactElement {
  const simulated = useStore((state) => state.simulated);
  const stale = useStore((state) => state.simulated !== null && state.simulated.of !== state.data);
  if (simulated === null) return <p className="soft pad">Curves of the motion appear here after a simulation (F5).</p>;
  return (
    <div className="curves">
      <RunLine simulated={simulated} stale={stale} />
      <Plots key={simulated.job} simulated={simulated} />
    </div>
  );
}

function RunLine({ simulated, stale }: { readonly simulated: Simulated; readonly stale: boolean }): ReactElement {
  const run = simulated.result?.["run"];
  const facts: JsonObject = isObject(run) ? run : {};
  const parts = [
    facts["energy_drift"] == null ? "" : `energy drift ${Number(facts["energy_drift"]).toExponential(1)}`,
    facts["violation"] == null ? "" : `constraints within ${Number(facts["violation"]).toExponential(1)}`,
    facts["seconds"] == null ? "" : `computed in ${durationText(Number(facts["seconds"]))}`,
  ];
  return (
    <p className="run-line soft">
      {facts["success"] === false && <b className="failed" title={textOf(facts["status"])}>It did not reach its end: {textOf(facts["advice"])}.</b>}
      {stale && <b className="stale">Before the last edits.</b>} {parts.filter((each) => each !== "").join(" · ")}
      <MoreOutputs simulated={simulated} />
    </p>
  );
}

function durationText(seconds: number): string {
  return seconds < 0.1 ? `${(1000 * seconds).toFixed(1)} ms` : `${seconds.toFixed(2)} s`;
}

/** Ask for another curve by its name. */
function MoreOutputs({ simulated }: { readonly simulated: Simulated }): ReactElement {
  const [text, setText] = useState("");
  const add = async (): Promise<void> => {
    if (text.trim() === "") return;
    try {
      const answer = await api.outputs(simulated.job, [text.trim()]);
      const more = isArray(answer["curves"]) ? answer["curves"] : [];
      const motion = simulated.motion as { readonly curves: readonly unknown[] };
      useStore.setState({ simulated: { ...simulated, motion: { ...motion, curves: [...motion.curves, ...more] } } });
      setText("");
    } catch (error) {
      useStore.setState({ notice: problemsOf(error) });
    }
  };
  return (
    <input
      className="more-outputs" placeholder="add a curve, such as theta_dot" aria-label="Add a curve" value={text}
      onChange={(event) => { setText(event.target.value); }} onKeyDown={(event) => { if (event.key === "Enter") void add(); }}
    />
  );
}

function withCurves(source: StateSource, curves: readonly MotionCurve[]): StateSource {
  return { ...source, start: source.start, end: source.end, times: source.times, events: source.events, vectors: source.vectors, curves, poseAt: source.poseAt.bind(source), vectorAt: source.vectorAt.bind(source) };
}

function Plots({ simulated }: { readonly simulated: Simulated }): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const theme = useShownTheme();
  useEffect(() => {
    const root = host.current;
    if (root === null) return undefined;
    const scene = decodeScene(simulated.scene);
    const motion = decodeMotion(simulated.motion, scene.bodies.length);
    const seek = (time: number): void => { pictureNow.shown?.player.seek(time); };
    const panel = new CurvesPanel(withCurves(sourceOf(scene, motion), motion.curves), simulated.title, null, seek);
    root.replaceChildren(panel.element);
    pictureNow.curves = panel;
    panel.showTime(pictureNow.shown?.player.time ?? 0);
    return () => {
      pictureNow.curves = null;
      panel.dispose();
    };
  }, [simulated]);
  useEffect(() => { pictureNow.curves?.repaint(); }, [theme]);
  return <div ref={host} className="sb-player sb-curves-only" data-theme={theme} />;
}
