/** New elements of the model. */

import { api } from "../api";
import { showNode } from "../diagram/flow";
import { addElement, addFrame } from "../model/edit";
import { entryAt, GROUND, type EntryId } from "../model/entries";
import { isObject } from "../model/pointers";
import { definitionNode } from "../model/schema";
import type { Spot } from "../model/layout";
import { edit, endGesture, select, useStore } from "../store";
import type { JsonObject, Model, PaletteElement } from "../types";

export type Ends = readonly [string, string];

/** Whether an element joins two frames, so that it is an edge of the diagram. */
export function joins(element: PaletteElement): boolean {
  const { schema } = useStore.getState();
  if (schema === null) return false;
  const properties = definitionNode(schema.schema, element.definition)["properties"];
  return isObject(properties) && (properties["between"] !== undefined || properties["on"] !== undefined);
}

/** Return what a new edge joins where nothing says so: the selected bodies, else the ground and the last body. */
export function likelyEnds(data: Model, selection: readonly EntryId[]): Ends {
  const bodies = selection.filter((id) => id === GROUND || id.startsWith("body/"));
  const names = bodies.map((id) => (id === GROUND ? GROUND : (entryAt(data, id)?.name ?? GROUND)));
  if (names.length >= 2) return [names[0]!, names[1]!];
  if (names.length === 1 && names[0] !== GROUND) return [GROUND, names[0]!];
  const list = data["body"];
  const last = Array.isArray(list) ? entryAt(data, `body/${list.length - 1}`)?.name : undefined;
  return [GROUND, last ?? GROUND];
}

export function insertElement(section: string, type: string, spot: Spot | null = null, ends: Ends | null = null): void {
  const { schema, data, selection } = useStore.getState();
  if (schema === null) return;
  const element = schema.elements.find((each) => each.section === section && each.type === type);
  if (element === undefined) return;
  const joined = joins(element) ? (ends ?? likelyEnds(data, selection)) : null;
  const { data: next, ids } = addElement(schema.schema, data, element, joined, spot);
  endGesture();
  edit(() => next);
  useStore.setState({ popup: null });
  const [id] = ids;
  select(ids, `${element.title} added`);
  if (spot === null && joined === null) showNode(id!);
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
