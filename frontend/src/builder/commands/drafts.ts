/** Drafts of edits: with the server, and where it is out of reach in the browser. */

import { api, problemsOf } from "../api";
import { adopt } from "../connection";
import { isDirty, useStore, type OpenDocument } from "../store";
import type { Draft, Model } from "../types";
import { openModel } from "./files";

const DRAFT_WAIT = 1500; // [ms]
const PREFIX = "symbody-draft-";

interface LocalDraft extends Draft {
  readonly data: Model;
  readonly fingerprint: string | null;
}

/** Keep a draft of edits; return what ends it. */
export function keepDrafts(): () => void {
  let wait: ReturnType<typeof setTimeout> | null = null;
  const unfollow = useStore.subscribe((state, before) => {
    if (state.document === null) return;
    const edited = state.data !== before.data && state.document.id === before.document?.id;
    const reached = state.server === "here" && before.server !== "here";
    if (state.saved !== before.saved) forget(state.document.id);
    if (!edited && !reached) return;
    if (wait !== null) clearTimeout(wait);
    wait = setTimeout(() => { void sendDraft(); }, reached ? 0 : DRAFT_WAIT);
  });
  window.addEventListener("pagehide", rememberEdits);
  return () => {
    unfollow();
    window.removeEventListener("pagehide", rememberEdits);
  };
}

async function sendDraft(): Promise<void> {
  const { document, data } = useStore.getState();
  if (document === null || !isDirty(useStore.getState())) return;
  try {
    await api.draft(document.id, data);
    forget(document.id);
  } catch {
    remember(document, data);
  }
}

/** A page that is left within the wait has its last edits in the browser. */
function rememberEdits(): void {
  const state = useStore.getState();
  if (state.document !== null && isDirty(state)) remember(state.document, state.data);
}

function remember({ id, path, name, fingerprint }: OpenDocument, data: Model): void {
  const draft: LocalDraft = { id, path, name, when: new Date().toISOString(), data, fingerprint };
  try {
    localStorage.setItem(PREFIX + id, JSON.stringify(draft));
  } catch {
    // a browser that stores nothing, or has no room: the page still has the edits
  }
}

function forget(id: string): void {
  localStorage.removeItem(PREFIX + id);
}

function readLocal(key: string): LocalDraft | null {
  try {
    const draft = JSON.parse(localStorage.getItem(key) ?? "null") as LocalDraft | null;
    return draft !== null && typeof draft.id === "string" && typeof draft.data === "object" ? draft : null;
  } catch {
    return null;
  }
}

function localDrafts(): LocalDraft[] {
  const keys = Object.keys(localStorage).filter((key) => key.startsWith(PREFIX));
  return keys.map(readLocal).filter((each) => each !== null);
}

/** Return all drafts, the newest first; of one document the newest. */
export function mergedDrafts(served: readonly Draft[], local: readonly Draft[] = localDrafts()): Draft[] {
  const newest = new Map<string, Draft>();
  for (const each of [...served, ...local]) {
    const before = newest.get(each.id);
    if (before === undefined || before.when < each.when) newest.set(each.id, each);
  }
  return [...newest.values()].sort((one, other) => (one.when < other.when ? 1 : -1));
}

/** Open a draft; one of the browser goes to the server first. */
export async function openDraft({ id, when }: Draft): Promise<boolean> {
  const local = readLocal(PREFIX + id);
  if (local !== null && local.when === when) {
    try {
      const isWithinReach = await adopt(id, local.path, local.name, local.fingerprint);
      if (!isWithinReach) await adopt(id, null, local.name, null);
      await api.draft(id, local.data);
    } catch (error) {
      useStore.setState({ notice: problemsOf(error) });
      return false;
    }
  }
  const opened = await openModel({ draft: id });
  if (opened) {
    useStore.setState({ saved: {} }); // it is in no file as it is
    forget(id);
  }
  return opened;
}
