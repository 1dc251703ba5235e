/** New names that the user gave, where nothing else has them. */

import { entryAt, framesOf, INPUTS, namesOf, PART, type EntryId } from "./model/entries";
import { SIGNALS } from "./model/graph";
import { elementRefusal, formulaNames, symbolRefusal } from "./model/names";
import { renameEntry, renameFrame } from "./model/rename";
import type { Json, JsonObject, Model } from "./types";
import { edit, endGesture, say, useStore } from "./store";

/** Return what is a symbol now, also what the model does not name itself. */
function symbolsNow(): Set<string> {
  const { data, check } = useStore.getState();
  return formulaNames(data, [...(check?.summary?.coordinates ?? []), ...(check?.summary?.speeds ?? [])]);
}

function takenBy(name: string, kind: string): string {
  return `${name} is another ${kind}'s name.`;
}

/** Return why an entry cannot have a name, or "" where it can: elements are apart from symbols, but those that are symbols. */
export function refusalOfName(id: EntryId, name: string): string {
  const { data } = useStore.getState();
  if (id.startsWith(`${PART}/`)) return "The prefix of a part cannot be changed here: change it in the file.";
  if (name === entryAt(data, id)?.name) return "";
  const section = id.split("/")[0]!;
  if (section !== INPUTS && namesOf(data).has(name)) return takenBy(name, "element");
  return section === INPUTS || SIGNALS.includes(section) ? refusalOfSymbol(name) : elementRefusal(name);
}

function refusalOfSymbol(name: string): string {
  return symbolRefusal(name) || (symbolsNow().has(name) ? takenBy(name, "symbol") : "");
}

/** Make a change where nothing speaks against it; return what does, or "". */
function accept(refusal: string, change: (schema: JsonObject, data: Model) => Model): string {
  if (refusal !== "") {
    say(refusal);
    return refusal;
  }
  const { schema } = useStore.getState();
  if (schema === null) return "The page is still loading."; // it says where formulas are
  endGesture();
  edit((data) => change(schema.schema, data));
  return "";
}

/** Give an entry a name; return why it cannot have it, or "". */
export function acceptName(id: EntryId, text: string): string {
  const name = text.trim();
  return accept(refusalOfName(id, name), (schema, data) => renameEntry(schema, data, id, name));
}

/** Give a parameter or a coordinate a name, in all formulas; return why it cannot have it, or "". */
export function acceptSymbol(before: string, text: string, rename: (schema: JsonObject, data: Model, before: string, after: string) => Model): string {
  const name = text.trim();
  if (name === before) return "";
  return accept(refusalOfSymbol(name), (schema, data) => rename(schema, data, before, name));
}

/** Give a frame a name; return why it cannot have it, or "". */
export function acceptFrameName(id: EntryId, before: string, text: string): string {
  const name = text.trim();
  const taken = name !== before && framesOf(useStore.getState().data, id).includes(name);
  const refusal = elementRefusal(name) || (taken ? takenBy(name, "frame") : "");
  return accept(refusal, (_, data) => renameFrame(data, id, before, name));
}

/** Give a row of a table another key, which no other row has; return why it cannot have it, or "". */
export function acceptKey(rows: Json | undefined, before: string, text: string, rename: (data: Model, before: string, after: string) => Model): string {
  const name = text.trim();
  const taken = typeof rows === "object" && rows !== null && name !== before && name in rows;
  const refusal = name === "" ? "A name is needed." : taken ? `${name} already exists.` : "";
  return accept(refusal, (_, data) => rename(data, before, name));
}
