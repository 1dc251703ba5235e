/** A body is held with the pointer while it moves: a spring from the point that was pressed to the pointer. */

import type { Viewer } from "../viewer";
import { createSvg } from "../player/dom";

type Point = readonly [number, number, number];

export interface PullActions {
  hold(body: number, point: Point, target: Point): void;
  move(target: Point): void;
  release(): void;
}

/** The line from the held point to the pointer. */
export class Thread {
  readonly element: SVGElement;
  private readonly line = createSvg("line");
  private readonly dot = createSvg("circle", { r: 5 });

  constructor() {
    this.element = createSvg("svg", { class: "sb-thread", "aria-hidden": "true" }, this.line, this.dot);
    this.element.style.visibility = "hidden";
  }

  show(from: readonly [number, number], to: readonly [number, number]): void {
    const { left, top } = this.element.getBoundingClientRect();
    const [x1, y1, x2, y2] = [from[0] - left, from[1] - top, to[0] - left, to[1] - top].map(String) as [string, string, string, string];
    for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) this.line.setAttribute(name, value);
    this.dot.setAttribute("cx", x1);
    this.dot.setAttribute("cy", y1);
    this.element.style.visibility = "visible";
  }

  hide(): void {
    this.element.style.visibility = "hidden";
  }
}

/** Where the pointer is in space: at the depth of the held point, in the plane that faces the camera. */
function placeUnder(viewer: Viewer, pointer: readonly [number, number], held: Point): Point {
  const { origin, direction } = viewer.sightAt(...pointer);
  const normal = viewer.sightAt(...middleOf(viewer)).direction;
  const along = dot(normal, minus(held, origin)) / dot(normal, direction);
  return [0, 1, 2].map((i) => origin[i]! + along * direction[i]!) as unknown as Point;
}

function middleOf({ canvas }: Viewer): [number, number] {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  return [left + width / 2, top + height / 2];
}

function dot(a: Point, b: Point): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function minus(a: Point, b: Point): Point {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** Follows presses on bodies; with a key the view is turned, wherever the press is. */
export class Pulling {
  private pointer: readonly [number, number] = [0, 0];
  private held: { readonly body: number; readonly point: Point } | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly thread: Thread,
    private readonly placeOf: (body: number, point: Point) => Point,
    private readonly actions: PullActions,
  ) {
    viewer.host.addEventListener("pointerdown", (event) => { this.press(event); }, true);
  }

  /** Follow the pointer and draw the thread; once a frame. */
  update(): void {
    if (this.held === null) return;
    const place = this.placeOf(this.held.body, this.held.point);
    this.actions.move(placeUnder(this.viewer, this.pointer, place));
    this.thread.show(this.viewer.pagePlace(place), this.pointer);
  }

  private press(event: PointerEvent): void {
    const { button, altKey, shiftKey, ctrlKey, metaKey } = event;
    if (button !== 0 || altKey || shiftKey || ctrlKey || metaKey || event.target !== this.viewer.canvas) return;
    const grab = this.viewer.grabAt(event.clientX, event.clientY);
    if (grab === null) return;
    this.pointer = [event.clientX, event.clientY];
    this.held = { body: grab.body - 1, point: grab.point }; // the first body of a scene is the ground
    this.actions.hold(this.held.body, grab.point, this.placeOf(this.held.body, grab.point));
    this.viewer.rig.controls.enabled = false;
    this.viewer.canvas.style.cursor = "grabbing";
    const move = (moved: PointerEvent): void => { this.pointer = [moved.clientX, moved.clientY]; };
    const leave = (): void => {
      window.removeEventListener("pointermove", move);
      for (const name of ["pointerup", "pointercancel", "blur"]) window.removeEventListener(name, leave);
      this.held = null;
      this.viewer.rig.controls.enabled = true;
      this.viewer.canvas.style.cursor = "";
      this.thread.hide();
      this.actions.release();
    };
    window.addEventListener("pointermove", move);
    for (const name of ["pointerup", "pointercancel", "blur"]) window.addEventListener(name, leave);
  }
}
