/** How long arrows are drawn, and the round value that a legend shows. */

import type { MotionVector, VectorKind } from "./contract";

const USUAL = 0.35; // of the scene's size
/** Of the scene's size: longer arrows are cut off, such as those of impacts. */
export const LONGEST = 0.7;
const SHARE = 0.9; // of the time in which a vector acts it is no larger than what sets the scale
const NOTHING = 1e-9; // of the largest magnitude

/**
 * Return the magnitude up to which the vectors of a kind are drawn in full, 0 where there is none: the largest of those that each
 * has for all but a tenth of the time in which it acts. The peak of an impact would make all else too short to be seen.
 */
export function usualMagnitude(vectors: readonly MotionVector[], kind: VectorKind, times: ArrayLike<number>): number {
  return Math.max(0, ...vectors.filter((each) => each.kind === kind).map((each) => usualOf(each, times)));
}

function usualOf({ values }: MotionVector, times: ArrayLike<number>): number {
  const sizes = Array.from({ length: Math.floor(values.length / 3) }, (_, k) => Math.hypot(values[3 * k]!, values[3 * k + 1]!, values[3 * k + 2]!));
  const largest = Math.max(0, ...sizes);
  const last = times.length - 1;
  const acting = sizes
    .map((size, k) => ({ size, span: times[Math.min(k + 1, last)]! - times[Math.max(k - 1, 0)]! }))
    .filter(({ size, span }) => size > NOTHING * largest && span > 0)
    .sort((a, b) => a.size - b.size);
  let left = SHARE * acting.reduce((sum, { span }) => sum + span, 0);
  for (const { size, span } of acting) {
    left -= span;
    if (left <= 0) return size;
  }
  return largest;
}

/** Return the metres that one newton (or newton metre) is drawn with. */
export function arrowScale(usual: number, sceneSize: number): number {
  return usual > 0 ? (USUAL * sceneSize) / usual : 0;
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
