/** A body is dragged in the picture: the loops follow, and where it is left the mechanism starts. */

import { api } from "../api";
import type { Viewer } from "../../viewer";
import { entryNamed } from "../model/entries";
import { say, select, useStore } from "../store";
import type { DragAnswer } from "../types";
import { backToStart, keepPose, pose, settled } from "./posing";
import { pictureNow } from "./shown";

const STILL = 5; // pixels that a press may move and yet be a click
const FAR = 0.03; // of the size of the mechanism: the point does not reach the pointer

type Place = readonly [number, number];

/** The line from the point that is held to the pointer. */
export interface Thread {
  show: (from: Place, to: Place) => void;
  hide: () => void;
}

interface Drag {
  readonly viewer: Viewer;
  readonly body: string;
  readonly point: readonly [number, number, number];
  readonly press: Place;
  /** Where the held point was seen last, in ground's axes. */
  at: readonly [number, number, number] | null;
  pointer: Place;
  started: boolean;
}

/** Whether a press is for a body: with a key the view is turned, wherever the press is. */
function isPlain({ button, altKey, shiftKey, ctrlKey, metaKey }: PointerEvent): boolean {
  return button === 0 && ![altKey, shiftKey, ctrlKey, metaKey].includes(true);
}

/** Whether the picture shows the start position, not a motion. */
function isAtStart(): boolean {
  const { showsMotion, simulated, analysisPicture, check } = useStore.getState();
  return !(showsMotion && simulated !== null) && analysisPicture === null && check !== null;
}

/** Return the moving body under a press that is to drag it. */
function grabbed(event: PointerEvent): Drag | null {
  if (!isPlain(event) || !isAtStart()) return null;
  const viewer = pictureNow.shown?.player.viewer;
  if (viewer == null || event.target !== viewer.canvas) return null;
  const place: Place = [event.clientX, event.clientY];
  const held = viewer.grabAt(...place);
  const body = held === null ? undefined : viewer.scene.bodies[held.body]?.name;
  return held === null || body === undefined ? null : { viewer, body, point: held.point, press: place, at: null, pointer: place, started: false };
}

function begin(drag: Drag): void {
  drag.started = true;
  const { data } = useStore.getState();
  const entry = entryNamed(data, drag.body, ["body"]);
  if (entry !== null) select([entry.id]);
  useStore.setState({ dragged: drag.body, spoken: `Dragging ${drag.body}` });
  drag.viewer.canvas.style.cursor = "grabbing";
}

function follow(drag: Drag, thread: Thread): void {
  const viewer = pictureNow.shown?.player.viewer ?? drag.viewer; // an edit may have made another picture
  const sight = viewer.sightAt(...drag.pointer);
  pose(async (data, guess, document) => {
    const answer = await api.drag(document, data, { body: drag.body, point: drag.point, ...sight }, guess);
    drag.at = answer.at;
    showThread(drag, thread);
    return { ...answer, note: reachNote(answer) };
  });
}

function showThread({ at, pointer, viewer }: Drag, thread: Thread): void {
  if (at === null || useStore.getState().dragged === null) return;
  thread.show((pictureNow.shown?.player.viewer ?? viewer).pagePlace(at), pointer);
}

function reachNote({ distance, size }: DragAnswer): string {
  return distance > FAR * size ? "The mechanism cannot reach the pointer." : "";
}

/** Let bodies be dragged that are seen in an element; return what ends it. */
export function watchDrags(root: HTMLElement, thread: Thread): () => void {
  let drag: Drag | null = null;
  let finishing = false;
  const move = (event: PointerEvent): void => {
    if (drag === null) return;
    drag.pointer = [event.clientX, event.clientY];
    if (!drag.started && Math.hypot(drag.pointer[0] - drag.press[0], drag.pointer[1] - drag.press[1]) < STILL) return;
    if (!drag.started) begin(drag);
    showThread(drag, thread);
    follow(drag, thread);
  };
  const leave = (): Drag | null => {
    const ended = drag;
    drag = null;
    thread.hide();
    window.removeEventListener("pointermove", move);
    window.removeEventListener("pointerup", release);
    window.removeEventListener("pointercancel", cancel);
    window.removeEventListener("keydown", press, true);
    if (ended !== null) {
      ended.viewer.rig.controls.enabled = true;
      ended.viewer.canvas.style.cursor = "";
    }
    useStore.setState({ dragged: null });
    return ended;
  };
  const release = (): void => {
    if (leave()?.started !== true) return;
    finishing = true;
    void settled().then(keepPose).finally(() => { finishing = false; });
  };
  const cancel = (): void => {
    if (leave()?.started !== true) return;
    backToStart();
    say("Returned to its previous position");
  };
  const press = (event: KeyboardEvent): void => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    event.stopPropagation();
    cancel();
  };
  const down = (event: PointerEvent): void => {
    if (drag !== null || finishing) return;
    drag = grabbed(event);
    if (drag === null) return;
    drag.viewer.rig.controls.enabled = false; // the press reaches the camera after this
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", release);
    window.addEventListener("pointercancel", cancel);
    window.addEventListener("keydown", press, true);
  };
  root.addEventListener("pointerdown", down, true);
  return () => {
    root.removeEventListener("pointerdown", down, true);
    leave();
  };
}
