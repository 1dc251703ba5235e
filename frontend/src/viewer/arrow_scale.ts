/** How long arrows are drawn, and the round value that a legend shows. */

import type { MotionVector, VectorKind } from "./contract";

const LONGEST = 0.45; // of the scene's size

/** Return the largest magnitude among the vectors of a kind, 0 where there is none. */
export function largestMagnitude(vectors: readonly MotionVector[], kind: VectorKind): number {
  let square = 0;
  for (const vector of vectors) {
    if (vector.kind !== kind) continue;
    for (let at = 0; at + 2 < vector.values.length; at += 3) {
      const [x, y, z] = [vector.values[at]!, vector.values[at + 1]!, vector.values[at + 2]!];
      square = Math.max(square, x * x + y * y + z * z);
    }
  }
  return Math.sqrt(square);
}

/** Return the metres that one newton (or newton metre) is drawn with. */
export function arrowScale(largest: number, sceneSize: number): number {
  return largest > 0 ? (LONGEST * sceneSize) / largest : 0;
}

/** Return the largest of 1, 2, 5 times a power of ten that is not above `value` > 0. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-12);
  const factor = [5, 2, 1].find((each) => each * power <= value * (1 + 1e-9)) ?? 1;
  return factor * power;
}

/** Return a number with a few digits and its unit, with SI prefixes from thousands on. */
export function formatQuantity(value: number, unit: string): string {
  const [factor, prefix] = value >= 1e6 ? [1e6, "M"] : value >= 1e3 ? [1e3, "k"] : [1, ""];
  return `${Number((value / factor).toPrecision(3))}\u202f${prefix}${unit}`;
}
