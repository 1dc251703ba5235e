/** What couples coordinates, and the joints whose coordinates they are. */

import { textOf, type Entry, type EntryId } from "./entries";
import { isArray, isObject } from "./pointers";
import type { Json } from "../types";

/** A coupling and a joint, by one coordinate of the joint that the coupling contains. */
export interface CouplingLink {
  readonly coupling: EntryId;
  readonly joint: EntryId;
  readonly coordinate: string;
}

const NAME = /[\p{L}_][\p{L}\p{N}_]*/gu;
const RATE = /_d?dot$/;

/** Return the joint of each coordinate that the file names. */
function namedCoordinates(joints: readonly Entry[]): Map<string, EntryId> {
  const owners = new Map<string, EntryId>();
  for (const { id, value } of joints) {
    const names = isArray(value["coordinates"]) ? value["coordinates"] : [value["coordinate"]];
    for (const name of names.map(textOf)) if (name !== "" && !owners.has(name)) owners.set(name, id);
  }
  return owners;
}

/** Return the joint that a coordinate without a name of its own is called after: the longest name counts. */
function namesake(joints: readonly Entry[], coordinate: string): EntryId | null {
  const nameless = joints.filter(({ value }) => value["coordinate"] === undefined && value["coordinates"] === undefined);
  const fitting = nameless.filter(({ name }) => name !== "" && (coordinate === name || coordinate.startsWith(`${name}_`)));
  return fitting.sort((one, other) => other.name.length - one.name.length)[0]?.id ?? null;
}

/** Return all names in the formulas of an entry. */
function wordsIn(value: Json | undefined): string[] {
  if (typeof value === "string") return value.match(NAME) ?? [];
  if (isArray(value)) return value.flatMap(wordsIn);
  if (!isObject(value)) return [];
  return Object.entries(value).flatMap(([key, each]) => (key === "name" || key === "type" ? [] : wordsIn(each)));
}

/** Return the links of couplings to joints, one a coordinate. */
export function couplingLinks(entries: readonly Entry[], couplings: readonly Entry[], drawn: ReadonlySet<EntryId>): CouplingLink[] {
  const joints = entries.filter((each) => each.section === "joint");
  const owners = namedCoordinates(joints);
  return couplings.flatMap(({ id, value }) => {
    const words = [...new Set(wordsIn(value).map((word) => word.replace(RATE, "")))];
    return words.flatMap((coordinate) => {
      const joint = owners.get(coordinate) ?? namesake(joints, coordinate);
      return joint !== null && drawn.has(joint) ? [{ coupling: id, joint, coordinate }] : [];
    });
  });
}
