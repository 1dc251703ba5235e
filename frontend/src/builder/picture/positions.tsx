/** Coordinates as sliders: one is dragged, and the loops follow. */

import type { ReactElement } from "react";
import { api } from "../api";
import { useStore } from "../store";
import { backToStart, keepPose, pose } from "./posing";

const NOTHING: Readonly<Record<string, number>> = {};

function move(name: string, value: number): void {
  useStore.setState({ showsMotion: false, analysisPicture: null });
  pose((data, guess, document) => api.pose(document, data, { [name]: value }, guess));
}

export function Positions(): ReactElement {
  const values = useStore((state) => state.check?.values) ?? NOTHING;
  const summary = useStore((state) => state.check?.summary);
  const posed = useStore((state) => (state.posed?.of === state.data ? state.posed : null));
  const names = summary?.coordinates.filter((each) => values[each] !== undefined) ?? [];
  if (names.length === 0) return <p className="soft pad">Coordinates appear here as soon as the mechanism can be assembled. Drag one, or a body in the picture, and the loops follow.</p>;
  return (
    <div className="positions" data-testid="positions">
      {names.map((name) => <Slider key={name} name={name} start={values[name]!} now={(posed?.values ?? values)[name] ?? 0} />)}
      {posed !== null && posed.problem !== "" && <p className="field-problem warning" role="alert">{posed.problem}</p>}
      <div className="row">
        <button type="button" className="button small" disabled={posed === null} onClick={backToStart}>Back to the start</button>
        <button type="button" className="button small" disabled={posed?.moved !== true} onClick={keepPose}>Start from here</button>
      </div>
    </div>
  );
}

function Slider({ name, start, now }: { readonly name: string; readonly start: number; readonly now: number }): ReactElement {
  const reach = Math.max(Math.PI, 1.5 * Math.abs(start));
  return (
    <label className="slider">
      <span>{name}</span>
      <input type="range" aria-label={name} min={start - reach} max={start + reach} step="any" value={now} onChange={(event) => { move(name, Number(event.target.value)); }} />
      <output>{now.toFixed(4).replace(/^-(0\.0+)$/, "$1")}</output>
    </label>
  );
}
