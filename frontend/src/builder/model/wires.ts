/** Who reads what of whom, as the server reads the formulas of a model. */

import { entriesOf, textOf, type EntryId } from "./entries";
import { isArray } from "./pointers";
import type { Model, ServedWire } from "../types";

/** From what brings names to what reads them. */
export interface Wire {
  readonly source: EntryId;
  readonly target: EntryId;
  /** As the formulas write them. */
  readonly names: readonly string[];
  /** The symbols whose rates the names are, or the names themselves. */
  readonly roots: readonly string[];
}

interface Known {
  readonly of: Model;
  readonly wires: readonly ServedWire[];
}

let known: Known = { of: {}, wires: [] };
let carried = new WeakMap<Model, readonly Wire[]>();

/** Keep the wires of a model, which the server read. */
export function keepWires(of: Model, wires: readonly ServedWire[]): void {
  known = { of, wires };
  carried = new WeakMap();
}

/** Return the wires of a model: those that were read last, by the entries that are in it now. */
export function wiresOf(data: Model): readonly Wire[] {
  const before = carried.get(data);
  if (before !== undefined) return before;
  const placeOf = places(known.of, data);
  const wires = known.wires.flatMap(({ source, target, names, roots }) => {
    const [from, to] = [placeOf(source.slice(1)), placeOf(target.slice(1))];
    return from === null || to === null ? [] : [{ source: from, target: to, names, roots }];
  });
  carried.set(data, wires);
  return wires;
}

/** Return where entries of one model are in another, by their names; renamed ones by their places. */
function places(before: Model, data: Model): (id: EntryId) => EntryId | null {
  if (before === data) return (id) => id;
  const [old, now] = [namesByPlace(before), namesByPlace(data)];
  const byName = new Map([...now].map(([id, name]) => [`${sectionOf(id)} ${name}`, id]));
  const counts = (names: ReadonlyMap<EntryId, string>, section: string): number => [...names.keys()].filter((id) => sectionOf(id) === section).length;
  return (id) => {
    const name = old.get(id);
    if (name === undefined) return null;
    const section = sectionOf(id);
    return now.get(id) === name ? id : (byName.get(`${section} ${name}`) ?? (counts(old, section) === counts(now, section) ? id : null));
  };
}

function sectionOf(id: EntryId): string {
  return id.slice(0, id.indexOf("/"));
}

function namesByPlace(data: Model): ReadonlyMap<EntryId, string> {
  const inputs = data["inputs"];
  const named = isArray(inputs) ? inputs.map((each, index) => [`inputs/${index}`, textOf(each)] as const) : [];
  return new Map([...entriesOf(data).map(({ id, name }) => [id, name] as const), ...named]);
}
