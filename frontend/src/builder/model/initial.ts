/** Initial values of coordinates, as a pose that was dragged says them. */

import { isObject, joinPointer, valueAt, withValue } from "./pointers";
import type { Json, Model } from "../types";

type Values = Readonly<Record<string, number>>;

const SAME = 1e-9;
const DEGREES = /^\s*[-+\d.eE]+\s*deg\s*$/;

/** Return a number with six digits; in degrees where the file says it so. */
export function initialText(value: number, before: Json | undefined): string {
  const degrees = typeof before === "string" && DEGREES.test(before);
  const number = String(Number((degrees ? (180 * value) / Math.PI : value).toPrecision(6)));
  return degrees ? `${number} deg` : number;
}

/** Return where the value itself stands: first values with a priority are tables. */
export function valuePointer(data: Json | undefined, pointer: string): string {
  return isObject(valueAt(data, pointer)) ? `${pointer}/value` : pointer;
}

/** Return whether a first value holds when loops are closed; others are where the search begins. */
export function isExact(value: Json | undefined): boolean {
  return isObject(value) && value["priority"] === "hold";
}

/** Return data whose first value of a name holds, or is a guess; only what holds is a table in the file. */
export function withPriority(data: Model, name: string, exact: boolean): Model {
  const pointer = `/initial${joinPointer(name)}`;
  const value = valueAt(data, valuePointer(data, pointer)) ?? "0";
  return withValue(data, pointer, exact ? { value, priority: "hold" } : value);
}

/** Return data that begin in a pose; values that are as they were at the start stay as they are written. */
export function withInitial(data: Model, values: Values, start: Values): Model {
  return Object.entries(values).reduce((before, [name, value]) => {
    const first = start[name];
    if (first !== undefined && Math.abs(value - first) <= SAME * Math.max(1, Math.abs(value))) return before;
    const pointer = valuePointer(before, `/initial${joinPointer(name)}`);
    return withValue(before, pointer, initialText(value, valueAt(before, pointer)));
  }, data);
}
