/** New names, and all places that refer to the old ones. */

import {
  entriesOf, entryAt, GROUND, INPUTS, layoutNameOf, pointerOf, referenceOf, referenceText, textOf, type Entry, type EntryId,
} from "./entries"; // prettier-ignore
import { withRenamedInitial } from "./coordinates";
import { SIGNALS } from "./graph";
import { isSymbol } from "./names";
import { isArray, isObject, valueAt, withKey, withValue } from "./pointers";
import { mapFormulas } from "./schema";
import { wiresOf } from "./wires";
import type { Json, JsonObject, Model } from "../types";

/** The fields of an entry that refer to bodies and frames. */
const REFERRING = ["between", "on", "reaction_on", "resolved_in"] as const;

type Change = (reference: string) => string;

function changedReferences(data: Model, change: Change): Model {
  return entriesOf(data).reduce((before, { id, value }) => {
    return REFERRING.reduce((within, key) => {
      const old = value[key];
      if (typeof old === "string") return withValue(within, pointerOf(id, key), change(old));
      if (isArray(old)) return withValue(within, pointerOf(id, key), old.map((each) => change(textOf(each))));
      return within;
    }, before);
  }, data);
}

/** Return data in which an entry has another name, and all that refers to it follows. */
export function renameEntry(schema: JsonObject, data: Model, id: EntryId, name: string): Model {
  const entry = entryAt(data, id);
  if (entry === null || entry.name === name) return data;
  const key = layoutNameOf(id, name);
  if (entry.section === INPUTS) return renameInLayout(renameInput(schema, data, Number(id.split("/")[1]), name), layoutNameOf(id, entry.name), key);
  const read = renameOutputs(renameReadings(schema, data, entry, name), entry, name);
  const named = withValue(read, pointerOf(id, "name"), name);
  const started = withRenamedInitial(named, entry, name);
  if (entry.section !== "body") return renameInLayout(started, entry.name, key);
  const referred = changedReferences(started, (text) => {
    const reference = referenceOf(text);
    return reference.body === entry.name ? referenceText({ ...reference, body: name }) : text;
  });
  return renameInLayout(referred, entry.name, name);
}

/** Return whether an entry lends its name to symbols: signals do, and joints whose coordinates have no names. */
function namesSymbols({ section, value }: Entry): boolean {
  return SIGNALS.includes(section) || (section === "joint" && value["coordinate"] === undefined && value["coordinates"] === undefined);
}

/** Return data in whose formulas all that is called after an entry, such as the current of a motor, has its new name. */
function renameReadings(schema: JsonObject, data: Model, entry: Entry, name: string): Model {
  if (!namesSymbols(entry)) return data;
  const read = wiresOf(data).filter((each) => each.source === entry.id).flatMap((each) => each.roots);
  const symbols = new Set([...(SIGNALS.includes(entry.section) ? [entry.name] : []), ...read]);
  return [...symbols].filter((each) => each.startsWith(entry.name)).reduce((before, symbol) => (
    renameInFormulas(schema, before, symbol, name + symbol.slice(entry.name.length))
  ), data);
}

/** Return data in which signals read the outputs of an element, or of one of its frames, under a new name. */
function renameOutputs(data: Model, { id, name: before }: Entry, after: string, frame = ""): Model {
  return wiresOf(data).filter((each) => each.source === id && each.target.startsWith("signal/")).reduce((within, { target, names }) => {
    const pointer = pointerOf(target, "output");
    const words = textOf(valueAt(within, pointer)).split(" ");
    const isOwn = (word: string): boolean => names.includes(word) && (frame === "" ? word === before || word.startsWith(`${before}.`) : word === `${before}.${frame}`);
    if (!words.some(isOwn)) return within;
    const changed = words.map((word) => (isOwn(word) ? (frame === "" ? after + word.slice(before.length) : `${before}.${after}`) : word));
    return withValue(within, pointer, changed.join(" "));
  }, data);
}

export function renameFrame(data: Model, id: EntryId, before: string, after: string): Model {
  const body = id === GROUND ? GROUND : (entryAt(data, id)?.name ?? "");
  const entry = entryAt(data, id);
  const read = entry === null ? data : renameOutputs(data, entry, after, before);
  const keyed = withKey(read, pointerOf(id, "frames"), before, after);
  const referred = changedReferences(keyed, (text) => text === `${body}.${before}` ? `${body}.${after}` : text);
  return withKey(referred, "/layout/sides", `${body}.${before}`, `${body}.${after}`);
}

/** Return data in which a coordinate has another name: in its joint, in initial values, couplings and formulas. */
export function renameCoordinate(schema: JsonObject, data: Model, before: string, after: string): Model {
  const changed = entriesOf(data).reduce((within, { id, value }) => {
    const names = value["coordinates"];
    const coupled = value["coupled"];
    let next = within;
    if (value["coordinate"] === before) next = withValue(next, pointerOf(id, "coordinate"), after);
    if (isArray(names)) next = withValue(next, pointerOf(id, "coordinates"), swapped(names, before, after));
    if (isArray(coupled)) next = withValue(next, pointerOf(id, "coupled"), swapped(coupled, before, after));
    for (const key of ["force", "torque", "motion"]) next = withKey(next, pointerOf(id, key), before, after);
    return next;
  }, data);
  return renameInFormulas(schema, renameInitial(changed, before, after), before, after);
}

function swapped(names: readonly Json[], before: string, after: string): Json[] {
  return names.map((each) => (each === before ? after : each));
}

export function renameInitial(data: Model, before: string, after: string): Model {
  return withKey(withKey(data, "/initial", before, after), "/initial", `${before}_dot`, `${after}_dot`);
}

export function renameParameter(schema: JsonObject, data: Model, before: string, after: string): Model {
  return renameInFormulas(schema, withKey(data, "/parameters", before, after), before, after);
}

export function renameInput(schema: JsonObject, data: Model, index: number, after: string): Model {
  const before = textOf(valueAt(data, `/inputs/${index}`));
  return renameInFormulas(schema, withValue(data, `/inputs/${index}`, after), before, after);
}

/** Return data in which a symbol has another name in every formula; a text that is none stands in no formula as a name. */
export function renameInFormulas(schema: JsonObject, data: Model, before: string, after: string): Model {
  if (!isSymbol(before) || !isSymbol(after)) return data;
  const letter = "[\\w\\u0080-\\u{10ffff}]";
  const word = new RegExp(`(?<!${letter}|\\.)${before}(_dot)?(?!${letter}|\\s*\\()`, "gu"); // before a bracket it is a function
  return mapFormulas(schema, schema, data, (text) => text.replace(word, (_, rate: string | undefined) => after + (rate ?? ""))) as Model;
}

function renameInLayout(data: Model, before: string, after: string): Model {
  const moved = withKey(data, "/layout/nodes", before, after);
  const sides = valueAt(moved, "/layout/sides");
  if (!isObject(sides)) return moved;
  const entries = Object.entries(sides).map(([key, side]) => {
    const reference = referenceOf(key);
    return [reference.body === before ? referenceText({ ...reference, body: after }) : key, side] as const;
  });
  return withValue(moved, "/layout/sides", Object.fromEntries(entries));
}
