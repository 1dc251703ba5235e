/** Names beside bodies, joints and vectors: text over the picture, never one over another. */

import { Vector3, type Camera } from "three";

export interface LabelItem {
  readonly text: string;
  readonly kind: "body" | "joint" | "vector";
  readonly color: string;
  /** Write the place in ground's axes; return whether the label is to be shown. */
  place(into: Vector3): boolean;
}

interface Label {
  readonly item: LabelItem;
  readonly element: HTMLElement;
  width: number;
  height: number;
  shown: boolean;
}

const GAP = 8; // from the point to the text, pixels

export class Labels {
  readonly element = document.createElement("div");
  private readonly labels: Label[];
  private readonly point = new Vector3();
  private readonly taken: number[] = [];

  constructor(items: readonly LabelItem[]) {
    this.element.className = "sb-labels";
    this.element.setAttribute("aria-hidden", "true");
    this.labels = items.map((item) => {
      const element = document.createElement("span");
      element.className = `sb-label sb-label-${item.kind}`;
      element.textContent = item.text;
      element.style.setProperty("--sb-label-color", item.color);
      element.hidden = true;
      this.element.append(element);
      return { item, element, width: 0, height: 0, shown: false };
    });
  }

  update(camera: Camera, width: number, height: number): void {
    this.taken.length = 0;
    for (const label of this.labels) {
      const visible = label.item.place(this.point) && this.project(label, camera, width, height);
      if (visible !== label.shown) {
        label.element.hidden = !visible;
        label.shown = visible;
      }
    }
  }

  private project(label: Label, camera: Camera, width: number, height: number): boolean {
    this.point.project(camera);
    if (Math.abs(this.point.z) > 1) return false;
    if (label.width === 0) this.measure(label);
    const x = Math.round(((this.point.x + 1) / 2) * width + GAP);
    const y = Math.round(((1 - this.point.y) / 2) * height - label.height - GAP / 2);
    if (x < 0 || y < 0 || x + label.width > width || y + label.height > height) return false;
    if (this.overlaps(x, y, label)) return false;
    this.taken.push(x, y, label.width, label.height);
    label.element.style.transform = `translate(${x}px, ${y}px)`;
    return true;
  }

  private measure(label: Label): void {
    label.element.hidden = false;
    label.shown = true;
    label.width = label.element.offsetWidth;
    label.height = label.element.offsetHeight;
  }

  private overlaps(x: number, y: number, label: Label): boolean {
    const { taken } = this;
    for (let at = 0; at < taken.length; at += 4) {
      const beside = x > taken[at]! + taken[at + 2]! + 2 || taken[at]! > x + label.width + 2;
      const apart = y > taken[at + 1]! + taken[at + 3]! || taken[at + 1]! > y + label.height;
      if (!beside && !apart) return true;
    }
    return false;
  }
}
