/** Copy, paste, delete and their like, of what is selected. */

import { copyEntries, pasteEntries, removeEntries } from "../model/edit";
import { entriesOf, GROUND, inputsOf } from "../model/entries";
import { forgetArrangement, withoutLayout } from "../model/layout";
import { patched } from "../model/pointers";
import { fitDiagram } from "../diagram/flow";
import { edit, endGesture, say, select, useStore } from "../store";
import type { Model, Problem } from "../types";

export function copySelection(): void {
  const { data, selection } = useStore.getState();
  const copied = copyEntries(data, selection);
  if (copied.entries.length === 0) return;
  useStore.setState({ copied });
  say(`${copied.entries.length} copied`);
}

export function paste(): void {
  const { copied, data } = useStore.getState();
  if (copied === null) return;
  endGesture();
  const { data: next, ids } = pasteEntries(data, copied);
  edit(() => next);
  select(ids, `${ids.length} pasted`);
  // the next paste goes beside this one
  useStore.setState({ copied: { entries: copied.entries.map((each) => ({ ...each, spot: each.spot === null ? null : [each.spot[0] + 40, each.spot[1] + 40] })) } });
}

export function duplicate(): void {
  const { data, selection } = useStore.getState();
  const copied = copyEntries(data, selection);
  if (copied.entries.length === 0) return;
  endGesture();
  const { data: next, ids } = pasteEntries(data, copied);
  edit(() => next);
  select(ids, `${ids.length} duplicated`);
}

export function removeSelection(): void {
  const { selection, data } = useStore.getState();
  if (selection.length === 1 && selection[0] === GROUND) {
    say("The ground stays.");
    return;
  }
  endGesture();
  const next = removeEntries(data, selection);
  if (next === data) return;
  select([]);
  edit(() => next);
  const countOf = (model: Model): number => entriesOf(model).length + inputsOf(model).length;
  say(`${countOf(data) - countOf(next)} deleted`);
}

export function cutSelection(): void {
  copySelection();
  removeSelection();
}

export function selectAll(): void {
  const { data } = useStore.getState();
  const ids = [...entriesOf(data), ...inputsOf(data)].map((each) => each.id);
  select([GROUND, ...ids], `${ids.length + 1} selected`);
}

export function renameSelection(): void {
  const [id] = useStore.getState().selection;
  if (id !== undefined && id !== GROUND) useStore.setState({ renaming: id, popup: null });
}

/** Arrange the whole diagram anew. */
export function arrange(): void {
  endGesture();
  forgetArrangement();
  edit(withoutLayout);
  setTimeout(fitDiagram, 30); // when the nodes are where they belong
}

export function repair(problem: Problem): void {
  const { repair: offered } = problem;
  if (offered === null) return;
  endGesture();
  edit((data) => patched(data, offered.patch));
  say(`${offered.label}: done`);
}
