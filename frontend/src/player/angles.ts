/** How curves of angles are shown: in radians or degrees, counted on or wrapped to one turn; remembered in the browser. */

import type { MotionCurve } from "../viewer";

export interface AngleView {
  readonly degrees: boolean;
  /** Whether angles stay between half a turn to one side and half a turn to the other. */
  readonly wrap: boolean;
}

const KEY = "symbody-angles";
const AS_FILES: AngleView = { degrees: false, wrap: false };
const ANGLES = /^(?:rad|deg)(?=$|\/s)/; // degrees are those of formulas

/** Return what was chosen last; a page in a frame may have no storage. */
export function rememberedAngles(): AngleView {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "{}") as Partial<AngleView>;
    return { degrees: kept.degrees === true, wrap: kept.wrap === true };
  } catch {
    return AS_FILES;
  }
}

export function rememberAngles(view: AngleView): void {
  try {
    localStorage.setItem(KEY, JSON.stringify(view));
  } catch {
    // it holds for this page
  }
}

/** Whether a unit is that of an angle or its rates. */
export function isAngular(unit: string): boolean {
  return ANGLES.test(unit);
}

/** Return one turn in the unit of an angle; 0: it is none. */
export function turnOf(unit: string): number {
  return unit === "rad" ? 2 * Math.PI : unit === "deg" ? 360 : 0;
}

/** Return a value within half a turn of zero, half a turn itself included. */
export function wrapped(value: number, turn: number): number {
  return value - turn * Math.ceil(value / turn - 0.5);
}

/** Return a curve as it is shown; what is no angle stays. */
export function inView(curve: MotionCurve, { degrees, wrap }: AngleView): MotionCurve {
  if (!isAngular(curve.unit)) return curve;
  const converts = degrees && curve.unit.startsWith("rad");
  const unit = converts ? curve.unit.replace(ANGLES, "deg") : curve.unit;
  const factor = converts ? 180 / Math.PI : 1;
  const turn = wrap ? turnOf(unit) : 0;
  const shown = (value: number): number => (turn > 0 ? wrapped(factor * value, turn) : factor * value);
  return { ...curve, unit, values: curve.values.map(shown) };
}
