/** What an analysis found: tables, positions to look at, curves. */

import { useEffect, useRef, type ReactElement } from "react";
import { CurvesPanel } from "../../player/curves_panel";
import { decodeMotion, type MotionCurve, type StateSource } from "../../viewer";
import { labelOfJob } from "../commands/jobs";
import { textOf } from "../model/entries";
import { labelOf } from "../model/fields";
import { isArray, isObject } from "../model/pointers";
import { useShownTheme } from "../shell/theme";
import { useStore } from "../store";
import type { JobKind, Json, JsonObject } from "../types";

export function AnalysisResult({ kind, result }: { readonly kind: JobKind; readonly result: JsonObject | null }): ReactElement | null {
  if (result === null) return null;
  const modes = objects(result["modes"]);
  const cases = objects(result["cases"]);
  return (
    <section className="result" aria-label={labelOfJob(kind)}>
      <h3>{labelOfJob(kind)}</h3>
      <ShowButton text="Show it" scene={pictureOf(result, "scene")} motion={pictureOf(result, "motion")} title={labelOfJob(kind)} />
      {modes.length > 0 && <Modes modes={modes} scene={result["scene"]} />}
      {cases.length > 0 && <SweepPlot result={result} cases={cases} />}
      <Places places={[...objects(result["places"]), ...objects(result["branches"])]} />
      {result["places"] !== undefined && objects(result["places"]).length === 0 && <p>None found.</p>}
      <Facts value={result} top />
    </section>
  );
}

function objects(value: Json | undefined): readonly JsonObject[] {
  return isArray(value) ? value.filter(isObject) : [];
}

function pictureOf(value: JsonObject, part: string): Json | undefined {
  const { picture } = value;
  return isObject(picture) ? picture[part] : undefined;
}

/** A button that shows a position or a motion in the picture. */
function ShowButton({ text, scene, motion, title }: { readonly text: string; readonly scene: Json | undefined; readonly motion: Json | undefined; readonly title: string }): ReactElement | null {
  if (scene == null || motion == null) return null;
  return <button type="button" className="button small" onClick={() => { useStore.setState({ analysisPicture: { scene, motion, title } }); }}>{text}</button>;
}

function Modes({ modes, scene }: { readonly modes: readonly JsonObject[]; readonly scene: Json | undefined }): ReactElement {
  return (
    <table className="modes">
      <thead><tr><th>Mode</th><th>Frequency [Hz]</th><th>Damping ratio</th><th>Eigenvalue [1/s]</th><th><span className="hidden">Picture</span></th></tr></thead>
      <tbody>
        {modes.map((mode, index) => (
          <tr key={index}>
            <td>{index + 1}</td><td>{numberText(mode["hertz"])}</td><td>{numberText(mode["damping"])}</td><td>{eigenvalueText(mode)}</td>
            <td><ShowButton text="Show" scene={scene} motion={mode["motion"]} title={`Mode ${index + 1}`} /></td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function eigenvalueText(mode: JsonObject): string {
  const part = Number(mode["imag"] ?? 0);
  const real = numberText(mode["real"]);
  return part === 0 ? real : `${real} ± ${numberText(Math.abs(part))} i`;
}

function numberText(value: Json | undefined): string {
  return typeof value === "number" ? Number(value.toPrecision(5)).toString() : "–";
}

/** Positions that were found, each with its picture. */
function Places({ places }: { readonly places: readonly JsonObject[] }): ReactElement | null {
  if (places.length === 0) return null;
  return (
    <ul className="places">
      {places.map((place, index) => (
        <li key={index}>
          <ShowButton text="Show" scene={pictureOf(place, "scene")} motion={pictureOf(place, "motion")} title={`Position ${index + 1}`} />
          <span>{textOf(place["text"] ?? place["verdict"] ?? "")}</span>
        </li>
      ))}
    </ul>
  );
}

/** The curves of all values of a parameter on each other. */
function SweepPlot({ result, cases }: { readonly result: JsonObject; readonly cases: readonly JsonObject[] }): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const theme = useShownTheme();
  useEffect(() => {
    const root = host.current;
    if (root === null) return undefined;
    const panel = new CurvesPanel(sourceOfSweep(result, cases), "sweep", null, () => undefined);
    root.replaceChildren(panel.element);
    return () => { panel.dispose(); };
  }, [result, cases, theme]);
  return <div ref={host} className="sb-player sb-curves-only sweep-plot" data-theme={theme} />;
}

function sourceOfSweep(result: JsonObject, cases: readonly JsonObject[]): StateSource {
  const name = textOf(result["parameter"]);
  const curves = cases.flatMap((each) => objects(each["curves"]).map((curve) => ({ ...curve, name: `${textOf(curve["name"])}, ${name} = ${numberText(each["value"])}` })));
  const motion = decodeMotion({ version: 1, times: result["times"], positions: "", quaternions: "", curves, vectors: [], events: [] }, 1);
  const sorted: MotionCurve[] = [...motion.curves].sort((one, other) => one.name.localeCompare(other.name));
  return { ...motion, curves: sorted, start: motion.times[0]!, end: motion.times.at(-1)!, poseAt: () => undefined, vectorAt: () => undefined, placeAt: () => undefined, touches: () => [], timeShown: (time) => time };
}

const HIDDEN = new Set(["scene", "motion", "modes", "places", "branches", "picture", "cases", "times"]);

/** Numbers, texts and tables of a result, under their names. */
function Facts({ value, top = false }: { readonly value: JsonObject; readonly top?: boolean }): ReactElement {
  const entries = Object.entries(value).filter(([key, each]) => !HIDDEN.has(key) && each !== null && each !== "");
  return <dl className="facts">{entries.map(([key, each]) => <div key={key}><dt>{top ? labelOf(key) : key}</dt><dd><Fact value={each} /></dd></div>)}</dl>;
}

function Fact({ value }: { readonly value: Json }): ReactElement {
  if (isObject(value)) return <Facts value={value} />;
  if (!isArray(value)) return <>{typeof value === "boolean" ? (value ? "yes" : "no") : scalarText(value)}</>;
  if (value.every((each) => !isObject(each) && !isArray(each))) return <>{value.map(scalarText).join(", ")}</>;
  return <ul>{value.slice(0, 50).map((each, index) => <li key={index}><Fact value={each} /></li>)}</ul>;
}

function scalarText(value: Json): string {
  return typeof value === "number" ? numberText(value) : textOf(value);
}
