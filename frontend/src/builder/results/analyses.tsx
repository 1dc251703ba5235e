/** Analyses of the mechanism, and what they found. */

import { useState, type ReactElement } from "react";
import { labelOfJob, runJob } from "../commands/jobs";
import { textOf } from "../model/entries";
import { isArray, isObject } from "../model/pointers";
import { useStore } from "../store";
import type { JobKind } from "../types";
import { AnalysisResult } from "./analysis_result";

const KINDS: readonly (readonly [JobKind, string])[] = [
  ["equilibrium", "Equilibrium positions and their stability."],
  ["modes", "Frequencies, damping and shapes of small motions about an equilibrium; each mode can be animated."],
  ["singular", "Singular positions, in which the first coordinate does not determine the others: a drive there cannot move the mechanism."],
  ["ratios", "Ratios of all speeds to the independent speeds, at the start."],
];

export function Analyses(): ReactElement {
  const analysis = useStore((state) => state.analysis);
  const busy = useStore((state) => state.runs.computation !== undefined);
  return (
    <div className="analyses pad" data-testid="analyses">
      <div className="row">
        {KINDS.map(([kind, tip]) => <button key={kind} type="button" className="button" title={tip} disabled={busy} onClick={() => { void runJob(kind); }}>{labelOfJob(kind)}</button>)}
      </div>
      <ConstantSpeed busy={busy} />
      <Sweep busy={busy} />
      <Inverse busy={busy} />
      {analysis !== null && <AnalysisResult kind={analysis.kind} result={analysis.result} />}
    </div>
  );
}

/** What drives a coordinate at a constant rate; no input has to be there for it. */
function ConstantSpeed({ busy }: { readonly busy: boolean }): ReactElement | null {
  const summary = useStore((state) => state.check?.summary);
  const names = (summary?.coordinates ?? []).filter((each) => ["rad", "m"].includes(summary?.units[each] ?? ""));
  const [name, setName] = useState("");
  const [rate, setRate] = useState("10");
  const chosen = names.includes(name) ? name : names[0];
  if (chosen === undefined) return null;
  const unit = summary?.units[chosen] === "rad" ? "rad/s" : "m/s";
  const wrong = !Number.isFinite(Number(rate)) || Number(rate) === 0;
  return (
    <div className="row sweep" role="group" aria-label="Torque for constant speed">
      <label>Torque or force that keeps <select value={chosen} onChange={(event) => { setName(event.target.value); }}>{names.map((each) => <option key={each}>{each}</option>)}</select></label>
      <label>at <input value={rate} aria-invalid={wrong} onChange={(event) => { setRate(event.target.value); }} /> {unit}</label>
      <button type="button" className="button small" disabled={busy || wrong} onClick={() => { void runJob("torque", { coordinate: chosen, rate: Number(rate) }); }}>Run</button>
    </div>
  );
}

/** A sweep of one parameter. */
function Sweep({ busy }: { readonly busy: boolean }): ReactElement | null {
  const parameters = useStore((state) => state.data["parameters"]);
  const coordinates = useStore((state) => state.check?.summary?.coordinates);
  const names = isObject(parameters) ? Object.keys(parameters) : [];
  const [name, setName] = useState("");
  const [values, setValues] = useState("");
  if (names.length === 0) return null;
  const chosen = names.includes(name) ? name : names[0]!;
  const numbers = values.split(",").map((each) => each.trim()).filter((each) => each !== "").map(Number);
  const run = (): void => { void runJob("sweep", { parameter: chosen, values: numbers, outputs: [...(coordinates ?? [])].slice(0, 3), t_end: 5 }); };
  return (
    <div className="row sweep" role="group" aria-label="Sweep">
      <label>Sweep of <select value={chosen} onChange={(event) => { setName(event.target.value); }}>{names.map((each) => <option key={each}>{each}</option>)}</select></label>
      <label>over <input value={values} placeholder="0.5, 1, 1.5" onChange={(event) => { setValues(event.target.value); }} /></label>
      <button type="button" className="button small" disabled={busy || numbers.length === 0 || numbers.some((each) => !Number.isFinite(each))} onClick={run}>Run</button>
    </div>
  );
}

/** What has to act so that a coordinate follows a formula. */
function Inverse({ busy }: { readonly busy: boolean }): ReactElement | null {
  const listed = useStore((state) => state.data["inputs"]);
  const coordinates = useStore((state) => state.check?.summary?.coordinates) ?? [];
  const unknowns = isArray(listed) ? listed.map(textOf) : [];
  const [name, setName] = useState("");
  const [text, setText] = useState("");
  const chosen = coordinates.includes(name) ? name : coordinates[0];
  if (chosen === undefined || unknowns.length === 0) return null;
  const run = (): void => { void runJob("inverse", { motion: { [chosen]: text }, unknowns: unknowns.slice(0, 1), t_end: 2 }); };
  return (
    <div className="row sweep" role="group" aria-label="Inverse dynamics">
      <label>Find {unknowns[0]} so that <select value={chosen} onChange={(event) => { setName(event.target.value); }}>{coordinates.map((each) => <option key={each}>{each}</option>)}</select></label>
      <label>is <input value={text} placeholder="0.5 + 2*t" onChange={(event) => { setText(event.target.value); }} /></label>
      <button type="button" className="button small" disabled={busy || text.trim() === ""} onClick={run}>Run</button>
    </div>
  );
}
