/** The state of the page: the model, what is selected, what is shown. Only the model has a history. */

import { temporal } from "zundo";
import { create } from "zustand";
import type { EntryId } from "./model/entries";
import { forgetArrangement } from "./model/layout";
import { valueAt } from "./model/pointers";
import { withHeldBodies } from "./model/ports";
import { keepWires } from "./model/wires";
import type { Copied } from "./model/edit";
import type { CheckAnswer, DocumentAnswer, JobKind, JobState, Model, Problem, SchemaAnswer } from "./types";

export type ThemeChoice = "auto" | "light" | "dark" | "contrast";
export type Tab = "positions" | "curves" | "equations" | "analyses" | "problems" | "notes";
/** What has the room: the diagram, the picture, or results. */
export type Layout = "draw" | "watch" | "read";
/** What a narrow window shows: of a phone one panel, below the width of three columns a side over the rest. */
export type Panel = "diagram" | "picture" | "results" | "left" | "right";
export type LeftTab = "palette" | "trees";
export type Dialog = "start" | "open" | "saveAs" | "help" | "simulate" | null;

export interface OpenDocument {
  readonly id: string;
  readonly path: string | null;
  readonly name: string;
  readonly fingerprint: string | null;
  /** What the file says behind its parameters. */
  readonly comments: Readonly<Record<string, string>>;
}

/** Whether the server of this page answers; "other": one answers that was started later. */
export type ServerState = "here" | "gone" | "other";

/** A choice that waits for the user at a place of the window. */
export type Popup =
  | { readonly kind: "types"; readonly x: number; readonly y: number; readonly ends: readonly [string, string] }
  | { readonly kind: "insert"; readonly x: number; readonly y: number; readonly spot: readonly [number, number] | null }
  | { readonly kind: "menu"; readonly x: number; readonly y: number; readonly target: EntryId | null };

export interface Run {
  readonly kind: JobKind;
  readonly job: string | null;
  readonly state: JobState | null;
  /** The model that it was started with. */
  readonly of: Model;
  /** What else it was started with, as JSON. */
  readonly options: string;
  /** Its number among all runs of the page. */
  readonly turn: number;
}

/** Jobs that do not wait for each other: the equations that are read, and what computes with the mechanism. */
export type Lane = "equations" | "computation";
export type Runs = Readonly<Partial<Record<Lane, Run>>>;

export interface Simulated {
  readonly job: string;
  readonly of: Model;
  readonly scene: unknown;
  readonly motion: unknown;
  readonly result: JobState["result"];
  readonly title: string;
}

/** A pose that is no edit yet: what sliders and drags lead to. */
export interface Posed {
  readonly of: Model;
  readonly values: Readonly<Record<string, number>>;
  /** Whether any pose came: where the first one fails the mechanism stands as it stood. */
  readonly moved: boolean;
  readonly problem: string;
}

export interface State {
  readonly data: Model;
  readonly document: OpenDocument | null;
  readonly saved: Model;
  readonly schema: SchemaAnswer | null;
  readonly selection: readonly EntryId[];
  /** The frame that is selected within the one selected body. */
  readonly check: CheckAnswer | null;
  /** The model that `check` is of. */
  readonly checked: Model | null;
  readonly openProblems: readonly Problem[];
  readonly server: ServerState;
  readonly outside: boolean;
  readonly copied: Copied | null;
  readonly popup: Popup | null;
  readonly dialog: Dialog;
  readonly tab: Tab;
  readonly leftTab: LeftTab;
  readonly layout: Layout;
  readonly panel: Panel;
  /** Whether letters are large, for a projector. */
  readonly presents: boolean;
  readonly simulation: SimulationOptions;
  readonly theme: ThemeChoice;
  readonly focusPointer: string | null;
  readonly renaming: EntryId | null;
  readonly spoken: string;
  readonly notice: readonly Problem[];
  /** What is running. */
  readonly runs: Runs;
  readonly equations: { readonly of: Model; readonly job: string; readonly result: JobState["result"] } | null;
  readonly analysis: { readonly kind: JobKind; readonly of: Model; readonly result: JobState["result"] } | null;
  readonly simulated: Simulated | null;
  /** Whether the picture shows the simulated motion, not the start position. */
  readonly showsMotion: boolean;
  readonly highlighted: readonly EntryId[];
  /** What the term under the pointer comes from. */
  readonly glowing: readonly EntryId[];
  readonly posed: Posed | null;
  /** The body that is dragged in the picture. */
  readonly dragged: string | null;
  /** What the picture has to say of the last pose. */
  readonly pictureNote: string;
  /** What an analysis shows in the picture, such as a mode. */
  readonly analysisPicture: { readonly scene: unknown; readonly motion: unknown; readonly title: string } | null;
}

/** What the next simulation takes. */
export interface SimulationOptions {
  readonly t_end: number;
  readonly inputs: Readonly<Record<string, string>>;
  /** Between stored samples [s]; null: every step of the solver. */
  readonly step: number | null;
  /** "": chosen as the motion is computed. */
  readonly solver: "" | "explicit" | "stiff";
  readonly rtol: number;
}

const FIVE_SECONDS: SimulationOptions = { t_end: 5, inputs: {}, step: null, solver: "", rtol: 1e-8 };
const EMPTY: Model = {};

export const useStore = create<State>()(
  temporal(
    (): State => ({
      data: EMPTY, document: null, saved: EMPTY, schema: null, selection: [], check: null, checked: null, openProblems: [],
      server: "here", outside: false, copied: null, popup: null, dialog: "start", tab: "positions", leftTab: "palette",
      layout: "draw", panel: "diagram", presents: false, simulation: FIVE_SECONDS, theme: "auto", focusPointer: null, renaming: null, spoken: "", notice: [], runs: {}, equations: null,
      analysis: null, simulated: null, showsMotion: false, highlighted: [], glowing: [], posed: null, dragged: null, pictureNote: "",
      analysisPicture: null,
    }), // prettier-ignore
    { partialize: ({ data }) => ({ data }), equality: (before, after) => before.data === after.data, limit: 500 },
  ),
);

const history = useStore.temporal;
let gesture = "";

/** Change the model; calls with the same gesture, one after the other, are one step of the history. */
export function edit(change: (data: Model) => Model, name = ""): void {
  const { data } = useStore.getState();
  const next = withHeldBodies(data, change(data));
  if (next === data) return;
  const continues = name !== "" && name === gesture;
  if (continues) history.getState().pause();
  useStore.setState({ data: next });
  if (continues) history.getState().resume();
  gesture = name;
}

/** The next change is a step of its own. */
export function endGesture(): void {
  gesture = "";
}

export function undo(): void {
  endGesture();
  history.getState().undo();
  afterTravel("Undone");
}

export function redo(): void {
  endGesture();
  history.getState().redo();
  afterTravel("Redone");
}

function afterTravel(spoken: string): void {
  const { data, selection } = useStore.getState();
  useStore.setState({ selection: selection.filter((id) => id === "ground" || valueAt(data, `/${id}`) !== undefined), spoken, popup: null, renaming: null });
}

export function historyLength(): number {
  return history.getState().pastStates.length;
}

export function useHistory(): { canUndo: boolean; canRedo: boolean } {
  // a change of the model renders its readers, and nothing else changes the history
  useStore((state) => state.data);
  const { pastStates, futureStates } = history.getState();
  return { canUndo: pastStates.length > 0, canRedo: futureStates.length > 0 };
}

export function select(ids: readonly EntryId[], spoken = ""): void {
  const { selection } = useStore.getState();
  if (ids.length === selection.length && ids.every((id, index) => id === selection[index])) return;
  endGesture();
  useStore.setState({ selection: ids, ...(spoken === "" ? {} : { spoken }) });
}

export function say(spoken: string): void {
  useStore.setState({ spoken });
}

/** Show a document that was opened; its history begins. */
export function showDocument(answer: DocumentAnswer): void {
  endGesture();
  keepWires(answer.data, answer.wires);
  forgetArrangement();
  useStore.setState({
    data: answer.data,
    saved: answer.data,
    document: { id: answer.document, path: answer.path, name: answer.name, fingerprint: answer.fingerprint, comments: answer.comments },
    openProblems: answer.problems,
    selection: [], check: null, checked: null, popup: null, dialog: null, outside: false, renaming: null, notice: [],
    runs: {}, equations: null, analysis: null, simulated: null, showsMotion: false, highlighted: [], glowing: [], posed: null, dragged: null, pictureNote: "",
    analysisPicture: null,
    spoken: `${answer.name} opened`,
  }); // prettier-ignore
  history.getState().clear();
}

export function isDirty({ data, saved }: Pick<State, "data" | "saved">): boolean {
  return data !== saved;
}
