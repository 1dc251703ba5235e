/** Every command of the page, its keys, and when it can be given. */

import { fitDiagram, focusInDiagram } from "../diagram/flow";
import { insertInMiddle } from "../diagram/gestures";
import { GROUND } from "../model/entries";
import { redo, select, undo, useStore, type State } from "../store";
import * as editing from "./editing";
import { newModel, save } from "./files";
import { insertFrame } from "./insert";
import { cancelJobs, deriveEquations, simulate } from "./jobs";

export interface Command {
  readonly title: string;
  /** Keys such as "Ctrl+Shift+Z"; Ctrl is Cmd on a Mac. */
  readonly keys: readonly string[];
  readonly run: () => void;
  readonly enabled?: (state: State) => boolean;
  /** Whether its keys work while a text is edited. */
  readonly inText?: boolean;
}

const hasSelection = ({ selection }: State): boolean => selection.length > 0;
const hasDocument = ({ document }: State): boolean => document !== null;
const isBody = ({ selection }: State): boolean => selection.length === 1 && (selection[0] === GROUND || selection[0]!.startsWith("body/"));
const isEntry = ({ selection }: State): boolean => selection.length === 1 && selection[0] !== GROUND;

export const COMMANDS = {
  new: { title: "New model", keys: ["Alt+N"], run: () => { void newModel(); }, inText: true },
  open: { title: "Open…", keys: ["Ctrl+O"], run: () => { useStore.setState({ dialog: "open" }); }, inText: true },
  save: { title: "Save", keys: ["Ctrl+S"], run: () => { void save(); }, enabled: hasDocument, inText: true },
  saveAs: { title: "Save as…", keys: ["Ctrl+Shift+S"], run: () => { useStore.setState({ dialog: "saveAs" }); }, enabled: hasDocument, inText: true },
  start: { title: "Examples and recent files", keys: [], run: () => { useStore.setState({ dialog: "start" }); } },
  undo: { title: "Undo", keys: ["Ctrl+Z"], run: undo, enabled: hasDocument },
  redo: { title: "Redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], run: redo, enabled: hasDocument },
  insert: { title: "Add an element…", keys: ["/"], run: insertInMiddle, enabled: hasDocument },
  frame: { title: "Add a frame", keys: ["Shift+F"], run: () => { insertFrame(useStore.getState().selection[0]!); }, enabled: isBody },
  fields: { title: "Go to the properties", keys: ["F4"], run: toProperties, enabled: hasDocument, inText: true },
  rename: { title: "Rename", keys: ["F2"], run: editing.renameSelection, enabled: isEntry },
  cut: { title: "Cut", keys: ["Ctrl+X"], run: editing.cutSelection, enabled: hasSelection },
  copy: { title: "Copy", keys: ["Ctrl+C"], run: editing.copySelection, enabled: hasSelection },
  paste: { title: "Paste", keys: ["Ctrl+V"], run: editing.paste, enabled: ({ copied }) => copied !== null },
  duplicate: { title: "Duplicate", keys: ["Ctrl+D"], run: editing.duplicate, enabled: hasSelection },
  delete: { title: "Delete", keys: ["Delete", "Backspace"], run: editing.removeSelection, enabled: hasSelection },
  selectAll: { title: "Select all", keys: ["Ctrl+A"], run: editing.selectAll, enabled: hasDocument },
  arrange: { title: "Arrange the diagram", keys: ["Shift+A"], run: editing.arrange, enabled: hasDocument },
  fit: { title: "Show the whole diagram", keys: ["F"], run: fitDiagram, enabled: hasDocument },
  equations: { title: "Derive the equations", keys: ["F6"], run: deriveEquations, enabled: hasDocument, inText: true },
  simulate: { title: "Simulate", keys: ["F5"], run: () => { simulate(); }, enabled: hasDocument, inText: true },
  cancel: { title: "Cancel what is running", keys: ["Shift+Escape"], run: () => { cancelJobs(); }, enabled: ({ runs }) => Object.keys(runs).length > 0, inText: true },
  drawLayout: { title: "Draw: large diagram", keys: ["1"], run: () => { useStore.setState({ layout: "draw" }); }, enabled: hasDocument },
  watchLayout: { title: "Watch: large picture", keys: ["2"], run: () => { useStore.setState({ layout: "watch", panel: "picture" }); }, enabled: hasDocument },
  readLayout: { title: "Read: large results", keys: ["3"], run: () => { useStore.setState({ layout: "read", panel: "results" }); }, enabled: hasDocument },
  fullScreen: { title: "Full screen", keys: ["Alt+Enter"], run: toggleFullScreen, inText: true },
  present: { title: "Large text, for a projector", keys: ["Shift+P"], run: () => { useStore.setState({ presents: !useStore.getState().presents }); } },
  help: { title: "Keys and gestures", keys: ["?"], run: () => { useStore.setState({ dialog: "help" }); } },
  escape: { title: "Close, return to the diagram, or clear the selection", keys: ["Escape"], run: escape, inText: true },
} satisfies Record<string, Command>;

export type CommandName = keyof typeof COMMANDS;

export function commandNamed(name: CommandName): Command {
  return COMMANDS[name];
}

function toggleFullScreen(): void {
  const change = document.fullscreenElement === null ? document.documentElement.requestFullscreen() : document.exitFullscreen();
  change.catch(() => { useStore.setState({ spoken: "The browser does not allow full screen here." }); });
}

function escape(): void {
  const { popup, dialog, document } = useStore.getState();
  if (popup !== null) useStore.setState({ popup: null });
  else if (dialog !== null && document !== null) useStore.setState({ dialog: null });
  else if (!backToDiagram()) {
    select([], "Nothing selected");
    if (window.document.activeElement === window.document.body) focusInDiagram(GROUND);
  }
}

/** Put the focus into the name on the right side, or its first field. */
function toProperties(): void {
  const fields = [".properties [data-pointer$='/name']", ".properties input, .properties select, .properties button"];
  fields.map((each) => document.querySelector<HTMLElement>(each)).find((each) => each !== null)?.focus();
}

/** Put the focus onto what is selected in the diagram; return whether it was elsewhere in a field. */
function backToDiagram(): boolean {
  const active = document.activeElement;
  if (!(active instanceof HTMLElement) || active.closest(".properties, .left, .panel") === null) return false;
  active.blur();
  focusInDiagram(useStore.getState().selection[0] ?? GROUND);
  return true;
}

export function giveCommand(name: CommandName): void {
  const command = commandNamed(name);
  if (command.enabled?.(useStore.getState()) ?? true) command.run();
}

function keyText(event: KeyboardEvent): string {
  const { key: name } = event;
  const control = event.ctrlKey || event.metaKey ? "Ctrl+" : "";
  const key = name.length === 1 ? name.toUpperCase() : name;
  // characters such as "?" need Shift on some keyboards
  const shift = event.shiftKey && (name.length > 1 || /[A-Z]/i.test(name)) ? "Shift+" : "";
  return `${control}${event.altKey ? "Alt+" : ""}${shift}${key}`;
}

function isText(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return !["checkbox", "radio", "range", "button"].includes(target.type);
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;
}

/** Whether what has the focus keeps a key press for itself: texts, windows, and the picture with keys of its own. */
function isKept(keys: string, target: EventTarget | null): boolean {
  if (isText(target)) return true;
  if (useStore.getState().dialog !== null) return keys !== "Escape";
  return target instanceof Element && target.closest(".sb-player:not(.sb-curves-only)") !== null && !keys.includes("Ctrl");
}

/** Give the command of a key press, if it has one here. */
export function takeKey(event: KeyboardEvent): void {
  if (event.defaultPrevented) return;
  const keys = keyText(event);
  const command = Object.values(COMMANDS as Record<string, Command>).find((each) => each.keys.includes(keys));
  if (command === undefined || (command.inText !== true && isKept(keys, event.target))) return;
  event.preventDefault();
  if (command.enabled?.(useStore.getState()) ?? true) command.run();
}

/** Return keys as they are printed. */
export function printedKeys(keys: string): string {
  const mac = /Mac|iPhone|iPad/.test(navigator.userAgent);
  return keys.replace("Ctrl", mac ? "⌘" : "Ctrl").replace("Escape", "Esc").replace("Delete", "Del");
}
