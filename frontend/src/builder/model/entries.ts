/** The entries of a model: bodies, joints and all other elements, by their places. */

import { isArray, isObject, joinPointer, splitPointer, valueAt } from "./pointers";
import type { Json, JsonObject, Model } from "../types";

export const GROUND = "ground";
/** The section of parts, which are files of their own. */
export const PART = "include";
/** The section of inputs, which are names alone. */
export const INPUTS = "inputs";
/** What new frames are called, the first that is free. */
export const FRAME_NAMES: readonly string[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ".split("");

/** The place of an entry, such as "joint/2", or "ground". */
export type EntryId = string;

export interface Entry {
  readonly id: EntryId;
  readonly section: string;
  readonly name: string;
  readonly type: string;
  readonly value: JsonObject;
}

/** Return all entries of all sections, in the order of the file; the ground is none of them. */
export function entriesOf(data: Model): Entry[] {
  return Object.entries(data).flatMap(([section, items]) => {
    if (!isArray(items) || !items.every(isObject)) return [];
    return items.map((value, index) => entryOf(section, index, value));
  });
}

function entryOf(section: string, index: number, value: JsonObject): Entry {
  const name = textOf(value[section === PART ? "prefix" : "name"]);
  return { id: `${section}/${index}`, section, name, type: textOf(value["type"]), value };
}

/** Return the inputs, which have no fields. */
export function inputsOf(data: Model): Entry[] {
  const inputs = data[INPUTS];
  return (isArray(inputs) ? inputs : []).flatMap((_, index) => entryAt(data, `${INPUTS}/${index}`) ?? []);
}

/** Return the name under which the layout keeps what an entry is drawn as; no other entry has it. */
export function layoutNameOf(id: EntryId, name: string): string {
  const section = id.split("/")[0]!;
  return id === GROUND ? GROUND : section === INPUTS || section === PART ? `${section}.${name}` : name;
}

export function textOf(value: Json | undefined): string {
  return typeof value === "string" ? value : typeof value === "number" ? String(value) : "";
}

export function entryAt(data: Model, id: EntryId): Entry | null {
  const [section, index] = id.split("/");
  const value = valueAt(data, `/${id}`);
  if (section === INPUTS && typeof value === "string") return { id, section, name: value, type: "", value: {} };
  if (section === undefined || index === undefined || !isObject(value)) return null;
  return entryOf(section, Number(index), value);
}

export function entryNamed(data: Model, name: string, sections?: readonly string[]): Entry | null {
  return entriesOf(data).find((each) => each.name === name && (sections?.includes(each.section) ?? true)) ?? null;
}

/** Return the place of the entry that a pointer leads into, or null for the model's own fields. */
export function entryOfPointer(pointer: string): EntryId | null {
  const [section, index] = splitPointer(pointer);
  if (section === GROUND) return GROUND;
  return section !== undefined && index !== undefined && /^\d+$/.test(index) ? `${section}/${index}` : null;
}

export function pointerOf(id: EntryId, ...parts: (string | number)[]): string {
  return joinPointer(...id.split("/"), ...parts);
}

/** A frame as the file refers to it: "Crank.A", "Crank" for its axes at the centre of mass, "ground". */
export interface Reference {
  readonly body: string;
  readonly frame: string;
}

export function referenceOf(text: string): Reference {
  const dot = text.indexOf(".");
  return dot < 0 ? { body: text, frame: "" } : { body: text.slice(0, dot), frame: text.slice(dot + 1) };
}

export function referenceText({ body, frame }: Reference): string {
  return frame === "" ? body : `${body}.${frame}`;
}

/** Return the references that an entry joins: its start and end, or what it acts on and what takes the reaction. */
export function endsOf(value: JsonObject): [string, string] | null {
  const between = value["between"];
  if (isArray(between) && between.length === 2) return [textOf(between[0]), textOf(between[1])];
  const on = value["on"];
  if (typeof on === "string") return [textOf(value["reaction_on"] ?? GROUND), on];
  return null;
}

export function framesOf(data: Model, id: EntryId): string[] {
  const frames = valueAt(data, pointerOf(id, "frames"));
  return isObject(frames) ? Object.keys(frames) : [];
}

/** Return every frame that an element can join, the ground's first. */
export function allReferences(data: Model): string[] {
  const bodies = entriesOf(data).filter((each) => each.section === "body");
  const owners = [{ id: GROUND, name: GROUND }, ...bodies];
  return owners.flatMap(({ id, name }) => [name, ...framesOf(data, id).map((frame) => `${name}.${frame}`)]);
}

/** Return a name like `base` that none of `taken` is. */
export function freeName(base: string, taken: ReadonlySet<string>): string {
  if (!taken.has(base) && base !== "") return base;
  const stem = base.replace(/\d+$/, "");
  let number = 1;
  while (taken.has(`${stem}${number}`)) number += 1;
  return `${stem}${number}`;
}

/** Return the names that formulas can contain, as far as the file has them. */
export function symbolsOf(data: Model): Set<string> {
  const parameters = data["parameters"];
  const coordinates = entriesOf(data).flatMap(({ value }) => [value["coordinate"], ...(isArray(value["coordinates"]) ? value["coordinates"] : [])]);
  return new Set([...Object.keys(isObject(parameters) ? parameters : {}), ...inputsOf(data).map((each) => each.name), ...coordinates.map(textOf)]);
}

export function namesOf(data: Model): Set<string> {
  return new Set([GROUND, ...entriesOf(data).map((each) => each.name)]);
}
