/** What the page and its server send each other. */

export type Json = null | boolean | number | string | readonly Json[] | JsonObject;
export interface JsonObject {
  readonly [key: string]: Json;
}
/** The JSON form of a model file. */
export type Model = JsonObject;

export type Severity = "error" | "warning" | "note";

export interface PatchStep {
  readonly op: "add" | "replace" | "remove";
  readonly path: string;
  readonly value?: Json;
}

export interface Problem {
  readonly severity: Severity;
  readonly pointer: string;
  readonly element: string;
  readonly code: string;
  readonly what: string;
  readonly why: string;
  readonly fix: string;
  readonly line: number | null;
  readonly repair: { readonly label: string; readonly patch: readonly PatchStep[] } | null;
}

export interface PaletteElement {
  readonly section: string;
  readonly type: string;
  readonly title: string;
  readonly group: string;
  readonly summary: string;
  readonly definition: string;
}

export interface SchemaAnswer {
  readonly schema: JsonObject;
  readonly elements: readonly PaletteElement[];
}

export interface Example {
  readonly name: string;
  /** "examples", or the part of the gallery that it belongs to. */
  readonly group: string;
  readonly title: string;
  readonly summary: string;
}

export interface RecentFile {
  readonly path: string;
  readonly name: string;
  readonly when: string;
}

export interface Draft {
  readonly id: string;
  readonly path: string | null;
  readonly name: string;
  readonly when: string;
}

/** Pointers of what brings names and of what reads them; each name with the symbol whose rate it is, or itself. */
export interface ServedWire {
  readonly source: string;
  readonly target: string;
  readonly names: readonly string[];
  readonly roots: readonly string[];
}

export interface DocumentAnswer {
  readonly document: string;
  readonly path: string | null;
  readonly name: string;
  readonly data: Model;
  readonly fingerprint: string | null;
  readonly problems: readonly Problem[];
  /** What the file says behind its parameters. */
  readonly comments: Readonly<Record<string, string>>;
  readonly wires: readonly ServedWire[];
}

export interface FolderAnswer {
  readonly path: string;
  readonly parent: string | null;
  readonly entries: readonly { readonly name: string; readonly kind: "folder" | "model" | "urdf" }[];
}

export interface Chord {
  readonly joint: string;
  readonly equations: number;
  readonly loop: readonly string[];
}

export interface Summary {
  readonly coordinates: readonly string[];
  readonly speeds: readonly string[];
  /** Of coordinates and parameters: "" of quaternions, and of parameters whose places leave their unit open. */
  readonly units: Readonly<Record<string, string>>;
  readonly freedoms: number | null;
  readonly instant_freedoms: number | null;
  readonly constraints: number;
  /** Equations of contacts, limits and ropes, which hold only while these are closed or taut. */
  readonly unilateral: number;
  readonly rotation_tree: readonly string[];
  readonly translation_tree: readonly string[];
  readonly chords: readonly Chord[];
  readonly redundant: readonly string[];
  /** Notes on the counts, such as of an instant in which they differ. */
  readonly counting: readonly string[];
  readonly tree_choice: Readonly<Record<string, { readonly rotation: boolean; readonly translation: boolean }>>;
  readonly bodies: number;
}

/** A scene and its motion as the viewer decodes them. */
export interface PictureData {
  readonly scene: unknown;
  readonly motion: unknown;
}

export interface CheckAnswer {
  readonly problems: readonly Problem[];
  readonly summary: Summary | null;
  readonly picture: PictureData | null;
  readonly values: Readonly<Record<string, number>>;
  readonly formulas: Readonly<Record<string, string>>;
  readonly wires: readonly ServedWire[];
}

/** A model in another form: text, or bytes in base 64 with what was left out. */
export interface ExportAnswer {
  readonly name: string;
  readonly text?: string;
  readonly base64?: string;
  readonly notes?: readonly Problem[];
}

/** Of a check what can be had sooner; without a picture the check says why. */
export type RedrawAnswer = Pick<CheckAnswer, "picture" | "values">;

export interface PoseAnswer {
  readonly values: Readonly<Record<string, number>>;
  readonly positions: readonly (readonly number[])[];
  readonly quaternions: readonly (readonly number[])[];
}

/** What a drag of a body leads to: the point that is held [m], and how far it is from the line of sight [m]. */
export interface DragAnswer extends PoseAnswer {
  readonly at: readonly [number, number, number];
  readonly distance: number;
  readonly size: number;
}

export type JobKind = "equations" | "simulate" | "equilibrium" | "modes" | "singular" | "ratios" | "torque" | "inverse" | "sweep";

export interface JobState {
  /** What the next look at the job names as seen. */
  readonly seen: number;
  readonly stage: string;
  readonly stages: readonly string[];
  readonly percent: number | null;
  readonly elapsed: number;
  readonly state: "running" | "done" | "failed" | "cancelled";
  readonly result: JsonObject | null;
  readonly problems: readonly Problem[];
}
