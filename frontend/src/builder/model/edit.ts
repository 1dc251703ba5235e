/** Changes of a model as functions of its data. */

import {
  endsOf, entriesOf, entryAt, FRAME_NAMES, framesOf, freeName, GROUND, INPUTS, inputsOf, layoutNameOf, namesOf, PART, pointerOf, referenceOf,
  referenceText, symbolsOf, textOf, type EntryId,
} from "./entries"; // prettier-ignore
import { contactFields, dropped, withFloor } from "./contacts";
import { withoutInitialOf } from "./coordinates";
import { diagramOf, SIGNALS } from "./graph";
import { freeSpot, layoutName, sizeOf, spotsOf, withLayout, type Size, type Spot } from "./layout";
import { isArray, isObject, valueAt, withValue } from "./pointers";
import { joinedBodies } from "./ports";
import { renameInFormulas } from "./rename";
import { choicesOf, definitionNode, isFormula, resolveNode, type SchemaNode } from "./schema";
import { besideOthers, withTemplate } from "./templates";
import type { Json, JsonObject, Model, PaletteElement } from "../types";

const STEP = 40; // by which copies are shifted, or several times as far
const STEPS = 30;

export interface Edited {
  readonly data: Model;
  readonly ids: readonly EntryId[];
}

/** Return an object with no more than its required fields. */
export function leastEntry(schema: JsonObject, node: SchemaNode): JsonObject {
  const properties = isObject(node["properties"]) ? node["properties"] : {};
  const required = isArray(node["required"]) ? node["required"].map(textOf) : [];
  const entries = required.map((key) => [key, leastValue(schema, resolveNode(schema, properties[key]))] as const);
  return Object.fromEntries(entries);
}

/** Return the shortest value that a field accepts, for fields that cannot be left out. */
export function leastValue(schema: JsonObject, node: SchemaNode): Json {
  if (node["default"] !== undefined && node["default"] !== null) return node["default"];
  return leastChoice(schema, choicesOf(schema, node)[0] ?? {});
}

function leastChoice(schema: JsonObject, first: SchemaNode): Json {
  if (first["const"] !== undefined) return first["const"];
  if (isArray(first["enum"])) return first["enum"][0] ?? "";
  if (first["type"] === "array") {
    const count = typeof first["minItems"] === "number" ? first["minItems"] : 0;
    return Array.from({ length: count }, () => leastValue(schema, resolveNode(schema, first["items"])));
  }
  if (first["type"] === "object") return {};
  if (first["type"] === "boolean") return false;
  return isFormula(first) ? "0" : "";
}

/** Return a new entry of an element with all its required fields. */
export function newEntry(schema: JsonObject, element: PaletteElement, name: string, ends: readonly [string, string] | null): JsonObject {
  const node = definitionNode(schema, element.definition);
  const properties = isObject(node["properties"]) ? node["properties"] : {};
  const entry: Record<string, Json> = { name, ...USUAL[element.section] };
  if (properties["type"] !== undefined) entry["type"] = element.type;
  if (ends !== null && properties["between"] !== undefined) entry["between"] = [...ends];
  if (ends !== null && properties["on"] !== undefined) {
    entry["on"] = ends[1];
    if (ends[0] !== GROUND) entry["reaction_on"] = referenceOf(ends[0]).body;
  }
  return { ...leastEntry(schema, node), ...entry };
}

/** A body that nothing is said of yet has to be able to move. */
const USUAL: Readonly<Record<string, JsonObject>> = {
  body: { mass: "1", inertia: ["0.1", "0.1", "0.1"] }, signal: { value: "0" }, table: { points: [["0", "0"], ["1", "1"]] },
};
const STEMS: Readonly<Record<string, string>> = { body: "Body1" };

function stemOf(element: PaletteElement): string {
  if (SIGNALS.includes(element.section)) return `${element.type === "" ? element.section : element.type}1`;
  return STEMS[element.section] ?? `${element.section.charAt(0).toUpperCase()}1`;
}

/** Return data with a further element, its name free of others. */
export function addElement(
  schema: JsonObject, data: Model, element: PaletteElement, ends: readonly [string, string] | null, spot: Spot | null,
): Edited { // prettier-ignore
  const taken = SIGNALS.includes(element.section) ? new Set([...namesOf(data), ...symbolsOf(data)]) : namesOf(data);
  const name = freeName(stemOf(element), taken);
  const items = valueAt(data, `/${element.section}`);
  const list = isArray(items) ? items : [];
  const id = `${element.section}/${list.length}`;
  const before = withLayout(data);
  const plain = (): Model => withValue(before, `/${element.section}`, [...list, newEntry(schema, element, name, ends)]);
  const body = (): Model => besideOthers(withTemplate(before, element.type) ?? plain(), joinedBodies(before));
  const added = element.section === "body" ? body() : element.section === "contact" ? withContact(schema, before, element, name, ends) : plain();
  const graph = diagramOf(added);
  const node = graph.nodes.find((each) => each.id === id);
  if (node === undefined) return { data: added, ids: [id] };
  const others = new Map(spotsOf(added, graph));
  others.delete(id);
  const place = freeSpot(spot ?? nextSpot(others), node, graph, others);
  return { data: withLayout(added, new Map([[id, place]])), ids: [id] };
}

/** Return data with a contact; one of a free body with the ground itself is with its floor, which the body falls on. */
function withContact(schema: JsonObject, data: Model, element: PaletteElement, name: string, ends: readonly [string, string] | null): Model {
  const list = isArray(data["contact"]) ? data["contact"] : [];
  const fields = contactFields(data, ends);
  const [placed, floor] = ends?.[0] === GROUND ? withFloor(data) : [data, ""];
  const joined = ends === null || floor === "" ? ends : ([floor, ends[1]] as const);
  const added = withValue(placed, "/contact", [...list, { ...newEntry(schema, element, name, joined), ...fields }]);
  const body = ends === null ? "" : referenceOf(ends[1]).body;
  return floor === "" || joinedBodies(data).has(body) ? added : dropped(added, body);
}

/** Return the place to the right of all that is there. */
function nextSpot(others: ReadonlyMap<string, Spot>): Spot {
  const spots = [...others.values()];
  const last = spots.reduce<Spot>((far, each) => (each[0] > far[0] ? each : far), [-160, 60]);
  return [last[0] + 220, last[1]];
}

export function addFrame(data: Model, id: EntryId, name = ""): Edited {
  const taken = new Set(framesOf(data, id));
  const free = name !== "" && !taken.has(name) ? name : (FRAME_NAMES.find((each) => !taken.has(each)) ?? freeName("F1", taken));
  const frames = valueAt(data, pointerOf(id, "frames"));
  const added = withValue(data, pointerOf(id, "frames"), { ...(isObject(frames) ? frames : {}), [free]: { at: ["0", "0", "0"] } });
  return { data: added, ids: [id] };
}

/** Return data without a frame; what was joined there is joined to the body itself. */
export function removeFrame(data: Model, id: EntryId, frame: string): Model {
  const body = id === GROUND ? GROUND : (entryAt(data, id)?.name ?? "");
  const moved = entriesOf(data).reduce<Model>((within, entry) => rejoined(within, entry.id, `${body}.${frame}`, body), data);
  return withValue(moved, pointerOf(id, "frames", frame), undefined);
}

function rejoined(data: Model, id: EntryId, from: string, to: string): Model {
  const entry = entryAt(data, id)!.value;
  const between = entry["between"];
  if (isArray(between)) return withValue(data, pointerOf(id, "between"), between.map((each) => (each === from ? to : each)));
  return entry["on"] === from ? withValue(data, pointerOf(id, "on"), to) : data;
}

/** Return data whose edge joins other frames. */
export function reconnect(data: Model, id: EntryId, start: string, end: string): Model {
  const entry = entryAt(data, id);
  if (entry === null) return data;
  if (entry.value["between"] !== undefined) return withValue(data, pointerOf(id, "between"), [start, end]);
  return withValue(withValue(data, pointerOf(id, "on"), end), pointerOf(id, "reaction_on"), referenceOf(start).body);
}

/** Return data without some entries and without all that joined the bodies among them. */
export function removeEntries(data: Model, ids: readonly EntryId[]): Model {
  const removed = new Set(ids.filter((id) => id !== GROUND));
  const gone = new Set([...removed].flatMap((id) => (id.startsWith("body/") ? [entryAt(data, id)?.name ?? ""] : [])));
  if (removed.size === 0) return data;
  for (const { id, value } of entriesOf(data)) {
    const ends = endsOf(value);
    if (ends?.some((end) => gone.has(referenceOf(end).body))) removed.add(id);
  }
  const before = withLayout(data);
  const names = new Set([...removed].map((id) => layoutNameOf(id, entryAt(data, id)?.name ?? "")));
  const kept = Object.entries(before).map(([section, items]): [string, Json] => {
    return isArray(items) ? [section, items.filter((_, index) => !removed.has(`${section}/${index}`))] : [section, items];
  });
  const cut = withoutInitialOf(Object.fromEntries(kept), [...removed].map((id) => entryAt(data, id)).filter((each) => each !== null));
  const left = new Set([...entriesOf(cut), ...inputsOf(cut)].map(({ id, name }) => layoutNameOf(id, name)));
  const spots = valueAt(cut, "/layout/nodes");
  if (!isObject(spots)) return cut;
  return withValue(cut, "/layout/nodes", Object.fromEntries(Object.entries(spots).filter(([name]) => left.has(name) || !names.has(name))));
}

/** What is copied: entries of sections, with the places of bodies. */
export interface Copied {
  readonly entries: readonly { readonly section: string; readonly value: JsonObject; readonly spot: Spot | null }[];
}

export function copyEntries(data: Model, ids: readonly EntryId[]): Copied {
  const spots = spotsOf(data, diagramOf(data));
  const bodies = new Set(ids.flatMap((id) => (id.startsWith("body/") ? [entryAt(data, id)?.name ?? ""] : [])));
  const chosen = new Set(ids.filter((id) => id !== GROUND && !id.startsWith(`${PART}/`) && !id.startsWith(`${INPUTS}/`)));
  // what joins two copied bodies goes with them
  for (const { id, value } of entriesOf(data)) {
    const ends = endsOf(value)?.map((each) => referenceOf(each).body);
    if (ends !== undefined && bodies.size > 1 && ends.every((each) => bodies.has(each))) chosen.add(id);
  }
  const entries = [...chosen].map((id) => entryAt(data, id)).filter((each) => each !== null);
  return { entries: entries.map(({ id, section, value }) => ({ section, value, spot: spots.get(id) ?? null })) };
}

/** Return data with copies under free names; connections among copied bodies join the copies, copied signals read each other. */
export function pasteEntries(schema: JsonObject, data: Model, { entries }: Copied): Edited {
  const shift = freeShift(data, entries.flatMap(({ spot }) => (spot === null ? [] : [spot])));
  const taken = new Set([...namesOf(data), ...symbolsOf(data)]);
  const names = new Map<string, string>();
  for (const { value } of entries) {
    const name = freeName(textOf(value["name"]), taken);
    taken.add(name);
    names.set(textOf(value["name"]), name);
  }
  const bodies = new Set(entries.flatMap(({ section, value }) => (section === "body" ? [textOf(value["name"])] : [])));
  const signals = entries.flatMap(({ section, value }) => (SIGNALS.includes(section) ? [textOf(value["name"])] : []));
  let next = withLayout(data);
  const ids: EntryId[] = [];
  const places = new Map<EntryId, Spot>();
  for (const { section, value, spot } of entries) {
    const items = valueAt(next, `/${section}`);
    const list = isArray(items) ? items : [];
    const id = `${section}/${list.length}`;
    next = withValue(next, `/${section}`, [...list, copyOf(withNewSignals(schema, section, value, signals, names), names, bodies)]);
    ids.push(id);
    if (spot !== null) places.set(id, [spot[0] + shift[0], spot[1] + shift[1]]);
  }
  return { data: withLayout(next, places), ids };
}

/** Return an entry whose formulas read the copies of signals. */
function withNewSignals(schema: JsonObject, section: string, value: JsonObject, signals: readonly string[], names: ReadonlyMap<string, string>): JsonObject {
  const renamed = signals.reduce<Model>((before, name) => renameInFormulas(schema, before, name, names.get(name)!), { [section]: [value] });
  const copy = valueAt(renamed, `/${section}/0`);
  return isObject(copy) ? copy : value;
}

/** Return the least shift, down to the right, by which copies of nodes lie on no other node. */
function freeShift(data: Model, spots: readonly Spot[]): Spot {
  const graph = diagramOf(data);
  const places = spotsOf(data, graph);
  const boxes = graph.nodes.map((node) => ({ at: places.get(node.id)!, ...sizeOf(node) }));
  const sizeAt = (spot: Spot): Size => boxes.find(({ at }) => at[0] === spot[0] && at[1] === spot[1]) ?? { width: 0, height: 0 };
  const isFree = (step: number): boolean => spots.every((spot) => {
    const [{ width, height }, x, y] = [sizeAt(spot), spot[0] + step, spot[1] + step];
    return boxes.every(({ at, ...size }) => x >= at[0] + size.width || at[0] >= x + width || y >= at[1] + size.height || at[1] >= y + height);
  });
  const step = Array.from({ length: STEPS }, (_, k) => (k + 1) * STEP).find(isFree) ?? STEP;
  return [step, step];
}

function copyOf(value: JsonObject, names: ReadonlyMap<string, string>, bodies: ReadonlySet<string>): JsonObject {
  const renamed = (text: Json): Json => {
    const reference = referenceOf(textOf(text));
    return bodies.has(reference.body) ? referenceText({ ...reference, body: names.get(reference.body)! }) : text;
  };
  const copy: Record<string, Json> = { ...value, name: names.get(textOf(value["name"]))! };
  for (const key of ["coordinate", "coordinates", "speed_names"]) Reflect.deleteProperty(copy, key); // they would be named twice
  if (isArray(copy["between"])) copy["between"] = copy["between"].map(renamed);
  for (const key of ["on", "reaction_on", "resolved_in"]) if (copy[key] !== undefined) copy[key] = renamed(copy[key]);
  return copy;
}

/** Return data whose element has another type; fields that the new one lacks are left out. */
export function changeType(schema: JsonObject, data: Model, id: EntryId, element: PaletteElement): Model {
  const entry = entryAt(data, id);
  if (entry === null) return data;
  const fresh = newEntry(schema, element, entry.name, endsOf(entry.value));
  const properties = definitionNode(schema, element.definition)["properties"];
  const fits = Object.entries(entry.value).filter(([key]) => isObject(properties) && properties[key] !== undefined);
  return withValue(data, `/${id}`, { ...fresh, ...Object.fromEntries(fits), ...("type" in fresh ? { type: element.type } : {}) });
}

/** Return the name of the entry as the layout keeps it. */
export function layoutKey(data: Model, id: EntryId): string {
  const node = diagramOf(data).nodes.find((each) => each.id === id);
  return node === undefined ? "" : layoutName(node);
}
