/** Curves as groups of one unit, as text, and their values at a time. */

import { sampleBefore, type MotionCurve } from "../viewer";
import { inView, turnOf, wrapped, type AngleView } from "./angles";

/** Curves that share a unit and so an axis. */
export interface CurveGroup {
  readonly unit: string;
  readonly curves: readonly MotionCurve[];
  /** At what difference values begin anew; 0: they count on. */
  readonly turn: number;
}

/** Return the curves as they are shown, by their unit, in the order in which units come first. */
export function groupCurves(curves: readonly MotionCurve[], view: AngleView): CurveGroup[] {
  const shown = curves.map((each) => inView(each, view));
  const units = [...new Set(shown.map((each) => each.unit))];
  return units.map((unit) => ({ unit, curves: shown.filter((each) => each.unit === unit), turn: view.wrap ? turnOf(unit) : 0 }));
}

/** Return the value at a time, straight between samples; of wrapped angles on the shorter way. */
export function valueAt(times: Float64Array, values: Float32Array, time: number, turn: number): number {
  const before = sampleBefore(times, time);
  const after = Math.min(before + 1, times.length - 1);
  const span = times[after]! - times[before]!;
  const weight = span > 0 ? Math.min(Math.max((time - times[before]!) / span, 0), 1) : 0;
  const step = values[after]! - values[before]!;
  return turn > 0 ? wrapped(values[before]! + weight * wrapped(step, turn), turn) : values[before]! + weight * step;
}

/** Return a number with four digits that keeps its width. */
export function formatValue(value: number): string {
  const size = Math.abs(value) < 1e-15 ? 0 : Math.abs(value); // less is rounding
  const text =
    size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : size < 10 ? (size === 0 ? 0 : value).toFixed(4) : value.toPrecision(5);
  return text.replace("-", "−");
}

/** Return a table with a header, times in the first column; text as RFC 4180 has it. */
export function toCsv(times: Float64Array, curves: readonly MotionCurve[]): string {
  const header = ["t [s]", ...curves.map((each) => (each.unit === "" ? each.name : `${each.name} [${each.unit}]`))];
  const lines = [header.map(quote).join(",")];
  times.forEach((time, row) => {
    const values = curves.map((each) => String(Number(each.values[row]!.toPrecision(8))));
    lines.push([String(time), ...values].join(","));
  });
  return `${lines.join("\r\n")}\r\n`;
}

function quote(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
