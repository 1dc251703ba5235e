/** Files: open, save, drafts, and changes from outside. */

import { api, problemsOf, ServerError, type Opened } from "../api";
import { focusInDiagram } from "../diagram/flow";
import { GROUND } from "../model/entries";
import { isDirty, showDocument, useStore, say } from "../store";
import type { DocumentAnswer, ExportAnswer, Problem } from "../types";

function notice(problems: readonly Problem[]): void {
  useStore.setState({ notice: problems });
}

/** Whether the user agrees to leave edits that are in no file. */
function mayLeave(): boolean {
  const state = useStore.getState();
  return state.document === null || !isDirty(state) || window.confirm("The model has unsaved changes. Discard them?");
}

async function show(answer: Promise<DocumentAnswer>): Promise<boolean> {
  try {
    showDocument(await answer);
    focusInDiagram(GROUND);
    return true;
  } catch (error) {
    notice(problemsOf(error));
    return false;
  }
}

export async function openModel(what: Opened): Promise<boolean> {
  return mayLeave() && show(api.open(what));
}

export async function newModel(): Promise<boolean> {
  return mayLeave() && show(api.create());
}

/** Open a file that was dragged in or chosen with the browser's own picker. */
export async function openFile(file: File): Promise<boolean> {
  return openModel({ text: await file.text(), name: file.name });
}

export async function save(overwrite = false): Promise<boolean> {
  const { document } = useStore.getState();
  if (document === null) return false;
  if (document.path === null) {
    useStore.setState({ dialog: "saveAs" });
    return false;
  }
  return saveTo(document.path, overwrite);
}

export async function saveTo(path: string, overwrite: boolean): Promise<boolean> {
  const { document, data } = useStore.getState();
  if (document === null) return false;
  const fingerprint = path === document.path ? document.fingerprint : null;
  try {
    const answer = await api.save({ document: document.id, path, data, fingerprint, overwrite });
    const file = answer.path.split(/[/\\]/).at(-1) ?? document.name;
    const name = file.replace(/\.toml$/i, "");
    useStore.setState({ saved: data, document: { ...document, path: answer.path, name, fingerprint: answer.fingerprint }, outside: false, notice: [], dialog: null });
    say(`${file} saved`);
    return true;
  } catch (error) {
    const changed = error instanceof ServerError && error.status === 409;
    if (!changed || path !== document.path) notice(problemsOf(error));
    else useStore.setState({ outside: true, spoken: `${document.name} is not saved: the file was changed by another program` }); // the bar has what can be done
    return false;
  }
}

export async function reloadFile(): Promise<void> {
  const { document } = useStore.getState();
  if (document?.path != null) await show(api.open({ path: document.path }));
}

const WATCH_WAIT = 2000; // [ms]

/** Look whether the file changed outside while the page is seen; return what ends it. */
export function watchFile(): () => void {
  const timer = setInterval(() => { if (document.visibilityState === "visible") void lookOutside(); }, WATCH_WAIT);
  return () => { clearInterval(timer); };
}

async function lookOutside(): Promise<void> {
  const { document: shown, outside, server } = useStore.getState();
  if (shown?.path == null || shown.fingerprint === null || outside || server !== "here") return;
  const changed = await api.changed(shown.id, shown.fingerprint).catch(() => false);
  if (changed && useStore.getState().document === shown) useStore.setState({ outside: true, spoken: "Another program changed the file." });
}

/** Write a text, or bytes, as a file of the browser. */
export function download(name: string, content: string | Uint8Array<ArrayBuffer>, type = "text/plain"): void {
  const link = document.createElement("a");
  const address = URL.createObjectURL(new Blob([content], { type }));
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => { URL.revokeObjectURL(address); }, 1000);
}

function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

export const EXPORTS = [
  ["toml", "Model file (TOML)"], ["python", "Python script"], ["c", "C code"], ["latex", "Equations (LaTeX)"], ["html", "Animation (HTML)"],
  ["fmu", "FMU (FMI 3.0)"],
] as const; // prettier-ignore

function downloadExport({ name, text = "", base64 }: ExportAnswer, kind: string): void {
  if (base64 === undefined) download(name, text, kind === "html" ? "text/html" : "text/plain");
  else download(name, bytesOf(base64), "application/octet-stream");
}

export async function exportModel(kind: string): Promise<void> {
  const { data, simulated, document: shown } = useStore.getState();
  if (kind === "fmu") say("The FMU is being compiled…");
  try {
    const written = await api.exported(shown?.id ?? "", data, kind, kind === "html" ? (simulated?.job ?? null) : null);
    downloadExport(written, kind);
    notice(written.notes ?? []);
    say(`${written.name} written`);
  } catch (error) {
    notice(problemsOf(error));
  }
}
