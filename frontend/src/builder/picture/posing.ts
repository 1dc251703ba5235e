/** Poses between edits: sliders and drags lead to them, one request at a time, the newest first. */

import { problemsOf } from "../api";
import { withInitial } from "../model/initial";
import { sentence } from "../panels/field_frame";
import { edit, endGesture, say, useStore } from "../store";
import type { Model, PoseAnswer } from "../types";
import { pictureNow } from "./shown";

type Values = Readonly<Record<string, number>>;

/** Sends a request for a pose near the one before; `note` is what the picture says of it. */
export type Wish = (data: Model, guess: Values, document: string) => Promise<PoseAnswer & { readonly note?: string }>;

let next: Wish | null = null;
let given: Wish | null = null;
let running: Promise<void> | null = null;

function showPose({ positions, quaternions }: PoseAnswer): void {
  const { shown } = pictureNow;
  if (shown === null) return;
  shown.source.show({ positions, quaternions });
  shown.player.refresh();
}

/** Return where the coordinates are now: as they were dragged, else as the mechanism was assembled. */
export function valuesNow(): Values {
  const { posed, data, check } = useStore.getState();
  return posed?.of === data ? posed.values : (check?.values ?? {});
}

/** Return what a refusal says, in a sentence. */
function reasonOf(error: unknown): string {
  const [fault] = problemsOf(error);
  return fault === undefined ? "" : sentence([fault.what, fault.fix].filter((each) => each !== "").join("; "));
}

async function fulfil(wish: Wish): Promise<void> {
  const { data, document } = useStore.getState();
  const before = valuesNow();
  const isOf = (now: Model): boolean => now === data && given === wish;
  try {
    const answer = await wish(data, before, document?.id ?? "");
    if (!isOf(useStore.getState().data)) return;
    showPose(answer);
    useStore.setState({ posed: { of: data, values: answer.values, moved: true, problem: "" }, pictureNote: answer.note ?? "" });
  } catch (error) {
    if (!isOf(useStore.getState().data)) return;
    // the picture stays at the last pose that could be assembled
    const moved = useStore.getState().posed?.moved ?? false;
    const problem = reasonOf(error);
    useStore.setState({ posed: { of: data, values: before, moved, problem }, pictureNote: problem });
  }
}

async function run(): Promise<void> {
  while (next !== null) {
    given = next;
    next = null;
    await fulfil(given);
  }
}

/** Pose the mechanism; of wishes that wait while one is under way the newest is fulfilled. */
export function pose(wish: Wish): void {
  next = wish;
  running ??= run().finally(() => { running = null; });
}

/** Wait until the last wish is fulfilled. */
export async function settled(): Promise<void> {
  while (running !== null) await running;
}

/** Show the start position again; what is under way is of no use any more. */
export function backToStart(): void {
  next = null;
  given = null;
  useStore.setState({ posed: null, pictureNote: "" });
  pictureNow.shown?.source.show(null);
  pictureNow.shown?.player.refresh();
}

/** Make the pose the initial values: one step of the history. */
export function keepPose(): void {
  const { posed, data, check } = useStore.getState();
  if (posed?.problem === "") useStore.setState({ pictureNote: "" });
  if (posed?.of !== data || !posed.moved) return;
  endGesture();
  edit((before) => withInitial(before, posed.values, check?.values ?? {}));
  say("The mechanism starts from here");
}
