/** What the coordinates and speeds of an entry are called: as it says, else after its own name. */

import { isArray, isObject, withValue } from "./pointers";
import { entriesOf, textOf, type Entry } from "./entries";
import type { Model } from "../types";

/** What follows the name of an element in the names of its coordinates and speeds. */
const ENDINGS = "(?:_(?:[vw]?[xyz]|q[wxyz]|\\d+))?(?:_dot)?";

function escaped(text: string): string {
  return text.replace(/[$()*+.?[\\\]^{|}]/g, "\\$&");
}

/** Return the name of an element made fit for formulas. */
export function symbolOf(name: string): string {
  return name.replace(/[^\w\u0080-\u{10ffff}]/gu, "_");
}

function hasAutomatic({ value }: Entry): boolean {
  return value["coordinate"] === undefined && value["coordinates"] === undefined;
}

/** Return a pattern of the initial values that belong to an entry. */
function patternOf(entry: Entry): RegExp {
  const { name, value } = entry;
  const given = [value["coordinate"], value["coordinates"], value["speed_names"]].flatMap((each) => (isArray(each) ? each : [each ?? null]));
  const named = given.map(textOf).filter((each) => each !== "").map((each) => `${escaped(each)}(?:_dot)?`);
  if (hasAutomatic(entry)) named.push(escaped(symbolOf(name)) + ENDINGS);
  return new RegExp(`^(?:${named.join("|")})$`, "u");
}

/** Return data without initial values of coordinates that went with entries. */
export function withoutInitialOf(data: Model, gone: readonly Entry[]): Model {
  const lost = gone.map(patternOf);
  const left = entriesOf(data).map(patternOf);
  return filteredInitial(data, (key) => !lost.some((each) => each.test(key)) || left.some((each) => each.test(key)));
}

/** Return data without places and turns of bodies that move freely no longer. */
export function withoutFreePlaces(data: Model, bodies: readonly string[]): Model {
  const lost = bodies.map((each) => new RegExp(`^${escaped(symbolOf(each))}_(?:[vw]?[xyz]|q[wxyz])(?:_dot)?$`, "u"));
  return filteredInitial(data, (key) => !lost.some((each) => each.test(key)));
}

function filteredInitial(data: Model, stays: (key: string) => boolean): Model {
  const initial = data["initial"];
  if (!isObject(initial)) return data;
  const kept = Object.entries(initial).filter(([key]) => stays(key));
  if (kept.length === Object.keys(initial).length) return data;
  return withValue(data, "/initial", kept.length === 0 ? undefined : Object.fromEntries(kept));
}

/** Return data whose initial values follow an entry that has another name, where its coordinates are called after it. */
export function withRenamedInitial(data: Model, before: Entry, after: string): Model {
  const initial = data["initial"];
  if (!isObject(initial) || !hasAutomatic(before)) return data;
  const own = symbolOf(before.name);
  const pattern = new RegExp(`^${escaped(own)}(${ENDINGS})$`, "u");
  const entries = Object.entries(initial).map(([key, value]) => [key.replace(pattern, (_, ending: string) => symbolOf(after) + ending), value] as const);
  return withValue(data, "/initial", Object.fromEntries(entries));
}
