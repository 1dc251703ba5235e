/** The simulation that a page holds, as `symbody.simulation.programs` writes it, and what the page adds to it. */

import { DataError, Reader, type LiveState, type Motion, type MotionVector } from "../viewer";

export interface Simulation {
  readonly time: number;
  readonly code: number;
  /** Speeds, coordinates, and the work done. */
  readonly state: Float64Array;
  readonly isPulled: boolean;
  readonly numbers: {
    readonly codes: Readonly<Record<string, number>>;
    readonly startTime: number;
    readonly pull: object | null;
  };
  /** Go on to a time [s] with at most so many trials of steps; return whether it was reached. */
  advanceTo(time: number, trials?: number): boolean;
  computePose(): { readonly positions: Float64Array; readonly axes: Float64Array };
  placeOf(body: number, point: readonly number[]): number[];
  hold(body: number, point: readonly number[], target: readonly number[]): void;
  moveTarget(target: readonly number[]): void;
  release(): void;
  setParameter(name: string, value: number, held?: readonly string[]): boolean;
  setInput(name: string, value: number): void;
  setInitial(values: Readonly<Record<string, number>>, chosen: string): boolean;
  parameter(name: string): number;
  input(name: string): number;
  initial(name: string): number;
  reset(): void;
  violation(): number;
  energies(): { readonly kinetic: number; readonly potential: number; readonly work: number };
}

export const KINDS = ["parameter", "input", "initial"] as const;
export type Kind = (typeof KINDS)[number];

/** A slider of the page: what it moves, between which values, and where it starts. */
export interface Control {
  readonly name: string;
  readonly kind: Kind;
  readonly min: number;
  readonly max: number;
  readonly value: number;
  readonly unit: string;
}

/** Numbers of the scene, by their way in it, at equal distances of a parameter; of a mesh all corners, distance by distance. */
export interface SceneTable {
  readonly parameter: string;
  readonly min: number;
  readonly max: number;
  readonly entries: readonly (readonly [way: readonly (string | number)[], values: readonly number[] | Float32Array])[];
}

interface WrittenTable extends Omit<SceneTable, "entries"> {
  readonly entries: readonly (readonly [readonly (string | number)[], readonly number[] | string])[];
}

export interface LiveData {
  readonly controls: readonly Control[];
  readonly tables: readonly SceneTable[];
}

/** Return what a page says of its sliders, or throw a `DataError`. */
export function readLive(value: unknown): LiveData {
  if (typeof value !== "object" || value === null) throw new DataError("live", "this page has no sliders");
  const { controls, tables } = value as Record<string, unknown>;
  if (!Array.isArray(controls) || !Array.isArray(tables)) throw new DataError("live", "is truncated");
  for (const control of controls as Partial<Control>[]) {
    if (typeof control.name !== "string" || !KINDS.includes(control.kind!) || !(control.min! < control.max!)) {
      throw new DataError("live.controls", "is damaged");
    }
  }
  return { controls: controls as Control[], tables: (tables as WrittenTable[]).map(readTable) };
}

function readTable({ entries, ...table }: WrittenTable): SceneTable {
  return {
    ...table,
    entries: entries.map(([way, values]) => [way, typeof values === "string" ? new Reader(values, "live.tables").floats() : values]),
  };
}

/** Return JSON of a scene with the numbers that parameters change: those of each table add up. */
export function sceneFor(base: unknown, tables: readonly SceneTable[], value: (parameter: string) => number, first: (parameter: string) => number): unknown {
  const scene = structuredClone(base);
  for (const table of tables) {
    for (const [way, values] of table.entries) {
      const change = (number: number, width: number): number =>
        tabulated(table, values, value(table.parameter), number, width) - tabulated(table, values, first(table.parameter), number, width);
      const holder = way.slice(0, -1).reduce<unknown>((each, key) => (each as Record<string | number, unknown>)[key], scene) as Record<string | number, unknown>;
      const key = way[way.length - 1]!;
      const before = holder[key];
      if (typeof before === "number") holder[key] = before + change(0, 1);
      else {
        const corners = new Reader(before, way.join(".")).floats();
        holder[key] = corners.map((each, number) => each + change(number, corners.length));
      }
    }
  }
  return scene;
}

/** Return one of `width` numbers that stand side by side in a table, at a value of its parameter. */
function tabulated({ min, max }: SceneTable, values: readonly number[] | Float32Array, x: number, number: number, width: number): number {
  const count = values.length / width;
  const place = Math.min(Math.max((x - min) / (max - min), 0), 1) * (count - 1);
  const row = Math.min(Math.floor(place), count - 2);
  const [before, after] = [values[row * width + number]!, values[(row + 1) * width + number]!];
  return before + (place - row) * (after - before);
}

/** Return quaternions (4 each, scalar first) of rotation matrices (9 each, by rows). */
export function quaternionsOf(axes: Float64Array): number[] {
  const result: number[] = [];
  for (let at = 0; at < axes.length; at += 9) {
    const [a, b, c, d, e, f, g, h, i] = axes.subarray(at, at + 9) as unknown as [number, number, number, number, number, number, number, number, number];
    const sizes = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i];
    const rows = [
      [sizes[0]!, h - f, c - g, d - b],
      [h - f, sizes[1]!, b + d, c + g],
      [c - g, b + d, sizes[2]!, f + h],
      [d - b, c + g, f + h, sizes[3]!],
    ];
    const row = rows[sizes.indexOf(Math.max(...sizes))]!;
    const length = Math.hypot(...row);
    result.push(...row.map((each) => each / length));
  }
  return result;
}

const PREVIEW = 8; // seconds
const SAMPLES = 80;

/** Return the state shown of so many bodies; what follows them are arrows: each a place, and components in the first row of its axes. */
export function stateOf(simulation: Simulation, bodies: number): Required<LiveState> {
  const { positions, axes } = simulation.computePose();
  const arrows = Array.from({ length: positions.length / 3 - bodies }, (_, k) => bodies + k);
  return {
    positions: Array.from(positions.subarray(0, 3 * bodies)),
    quaternions: quaternionsOf(axes.subarray(0, 9 * bodies)),
    vectors: arrows.flatMap((k) => Array.from(axes.subarray(9 * k, 9 * k + 3))),
    places: arrows.flatMap((k) => Array.from(positions.subarray(3 * k, 3 * k + 3))),
    time: simulation.time,
  };
}

/** Return the first seconds of a motion of so many bodies, as far as it can be computed and the page need not wait. */
export function previewOf(simulation: Simulation, bodies: number, vectors: readonly MotionVector[]): Motion {
  const times: number[] = [];
  const states: Required<LiveState>[] = [];
  const { startTime, codes } = simulation.numbers;
  for (let k = 0; k < SAMPLES; k += 1) {
    const time = startTime + (PREVIEW * k) / (SAMPLES - 1);
    const isReached = simulation.advanceTo(time, 2000);
    times.push(isReached ? time : simulation.time);
    states.push(stateOf(simulation, bodies));
    if (!isReached || simulation.code !== codes["RUNNING"]) break;
  }
  return {
    times: Float64Array.from(times),
    positions: Float32Array.from(states.flatMap((each) => each.positions.flat())),
    quaternions: Float32Array.from(states.flatMap((each) => each.quaternions.flat())),
    curves: [],
    vectors: vectors.map((vector, k) => ({
      ...vector,
      values: Float32Array.from(states.flatMap((each) => each.vectors.slice(3 * k, 3 * k + 3).flat())),
      places: vector.places === null ? null : Float32Array.from(states.flatMap((each) => each.places.slice(3 * k, 3 * k + 3).flat())),
    })),
    events: [],
  };
}
