/** Places and sizes in the diagram. */

export type Spot = readonly [number, number];

export interface Size {
  readonly width: number;
  readonly height: number;
}

export type Side = "left" | "right" | "top" | "bottom";
export const SIDES: readonly Side[] = ["left", "right", "top", "bottom"];
export const GRID = 10;
