/** Coordinates as sliders with a real range: one is moved, and the loops follow. */

import { useState, type ReactElement } from "react";
import { plainReading } from "../../player/readable";
import { api } from "../api";
import { textOf } from "../model/entries";
import { valuePointer } from "../model/initial";
import { joinPointer, valueAt } from "../model/pointers";
import { quantityOf, textIn } from "../model/quantities";
import { quaternionOf, turnsOf, type Quaternion, type Turns } from "../model/turns";
import { useStore } from "../store";
import type { Json } from "../types";
import { backToStart, keepPose, pose } from "./posing";
import { pictureNow } from "./shown";

type Values = Readonly<Record<string, number>>;

/** What turns in all directions, and moves along `places`. */
interface Turning {
  readonly owner: string;
  readonly places: readonly string[];
}

const NOTHING: Values = {};
const DEGREES_KEY = "symbody-degrees";
const PLACES = ["x", "y", "z"] as const;
const PARTS = ["qw", "qx", "qy", "qz"] as const;
const SAME = 1e-4; // of what the loops leave where it was

function move(values: Values): void {
  useStore.setState({ showsMotion: false, analysisPicture: null });
  pose((data, guess, document) => api.pose(document, data, values, guess));
}

/** Return the coordinates that stand alone, and what turns in all directions: bodies that move freely, spherical joints. */
function groupsOf(names: readonly string[]): { readonly single: readonly string[]; readonly turning: readonly Turning[] } {
  const all = new Set(names);
  const has = (owner: string, parts: readonly string[]): boolean => parts.every((part) => all.has(`${owner}_${part}`));
  const owners = names.filter((each) => each.endsWith("_qw")).map((each) => each.slice(0, -3)).filter((owner) => has(owner, PARTS));
  const turning = owners.map((owner) => ({ owner, places: has(owner, PLACES) ? PLACES : [] }));
  const grouped = new Set(turning.flatMap(({ owner, places }) => [...places, ...PARTS].map((part) => `${owner}_${part}`)));
  return { single: names.filter((each) => !grouped.has(each)), turning };
}

export function Positions(): ReactElement {
  const start = useStore((state) => state.check?.values) ?? NOTHING;
  const summary = useStore((state) => state.check?.summary);
  const posed = useStore((state) => (state.posed?.of === state.data ? state.posed : null));
  const [degrees, setDegrees] = useState(() => localStorage.getItem(DEGREES_KEY) !== "no");
  const names = summary?.coordinates.filter((each) => start[each] !== undefined) ?? [];
  if (names.length === 0) return <p className="soft pad">Coordinates appear here as soon as the mechanism can be assembled. Drag a slider, or a body in the picture; the loops stay closed.</p>;
  const now = posed?.values ?? start;
  const choose = (next: boolean): void => {
    localStorage.setItem(DEGREES_KEY, next ? "yes" : "no");
    setDegrees(next);
  };
  const rowOf = (name: string): ReactElement => {
    const base = summary?.units[name] ?? "";
    return <Row key={name} name={name} label={plainReading(name)} base={base} unit={base === "rad" && degrees ? "deg" : base} start={start[name]!} now={now[name] ?? 0} change={(value) => { move({ [name]: value }); }} />;
  };
  const { single, turning } = groupsOf(names);
  return (
    <div className="positions" data-testid="positions">
      <label className="degrees"><input type="checkbox" checked={degrees} onChange={(event) => { choose(event.target.checked); }} /> Angles in degrees</label>
      {single.map(rowOf)}
      {turning.map((each) => <TurningRows key={each.owner} {...each} start={start} now={now} degrees={degrees} />)}
      {posed !== null && posed.problem !== "" && <p className="field-problem warning" role="alert">{posed.problem}</p>}
      <div className="row">
        <button type="button" className="button small" disabled={posed === null} onClick={backToStart}>Back to the start</button>
        <button type="button" className="button small" disabled={posed?.moved !== true} onClick={keepPose}>Start from here</button>
      </div>
    </div>
  );
}

function quaternionIn(values: Values, body: string): Quaternion {
  return PARTS.map((part) => values[`${body}_${part}`] ?? 0) as unknown as Quaternion;
}

/** A body that nothing holds, or a spherical joint: where it is, and three turns; folded, as there may be many. */
function TurningRows({ owner: body, places, start, now, degrees }: Turning & { readonly start: Values; readonly now: Values; readonly degrees: boolean }): ReactElement {
  const [before, turns] = [turnsOf(quaternionIn(start, body)), turnsOf(quaternionIn(now, body))];
  const turn = (axis: number, value: number): void => {
    const next = turns.map((each, index) => (index === axis ? value : each)) as unknown as Turns;
    const quaternion = quaternionOf(next);
    move(Object.fromEntries(PARTS.map((part, index) => [`${body}_${part}`, quaternion[index]!])));
  };
  return (
    <details className="free-body">
      <summary>{body} <span className="soft">{places.length === 0 ? "turns in all directions" : "free: 6 degrees of freedom"}</span></summary>
      {places.map((part) => {
        const name = `${body}_${part}`;
        return <Row key={part} name={name} label={part} base="m" unit="m" start={start[name] ?? 0} now={now[name] ?? 0} change={(value) => { move({ [name]: value }); }} />;
      })}
      {PLACES.map((part, axis) => <Row key={part} name={`${body}, turn about ${part}`} label={`turn ${part}`} base="rad" unit={degrees ? "deg" : "rad"} start={before[axis]!} now={turns[axis]!} change={(value) => { turn(axis, value); }} />)}
    </details>
  );
}

/** Return the ends of a slider: a turn of an angle, of a length as far as the mechanism is large. */
function rangeOf(base: string, start: number): readonly [number, number] {
  const size = pictureNow.shown?.player.data.scene.size ?? 1;
  const reach = base === "rad" ? Math.PI : base === "m" ? Math.max(size, 1e-6) : 1;
  const most = Math.max(reach, 1.2 * Math.abs(start));
  return [-most, most];
}

interface RowProps {
  readonly name: string;
  readonly label: string;
  readonly base: string;
  readonly unit: string;
  readonly start: number;
  readonly now: number;
  readonly change: (value: number) => void;
}

function Row({ name, label, base, unit, start, now, change }: RowProps): ReactElement {
  const [text, setText] = useState<string | null>(null);
  const [least, most] = rangeOf(base, start);
  const value = text === null ? now : quantityOf(text, base, unit);
  const accept = (): void => {
    if (text !== null && value !== null && textIn(now, unit) !== text) change(value);
    setText(null);
  };
  return (
    <div className="slider">
      <span title={name}>{label}</span>
      <input type="range" aria-label={name} min={least} max={most} step="any" value={Math.min(most, Math.max(least, now))} onChange={(event) => { change(Number(event.target.value)); }} />
      <input
        aria-label={`Value of ${name}`} aria-invalid={value === null} value={text ?? textIn(now, unit)} onBlur={accept}
        onChange={(event) => { setText(event.target.value); }} onKeyDown={(event) => { if (event.key === "Enter") accept(); else if (event.key === "Escape") setText(null); }}
      />
      <span className="unit">{unit}</span>
      <Moved name={name} base={base} unit={unit} start={start} />
    </div>
  );
}

/** Says where the file's own value could not be: the loops moved it. */
function Moved({ name, base, unit, start }: Pick<RowProps, "name" | "base" | "unit" | "start">): ReactElement | null {
  const written = useStore((state): Json | undefined => valueAt(state.data, valuePointer(state.data, `/initial${joinPointer(name)}`)));
  const wanted = written === undefined ? null : quantityOf(textOf(written), base);
  if (wanted === null || Math.abs(wanted - start) <= SAME * Math.max(1, Math.abs(start))) return null;
  return <small className="moved">The file says {textOf(written)}; the loops moved it to {textIn(start, unit)} {unit}.</small>;
}
