/** Curves as groups of one unit, as text, and their values at a time. */

import { sampleBefore, type MotionCurve } from "../viewer";

/** Curves that share a unit and so an axis. */
export interface CurveGroup {
  readonly unit: string;
  readonly curves: readonly MotionCurve[];
}

/** Return the curves by their unit, in the order in which units come first. */
export function groupCurves(curves: readonly MotionCurve[]): CurveGroup[] {
  const units = [...new Set(curves.map((each) => each.unit))];
  return units.map((unit) => ({ unit, curves: curves.filter((each) => each.unit === unit) }));
}

/** Return the value at a time, straight between samples. */
export function valueAt(times: Float64Array, values: Float32Array, time: number): number {
  const before = sampleBefore(times, time);
  const after = Math.min(before + 1, times.length - 1);
  const span = times[after]! - times[before]!;
  const weight = span > 0 ? Math.min(Math.max((time - times[before]!) / span, 0), 1) : 0;
  return values[before]! + weight * (values[after]! - values[before]!);
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
