/** New elements of the model. */

import { api } from "../api";
import { focusInDiagram, showNew } from "../diagram/flow";
import { addElement, addFrame } from "../model/edit";
import { entriesOf, entryAt, GROUND, referenceText, type EntryId } from "../model/entries";
import { isObject } from "../model/pointers";
import { joinedBodies, portFor } from "../model/ports";
import { definitionNode } from "../model/schema";
import type { Spot } from "../model/layout";
import { edit, endGesture, select, useStore } from "../store";
import { withTemplates } from "../model/templates";
import type { JsonObject, Model, PaletteElement, SchemaAnswer } from "../types";

export type Ends = readonly [string, string];

/** Whether an element joins two frames, so that it is an edge of the diagram. */
export function joins(element: PaletteElement): boolean {
  const { schema } = useStore.getState();
  if (schema === null) return false;
  const properties = definitionNode(schema.schema, element.definition)["properties"];
  return isObject(properties) && (properties["between"] !== undefined || properties["on"] !== undefined);
}

/** Return what a new edge joins where nothing says so: the selected bodies, else a chain goes on to the selected or the last body. */
export function likelyEnds(data: Model, selection: readonly EntryId[]): Ends {
  const bodies = selection.filter((id) => id === GROUND || id.startsWith("body/"));
  const end = (id: EntryId): string => referenceText({ body: id === GROUND ? GROUND : (entryAt(data, id)?.name ?? GROUND), frame: portFor(data, id) });
  if (bodies.length >= 2) return [end(bodies[0]!), end(bodies[1]!)];
  const list = data["body"];
  const last = Array.isArray(list) && list.length > 0 ? `body/${list.length - 1}` : GROUND;
  const body = bodies.find((each) => each !== GROUND) ?? last;
  return [end(chainBefore(data, body)), end(body)];
}

/** Return what holds a body best: of a body that nothing holds yet the latest one that is held, else the ground. */
function chainBefore(data: Model, body: EntryId): EntryId {
  const names = joinedBodies(data);
  const held = entriesOf(data).filter((each) => each.section === "body" && names.has(each.name)).map((each) => each.id);
  return held.includes(body) ? GROUND : (held.at(-1) ?? GROUND);
}

export function insertElement(section: string, type: string, spot: Spot | null = null, ends: Ends | null = null): void {
  const { schema, data, selection } = useStore.getState();
  if (schema === null) return;
  const element = offered(schema).find((each) => each.section === section && each.type === type);
  if (element === undefined) return;
  insert(schema, element, data, joins(element) ? (ends ?? likelyEnds(data, selection)) : null, spot);
  if (spot === null && ends === null) showNew(useStore.getState().selection[0]!); // placed by the page
}

function insert({ schema }: SchemaAnswer, element: PaletteElement, data: Model, joined: Ends | null, spot: Spot | null): void {
  const { data: next, ids } = addElement(schema, data, element, joined, spot);
  endGesture();
  edit(() => next);
  const byChoice = useStore.getState().popup !== null;
  useStore.setState({ popup: null });
  if (joined !== null) localStorage.setItem(LAST_KEY, nameOf(element));
  const [id] = ids;
  select(ids, `${element.title} added`);
  if (byChoice) focusInDiagram(id!);
}

/** What joins two bodies most often; the rest follows in its own order. */
const USUAL: readonly string[] = ["revolute", "prismatic", "weld", "spherical", "spring"];
const LAST_KEY = "symbody-last-connection";

function nameOf({ section, type }: PaletteElement): string {
  return type === "" ? section : type;
}

/** Return everything that can be added, bodies with a size among it. */
export function offered(schema: SchemaAnswer): readonly PaletteElement[] {
  return withTemplates(schema.elements);
}

/** Return elements with the usual connections in front, what was used last at the very first place. */
export function usualFirst(elements: readonly PaletteElement[]): PaletteElement[] {
  const names = [localStorage.getItem(LAST_KEY) ?? "", ...USUAL];
  const place = (each: PaletteElement): number => (names.indexOf(nameOf(each)) + names.length + 1) % (names.length + 1);
  const first = elements.filter((each) => names.includes(nameOf(each))).sort((one, other) => place(one) - place(other));
  return [...first.map((each) => ({ ...each, group: "Usual" })), ...elements.filter((each) => !names.includes(nameOf(each)))];
}

/** Return elements as the palette lists them: of the joints the usual ones apart from the rest. */
export function forPalette(elements: readonly PaletteElement[]): PaletteElement[] {
  const joints = elements.filter((each) => each.section === "joint");
  const usual = USUAL.flatMap((name) => joints.filter((each) => each.type === name));
  const rest = joints.filter((each) => !usual.includes(each)).map((each) => ({ ...each, group: "More joints" }));
  return elements.flatMap((each) => (each === joints[0] ? [...usual, ...rest] : each.section === "joint" ? [] : [each]));
}

/** Give a body, or the ground, another frame. */
export function insertFrame(id: EntryId): void {
  endGesture();
  edit((data) => addFrame(data, id).data);
  select([id], "Frame added");
}

/** Return elements in the order in which the schema names them: the usual ones first. */
function inSchemaOrder(schema: JsonObject, elements: readonly PaletteElement[]): PaletteElement[] {
  const text = JSON.stringify(schema["properties"]);
  const place = ({ definition }: PaletteElement): number => text.indexOf(`"$ref":"#/$defs/${definition}"`);
  const sections = [...new Set(elements.map((each) => each.section))];
  return sections.flatMap((section) => elements.filter((each) => each.section === section).sort((a, b) => place(a) - place(b)));
}

/** Load what the palette offers. */
export async function loadSchema(): Promise<void> {
  const { schema, elements } = await api.schema();
  useStore.setState({ schema: { schema, elements: inSchemaOrder(schema, elements) } });
}
