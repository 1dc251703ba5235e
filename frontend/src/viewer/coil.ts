/** The path of a spring: straight ends, and turns between them that stretch with it. */

import { turnAcross } from "./tube";

type Triple = [number, number, number];

const POINTS_A_TURN = 20;
const STRAIGHT = 0.1; // part of the length that each end takes

/** Return how many points the path of a spring with so many turns has. */
export function coilPoints(turns: number): number {
  return turns * POINTS_A_TURN + 3;
}

/**
 * Write the path from `start` to `end` into `path`.
 *
 * `across` holds the direction in which the turns begin; it follows the axis without a jump from one
 * call to the next.
 */
export function writeCoil(
  start: Readonly<Triple>,
  end: Readonly<Triple>,
  turns: number,
  radius: number,
  across: Triple,
  path: Float64Array,
): void {
  const axis: Triple = [end[0] - start[0], end[1] - start[1], end[2] - start[2]];
  const length = Math.hypot(axis[0], axis[1], axis[2]);
  if (length > 0) for (let part = 0; part < 3; part += 1) axis[part]! /= length;
  else axis[2] = 1;
  turnAcross(axis, across);
  const steps = turns * POINTS_A_TURN;
  place(path, 0, start, axis, 0, across, 0, 0);
  for (let step = 0; step <= steps; step += 1) {
    const part = step / steps;
    const along = length * (STRAIGHT + (1 - 2 * STRAIGHT) * part);
    const angle = 2 * Math.PI * turns * part;
    // the turns open over a third of a turn at each end
    const open = Math.min(1, (3 * Math.min(step, steps - step)) / POINTS_A_TURN);
    place(path, step + 1, start, axis, along, across, radius * open, angle);
  }
  place(path, steps + 2, start, axis, length, across, 0, 0);
}

function place(
  path: Float64Array,
  index: number,
  start: Readonly<Triple>,
  axis: Readonly<Triple>,
  along: number,
  across: Readonly<Triple>,
  radius: number,
  angle: number,
): void {
  const c = radius * Math.cos(angle);
  const s = radius * Math.sin(angle);
  const upX = axis[1] * across[2] - axis[2] * across[1];
  const upY = axis[2] * across[0] - axis[0] * across[2];
  const upZ = axis[0] * across[1] - axis[1] * across[0];
  path[3 * index] = start[0] + along * axis[0] + c * across[0] + s * upX;
  path[3 * index + 1] = start[1] + along * axis[1] + c * across[1] + s * upY;
  path[3 * index + 2] = start[2] + along * axis[2] + c * across[2] + s * upZ;
}
