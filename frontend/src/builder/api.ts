/** Calls of the server, each with the types of its answer. */

import { ABSENCES, request } from "./connection";
import type {
  CheckAnswer, DocumentAnswer, DragAnswer, Draft, Example, ExportAnswer, FolderAnswer, JobKind, JobState, JsonObject, Json, Model, PoseAnswer,
  Problem, RecentFile, RedrawAnswer, SchemaAnswer,
} from "./types"; // prettier-ignore

import { count } from "./shell/counts";

/** A refusal of the server, or the server out of reach. */
export class ServerError extends Error {
  constructor(
    readonly problems: readonly Problem[],
    /** Status of the answer; 0 where none came. */
    readonly status: number,
  ) {
    super(problems.map((each) => each.what).join("; "));
  }
}

export function problemOf(code: string, what: string, fix: string): Problem {
  return { severity: "error", pointer: "", element: "", code, what, why: "", fix, line: null, repair: null };
}

/** Return what a failure says, whatever was thrown. */
export function problemsOf(error: unknown): readonly Problem[] {
  if (error instanceof ServerError) return error.problems;
  return [problemOf("page", error instanceof Error ? error.message : String(error), "Load the page again.")];
}

/** Of the requests of one page the server answers the newest. */
const page = Math.random().toString(36).slice(2);

let turn = 0;

/** Requests may overtake each other on their way; the server takes that with the highest turn for the newest. */
function nextTurn(): number {
  turn += 1;
  return turn;
}

async function call(name: string, body: object, signal?: AbortSignal): Promise<unknown> {
  count(name);
  const response = await request(name, body, signal);
  if (response === null) throw new ServerError([problemOf("page.no_server", ABSENCES.gone.what, ABSENCES.gone.fix)], 0);
  if (response.status === 401) throw new ServerError([problemOf("page.other_run", ABSENCES.other.what, ABSENCES.other.fix)], 401);
  const answer = (await response.json().catch(() => null)) as unknown;
  if (response.ok) return answer;
  const problems = (answer as { problems?: readonly Problem[] } | null)?.problems;
  throw new ServerError(problems ?? [problemOf("page.refused", `the server answered ${response.status}`, "Load the page again.")], response.status);
}

export type Opened = { path: string } | { example: string } | { text: string; name: string } | { draft: string } | { urdf: string };

/** A body held at a point of it, and the line of sight on which that point should be [m]. */
export interface Held {
  readonly body: string;
  readonly point: readonly number[];
  readonly origin: readonly number[];
  readonly direction: readonly number[];
}

export const api = {
  schema: () => call("schema", {}) as Promise<SchemaAnswer>,
  examples: async () => (await call("examples", {}) as { examples: readonly Example[] }).examples,
  recent: async () => (await call("recent", {}) as { files: readonly RecentFile[] }).files,
  recovery: async () => (await call("recovery", {}) as { drafts: readonly Draft[] }).drafts,
  create: () => call("new", {}) as Promise<DocumentAnswer>,
  open: (what: Opened) => call("open", what) as Promise<DocumentAnswer>,
  folder: (path: string) => call("folder", { path }) as Promise<FolderAnswer>,
  save: (body: { document: string; path: string; data: Model; fingerprint: string | null; overwrite: boolean }) =>
    call("save", body) as Promise<{ path: string; fingerprint: string }>,
  draft: (document: string, data: Model) => call("draft", { document, data }) as Promise<JsonObject>,
  changed: async (document: string, fingerprint: string) =>
    (await call("changed", { document, fingerprint }) as { changed: boolean }).changed,
  check: (document: string, data: Model, signal: AbortSignal) => call("check", { data, document, page, turn: nextTurn() }, signal) as Promise<CheckAnswer>,
  redraw: (document: string, data: Model, signal: AbortSignal) => call("redraw", { data, document, page, turn: nextTurn() }, signal) as Promise<RedrawAnswer>,
  pose: (document: string, data: Model, fixed: Record<string, number>, guess: Readonly<Record<string, number>>) =>
    call("pose", { data, document, page, fixed, guess }) as Promise<PoseAnswer>,
  drag: (document: string, data: Model, held: Held, guess: Readonly<Record<string, number>>) =>
    call("drag", { data, document, page, ...held, guess }) as Promise<DragAnswer>,
  formula: async (text: string, pointer: string) =>
    (await call("formula", { text, pointer }) as { mathml: string }).mathml,
  job: async (document: string, kind: JobKind, data: Model, options: Json) =>
    (await call("job", { document, kind, data, options }) as { job: string }).job,
  jobState: (job: string, seen: number) => call("job_state", { job, seen }) as Promise<JobState>,
  cancel: (job: string) => call("cancel", { job }) as Promise<JsonObject>,
  equationTab: (job: string, name: string) => call("equation_tab", { job, name }) as Promise<JsonObject>,
  outputs: (job: string, names: readonly string[]) => call("outputs", { job, names }) as Promise<JsonObject>,
  exported: (document: string, data: Model, kind: string, job: string | null) =>
    call("export", { document, data, kind, ...(job === null ? {} : { job }) }) as Promise<ExportAnswer>,
};
