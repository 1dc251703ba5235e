/** What is under the pointer, and what is selected: name, kind, body, where it is. */

import { Vector3 } from "three";
import type { SceneElement, Viewer } from "../viewer";
import { create, setText } from "./dom";
import { icon } from "./icons";

/** Return a place in metres with signs, in equal widths. */
export function formatPlace(place: Vector3): string {
  const digits = (value: number): string => `${value < -5e-5 ? "−" : " "}${Math.abs(value).toFixed(4)}`;
  return `x ${digits(place.x)}  y ${digits(place.y)}  z ${digits(place.z)} m`;
}

class ElementCard {
  readonly element: HTMLElement;
  private readonly name = create("strong");
  private readonly kind = create("span", { class: "sb-kind" });
  private readonly place = create("span", { class: "sb-number sb-place" });
  private shown: SceneElement | null = null;
  private readonly point = new Vector3();

  constructor(
    private readonly viewer: Viewer,
    className: string,
    ...extra: HTMLElement[]
  ) {
    this.element = create("div", { class: className }, this.name, this.kind, this.place, ...extra);
    this.element.hidden = true;
  }

  show(element: SceneElement | null): void {
    this.shown = element;
    this.element.hidden = element === null;
    if (element === null) return;
    const body = this.viewer.scene.bodies[element.body];
    setText(this.name, element.name === "" ? (body?.name ?? "") : element.name);
    const on = body === undefined || body.name === element.name ? "" : ` on ${body.name}`;
    setText(this.kind, element.type + on);
    this.update();
  }

  update(): void {
    if (this.shown === null) return;
    const placed = this.viewer.positionOf(this.shown, this.point);
    setText(this.place, placed ? formatPlace(this.point) : "");
  }
}

export class Tooltip extends ElementCard {
  constructor(viewer: Viewer) {
    super(viewer, "sb-card sb-tooltip");
    this.element.setAttribute("role", "tooltip");
  }

  /** Show it beside a point of the stage, inside of it. */
  showAt(element: SceneElement | null, x: number, y: number): void {
    this.show(element);
    if (element === null) return;
    const stage = this.element.parentElement;
    const [width, height] = [this.element.offsetWidth, this.element.offsetHeight];
    const left = Math.min(x + 14, (stage?.clientWidth ?? 0) - width - 8);
    const top = y + 18 + height > (stage?.clientHeight ?? 0) ? y - height - 12 : y + 18;
    this.element.style.transform = `translate(${Math.max(left, 4)}px, ${Math.max(top, 4)}px)`;
  }
}

export class SelectionCard extends ElementCard {
  constructor(viewer: Viewer) {
    const close = create("button", { type: "button", class: "sb-button sb-small", "aria-label": "Clear the selection" }, icon("close"));
    close.addEventListener("click", () => { viewer.select(null); });
    super(viewer, "sb-card sb-selection", close);
  }
}
