/** New names that the user gave, where nothing else has them. */

import { entryAt, INPUTS, namesOf, PART, symbolsOf, type EntryId } from "./model/entries";
import { SIGNALS } from "./model/graph";
import { renameEntry } from "./model/rename";
import { edit, endGesture, say, useStore } from "./store";

/** Return why an entry cannot have a name, or "" where it can. */
export function refusalOfName(id: EntryId, name: string): string {
  const { data } = useStore.getState();
  const before = entryAt(data, id)?.name;
  if (name === "") return "A name is needed.";
  const section = id.split("/")[0]!;
  if (section === PART) return "A part keeps its prefix here: change it in the file.";
  if (name !== before && section !== INPUTS && namesOf(data).has(name)) return `${name} is another element's name.`;
  if (name !== before && [INPUTS, ...SIGNALS].includes(section) && symbolsOf(data).has(name)) return `${name} is another symbol's name.`;
  return /[./\s]/.test(name) && /[./]/.test(name) ? "A name has no dot and no slash." : "";
}

/** Give an entry a name; return whether it has it now. */
export function acceptName(id: EntryId, text: string): boolean {
  const name = text.trim();
  const refusal = refusalOfName(id, name);
  if (refusal !== "") {
    say(refusal);
    return false;
  }
  const { schema } = useStore.getState();
  endGesture();
  edit((data) => renameEntry(schema?.schema ?? {}, data, id, name));
  return true;
}
