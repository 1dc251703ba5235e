/** Analyses of the mechanism, and what they found. */

import { useState, type ReactElement } from "react";
import { labelOfJob, runJob } from "../commands/jobs";
import { textOf } from "../model/entries";
import { labelOf } from "../model/fields";
import { isArray, isObject } from "../model/pointers";
import { useStore } from "../store";
import type { JobKind, Json, JsonObject } from "../types";

const KINDS: readonly (readonly [JobKind, string])[] = [
  ["equilibrium", "Where it rests, and whether it stays there."],
  ["modes", "Frequencies, damping and shapes of small motions about an equilibrium; each can be watched."],
  ["singular", "Positions in which the constraints lose a rank."],
  ["inverse", "What has to act so that the initial motion goes on."],
];

export function Analyses(): ReactElement {
  const analysis = useStore((state) => state.analysis);
  const busy = useStore((state) => state.run !== null);
  return (
    <div className="analyses pad" data-testid="analyses">
      <div className="row">
        {KINDS.map(([kind, tip]) => <button key={kind} type="button" className="button" title={tip} disabled={busy} onClick={() => { void runJob(kind); }}>{labelOfJob(kind)}</button>)}
      </div>
      <Sweep busy={busy} />
      {analysis !== null && <Result kind={analysis.kind} result={analysis.result} />}
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

function Result({ kind, result }: { readonly kind: JobKind; readonly result: JsonObject | null }): ReactElement {
  const motions = result?.["motions"] ?? result?.["shapes"];
  return (
    <section className="result" aria-label={labelOfJob(kind)}>
      <h3>{labelOfJob(kind)}</h3>
      {isArray(motions) && isObject(result) && <Shapes result={result} motions={motions} />}
      <Facts value={result} />
    </section>
  );
}

/** Buttons that show motions of an analysis in the picture. */
function Shapes({ result, motions }: { readonly result: JsonObject; readonly motions: readonly Json[] }): ReactElement {
  const show = (index: number): void => {
    const own = motions[index];
    const motion = isObject(own) && own["motion"] !== undefined ? own["motion"] : (own ?? null);
    useStore.setState({ analysisPicture: { scene: result["scene"] ?? useStore.getState().check?.picture?.scene, motion, title: `Mode ${index + 1}` } });
  };
  return <div className="row">{motions.map((_, index) => <button key={index} type="button" className="button small" onClick={() => { show(index); }}>Show mode {index + 1}</button>)}</div>;
}

const HIDDEN = new Set(["scene", "motion", "motions", "shapes", "picture"]);

/** Numbers, texts and tables of a result, under their names. */
function Facts({ value }: { readonly value: Json }): ReactElement | null {
  if (!isObject(value)) return null;
  const entries = Object.entries(value).filter(([key, each]) => !HIDDEN.has(key) && each !== null);
  return <dl className="facts">{entries.map(([key, each]) => <div key={key}><dt>{labelOf(key)}</dt><dd><Fact value={each} /></dd></div>)}</dl>;
}

function Fact({ value }: { readonly value: Json }): ReactElement {
  if (typeof value === "number") return <>{short(value)}</>;
  if (typeof value === "boolean") return <>{value ? "yes" : "no"}</>;
  if (isArray(value) && value.every((each) => !isObject(each) && !isArray(each))) return <>{value.map((each) => (typeof each === "number" ? short(each) : textOf(each))).join(", ")}</>;
  if (isArray(value)) return <ul>{value.slice(0, 50).map((each, index) => <li key={index}><Fact value={each} /></li>)}</ul>;
  if (isObject(value)) return <Facts value={value} />;
  return <>{textOf(value)}</>;
}

function short(value: number): string {
  return Number(value.toPrecision(6)).toString();
}
