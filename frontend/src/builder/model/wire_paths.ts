/** The lines of wires and the places of their labels. */

import { pointAt, type Curve } from "./curves";
import type { Spot } from "./layout";

/** A box of the diagram, from its middle. */
export interface WireEnd {
  readonly middle: Spot;
  readonly width: number;
  readonly height: number;
  /** Whether it is a signal, with an inlet on the left and an outlet on the right. */
  readonly sided: boolean;
}

interface Leaving {
  readonly at: Spot;
  /** Away from the box. */
  readonly outward: Spot;
}

const ARROW = 9;
const LEAST = 40;

/** Return where a wire leaves or enters a box: between signals at their sides, else above or below. */
function leaving(end: WireEnd, { middle: towards, sided }: WireEnd, side: 1 | -1): Leaving {
  const [x, y] = end.middle;
  if (end.sided && sided) return { at: [x + (side * end.width) / 2, y], outward: [side, 0] };
  const down = towards[1] >= y ? 1 : -1;
  // what goes out of a box and what comes in are apart
  const across = 0.18 * side * end.width + Math.max(-0.22 * end.width, Math.min(0.22 * end.width, 0.12 * (towards[0] - x)));
  return { at: [x + across, y + (down * end.height) / 2], outward: [0, down] };
}

/** Return the line of a wire; one that goes back to the left swings below. */
export function wireCurve(source: WireEnd, target: WireEnd): Curve {
  const start = leaving(source, target, 1);
  const end = leaving(target, source, -1);
  const [dx, dy] = [end.at[0] - start.at[0], end.at[1] - start.at[1]];
  // what leads to a signal bends late, what comes from it early: the two ways between the same boxes are apart
  const [share, most] = target.sided ? [0.45, 140] : [0.3, 70];
  const reach = Math.max(LEAST, share * Math.hypot(dx, dy));
  const isBack = source.sided && target.sided && dx < 0;
  const swing = isBack ? Math.max(90, 0.3 * -dx) : 0;
  const control = ({ at, outward }: Leaving): Spot => [at[0] + outward[0] * Math.min(reach, 220), at[1] + outward[1] * Math.min(reach, most) + swing];
  return [start.at, control(start), control(end), end.at];
}

/** Return the head of an arrow at the end of a line, as the corners of a polygon. */
export function arrowHead([, , before, [x, y]]: Curve): string {
  const [dx, dy] = [x - before[0], y - before[1]];
  const length = Math.hypot(dx, dy) || 1;
  const [ux, uy] = [dx / length, dy / length];
  const corner = (side: number): string => `${(x - ARROW * ux + side * 0.45 * ARROW * uy).toFixed(1)},${(y - ARROW * uy - side * 0.45 * ARROW * ux).toFixed(1)}`;
  return `${x.toFixed(1)},${y.toFixed(1)} ${corner(1)} ${corner(-1)}`;
}

export interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

const PARTS = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74, 0.18, 0.82];
const LABEL_HEIGHT = 16;

function common(a: Box, b: Box): number {
  const width = Math.min(a.x + a.width, b.x + b.width) - Math.max(a.x, b.x);
  const height = Math.min(a.y + a.height, b.y + b.height) - Math.max(a.y, b.y);
  return width > 0 && height > 0 ? width * height : 0;
}

/** Return the box of a label on a line where it covers least of what is drawn already. */
export function labelBox(curve: Curve, width: number, taken: readonly Box[]): Box {
  const boxes = PARTS.map((part) => {
    const [x, y] = pointAt(curve, part);
    return { x: x - width / 2, y: y - LABEL_HEIGHT / 2, width, height: LABEL_HEIGHT };
  });
  const costs = boxes.map((box) => taken.reduce((sum, other) => sum + common(box, other), 0));
  return boxes[costs.indexOf(Math.min(...costs))]!;
}
