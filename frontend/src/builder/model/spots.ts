/** Places and sizes in the diagram. */

export type Spot = readonly [number, number];

export interface Size {
  readonly width: number;
  readonly height: number;
}
