/** The axes of the ground as the camera sees them, in a corner of the picture. */

import type { Camera } from "three";
import { Vector3 } from "three";
import { createSvg } from "./dom";

const AXES = ["x", "y", "z"] as const;
const REACH = 26;

export class Triad {
  readonly element: SVGElement;
  private readonly arms: { line: SVGElement; text: SVGElement; group: SVGElement }[];
  private readonly axis = new Vector3();
  private last = "";

  constructor() {
    this.arms = AXES.map((name) => {
      const line = createSvg("line", { x1: 0, y1: 0 });
      const text = createSvg("text", {}, name);
      return { line, text, group: createSvg("g", { class: `sb-axis sb-axis-${name}` }, line, text) };
    });
    this.element = createSvg(
      "svg",
      { class: "sb-triad", viewBox: "-42 -42 84 84", width: 76, height: 76, "aria-hidden": "true" },
      ...this.arms.map((arm) => arm.group),
    );
  }

  update(camera: Camera): void {
    const turn = camera.quaternion.toArray().map((each) => each.toFixed(3)).join();
    if (turn === this.last) return;
    this.last = turn;
    const inverse = camera.quaternion.clone().invert();
    this.arms.forEach(({ line, text, group }, index) => {
      this.axis.set(0, 0, 0).setComponent(index, 1).applyQuaternion(inverse);
      const [x, y] = [REACH * this.axis.x, -REACH * this.axis.y];
      line.setAttribute("x2", x.toFixed(1));
      line.setAttribute("y2", y.toFixed(1));
      const length = Math.hypot(x, y);
      group.classList.toggle("sb-away", length < 6); // it points at the viewer
      text.setAttribute("x", (x + (9 * x) / (length || 1)).toFixed(1));
      text.setAttribute("y", (y + (9 * y) / (length || 1)).toFixed(1));
    });
  }
}
