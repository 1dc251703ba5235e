/** The axes of the ground and the direction of gravity as the camera sees them, in a corner of the picture. */

import type { Camera } from "three";
import { Quaternion, Vector3 } from "three";
import type { Scene } from "../viewer";
import { createSvg } from "./dom";

const AXES = ["x", "y", "z"] as const;
const REACH = 26;
const FALL = { x: 52, y: -16, reach: 30 }; // where the arrow of gravity begins, and its length

export class Triad {
  readonly element: SVGElement;
  private readonly arms: { line: SVGElement; text: SVGElement; group: SVGElement }[];
  private readonly axis = new Vector3();
  private readonly last = new Quaternion(0, 0, 0, 0);
  private readonly fall: SVGElement | null;
  private readonly pull = new Vector3();

  constructor({ gravity }: Scene) {
    this.arms = AXES.map((name) => {
      const line = createSvg("line", { x1: 0, y1: 0 });
      const text = createSvg("text", {}, name);
      return { line, text, group: createSvg("g", { class: `sb-axis sb-axis-${name}` }, line, text) };
    });
    this.element = createSvg(
      "svg",
      { class: "sb-triad", viewBox: "-42 -42 190 84", width: 172, height: 76, "aria-hidden": "true" },
      ...this.arms.map((arm) => arm.group),
    );
    this.fall = gravity === null ? null : createSvg("path", {});
    if (gravity === null || this.fall === null) return;
    this.pull.set(...gravity);
    const size = Number(this.pull.length().toPrecision(3));
    this.pull.normalize();
    const text = createSvg("text", { x: FALL.x + 10, y: FALL.y + FALL.reach / 2 }, `g ${size}\u202fm/s²`);
    this.element.append(createSvg("g", { class: "sb-gravity" }, this.fall, text));
  }

  update(camera: Camera): void {
    if (this.last.equals(camera.quaternion)) return;
    this.last.copy(camera.quaternion);
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
    this.axis.copy(this.pull).applyQuaternion(inverse);
    this.fall?.setAttribute("d", arrowPath(FALL.reach * this.axis.x, -FALL.reach * this.axis.y));
  }

  showGravity(on: boolean): void {
    this.element.classList.toggle("sb-no-gravity", !on);
  }
}

/** Return the arrow of gravity that spans (x, y), as long as it looks. */
function arrowPath(x: number, y: number): string {
  const length = Math.hypot(x, y);
  if (length < 3) return "";
  const [u, v] = [x / length, y / length];
  const [left, top] = [FALL.x - Math.min(x, 0) / 2, FALL.y - Math.min(y, 0)];
  const head = (side: number): string => {
    const [back, across] = [7, 4 * side];
    return `${(left + x - back * u - across * v).toFixed(1)} ${(top + y - back * v + across * u).toFixed(1)}`;
  };
  const tip = `${(left + x).toFixed(1)} ${(top + y).toFixed(1)}`;
  return `M${left.toFixed(1)} ${top.toFixed(1)}L${tip}M${head(1)}L${tip}L${head(-1)}`;
}
