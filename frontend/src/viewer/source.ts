/** Where states come from: stored samples now, a function that steps later. */

import type { Motion, MotionCurve, MotionEvent, MotionVector, Scene } from "./contract";

/** Positions (B, 3) and quaternions (B, 4, scalar first) of all bodies, the ground first. */
export interface Pose {
  readonly positions: Float64Array;
  readonly quaternions: Float64Array;
}

/** The states of a mechanism over time. */
export interface StateSource {
  readonly start: number;
  readonly end: number;
  /** Times at which paths are drawn; ascending. */
  readonly times: Float64Array;
  readonly curves: readonly MotionCurve[];
  readonly vectors: readonly MotionVector[];
  readonly events: readonly MotionEvent[];
  /** Write the state at a time into `pose`; times outside are held at the ends. */
  poseAt(time: number, pose: Pose): void;
  /** Write the components (3) of a vector at a time, in ground's axes. */
  vectorAt(index: number, time: number, components: Float64Array): void;
  /** Write where a vector with places acts (3) at a time, in ground's axes. */
  placeAt(index: number, time: number, place: Float64Array): void;
  /** Return when and where a vector with places acted or not, `TOUCH_SIZE` numbers each: t, whether, x, y, z. */
  touches(index: number): readonly number[];
  /** Return the time of what is shown when a time was chosen. */
  timeShown(time: number): number;
}

export const TOUCH_SIZE = 5;

/** Return a pose with every body at the origin. */
export function restPose(bodies: number): Pose {
  const pose = { positions: new Float64Array(3 * bodies), quaternions: new Float64Array(4 * bodies) };
  for (let body = 0; body < bodies; body += 1) pose.quaternions[4 * body] = 1;
  return pose;
}

/** Return the last place whose time is not after `time`, but one before the end at most. */
export function sampleBefore(times: Float64Array, time: number): number {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time) low = middle;
    else high = middle;
  }
  return low;
}

/** Samples of a motion: positions and vectors go straight between two, quaternions along the arc. */
export class StoredMotion implements StateSource {
  readonly start: number;
  readonly end: number;
  readonly times: Float64Array;
  readonly curves: readonly MotionCurve[];
  readonly vectors: readonly MotionVector[];
  readonly events: readonly MotionEvent[];
  private readonly moving: number;
  private readonly touched: number[][] = [];

  constructor(
    private readonly motion: Motion,
    bodies: number,
  ) {
    this.times = motion.times;
    this.start = motion.times[0]!;
    this.end = motion.times[motion.times.length - 1]!;
    this.curves = motion.curves;
    this.vectors = motion.vectors;
    this.events = motion.events;
    this.moving = bodies - 1;
  }

  poseAt(time: number, pose: Pose): void {
    const before = sampleBefore(this.times, time);
    const weight = this.weight(before, time);
    const after = Math.min(before + 1, this.times.length - 1);
    const { positions, quaternions } = this.motion;
    const width = 3 * this.moving;
    for (let index = 0; index < width; index += 1) {
      const from = positions[before * width + index]!;
      pose.positions[3 + index] = from + weight * (positions[after * width + index]! - from);
    }
    for (let body = 0; body < this.moving; body += 1) {
      const a = 4 * (before * this.moving + body);
      const b = 4 * (after * this.moving + body);
      mixQuaternions(quaternions, a, b, weight, pose.quaternions, 4 * (body + 1));
    }
  }

  vectorAt(index: number, time: number, components: Float64Array): void {
    this.mix(this.vectors[index]!.values, time, components);
  }

  placeAt(index: number, time: number, place: Float64Array): void {
    const { places } = this.vectors[index]!;
    if (places !== null) this.mix(places, time, place);
  }

  touches(index: number): readonly number[] {
    const { values, places } = this.vectors[index]!;
    this.touched[index] ??= Array.from(this.times).flatMap((time, k) =>
      places === null ? [] : touch(time, values.subarray(3 * k, 3 * k + 3), places.subarray(3 * k, 3 * k + 3)),
    );
    return this.touched[index];
  }

  timeShown(time: number): number {
    return time;
  }

  private mix(values: Float32Array, time: number, into: Float64Array): void {
    const before = sampleBefore(this.times, time);
    const weight = this.weight(before, time);
    const after = Math.min(before + 1, this.times.length - 1);
    for (let axis = 0; axis < 3; axis += 1) {
      const from = values[3 * before + axis]!;
      into[axis] = from + weight * (values[3 * after + axis]! - from);
    }
  }

  private weight(before: number, time: number): number {
    const from = this.times[before]!;
    const to = this.times[Math.min(before + 1, this.times.length - 1)]!;
    return to > from ? Math.min(1, Math.max(0, (time - from) / (to - from))) : 0;
  }
}

function touch(time: number, force: ArrayLike<number>, place: ArrayLike<number>): number[] {
  return [time, Math.hypot(force[0]!, force[1]!, force[2]!) > 0 ? 1 : 0, place[0]!, place[1]!, place[2]!];
}

/** Write the normalized mix of two quaternions of `values` at `at` of `into`, the short way round. */
export function mixQuaternions(
  values: Float32Array,
  a: number,
  b: number,
  weight: number,
  into: Float64Array,
  at: number,
): void {
  let cosine = 0;
  for (let part = 0; part < 4; part += 1) cosine += values[a + part]! * values[b + part]!;
  const sign = cosine < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, Math.abs(cosine)));
  // below this angle sin(angle) loses its digits and the straight mix is exact enough
  const straight = angle < 1e-3;
  const first = straight ? 1 - weight : Math.sin((1 - weight) * angle);
  const second = sign * (straight ? weight : Math.sin(weight * angle));
  let square = 0;
  for (let part = 0; part < 4; part += 1) {
    const value = first * values[a + part]! + second * values[b + part]!;
    into[at + part] = value;
    square += value * value;
  }
  const length = Math.sqrt(square) || 1;
  for (let part = 0; part < 4; part += 1) into[at + part]! /= length;
}

/** Numbers of one state of all bodies but the ground, flat or as rows. */
export interface LiveState {
  readonly positions: readonly (number | readonly number[])[];
  readonly quaternions: readonly (number | readonly number[])[];
  /** Components of each vector of the source, where they are known. */
  readonly vectors?: readonly (number | readonly number[])[];
  /** Where each vector acts that has places, zeros for others. */
  readonly places?: readonly (number | readonly number[])[];
  /** Its time, where states follow each other. */
  readonly time?: number;
}

const MOST_TOUCHES = 20_000 * TOUCH_SIZE; // numbers that are kept of a vector

/** A source whose state can be replaced from outside, as live sliders do, until a time is chosen. */
export class LiveSource implements StateSource {
  private readonly live: Pose;
  private readonly liveVectors: Float64Array;
  private readonly livePlaces: Float64Array;
  private shown = false;
  private liveTime = NaN;
  private past: number[][] = [];

  constructor(
    private readonly base: StateSource,
    bodies: number,
  ) {
    this.live = restPose(bodies);
    this.liveVectors = new Float64Array(3 * base.vectors.length);
    this.livePlaces = new Float64Array(3 * base.vectors.length);
  }

  get start(): number { return this.base.start; }
  get end(): number { return this.base.end; }
  get times(): Float64Array { return this.base.times; }
  get curves(): readonly MotionCurve[] { return this.base.curves; }
  get vectors(): readonly MotionVector[] { return this.base.vectors; }
  get events(): readonly MotionEvent[] { return this.base.events; }

  /** Show a state, or with null those of the source again; numbers of another count are refused. */
  show(state: LiveState | null): boolean {
    this.shown = false;
    if (state === null) return true;
    const positions = state.positions.flat();
    const quaternions = state.quaternions.flat();
    const vectors = (state.vectors ?? []).flat();
    if (positions.length + 3 !== this.live.positions.length) return false;
    if (quaternions.length + 4 !== this.live.quaternions.length) return false;
    this.live.positions.set(positions, 3);
    this.live.quaternions.set(quaternions, 4);
    this.liveVectors.fill(0);
    if (vectors.length === this.liveVectors.length) this.liveVectors.set(vectors);
    const places = (state.places ?? []).flat();
    if (places.length === this.livePlaces.length) this.livePlaces.set(places);
    if (state.time !== undefined) this.note(state.time);
    this.shown = true;
    return true;
  }

  touches(index: number): readonly number[] {
    return Number.isNaN(this.liveTime) ? this.base.touches(index) : (this.past[index] ?? []);
  }

  timeShown(time: number): number {
    return this.shown && !Number.isNaN(this.liveTime) ? this.liveTime : time;
  }

  /** Add the state shown to what is known of the motion; an earlier one begins anew. */
  private note(time: number): void {
    const goesOn = time >= this.liveTime;
    const isNew = time !== this.liveTime;
    this.liveTime = time;
    this.vectors.forEach((vector, index) => {
      if (vector.places === null || !isNew) return;
      const before = this.past[index] ?? [];
      const [from, to] = [3 * index, 3 * index + 3];
      const here = touch(time, this.liveVectors.subarray(from, to), this.livePlaces.subarray(from, to));
      if (goesOn && before.length < MOST_TOUCHES) before.push(...here);
      else this.past[index] = [...(goesOn ? before.slice(before.length / 2) : []), ...here];
    });
  }

  poseAt(time: number, pose: Pose): void {
    if (!this.shown) {
      this.base.poseAt(time, pose);
      return;
    }
    pose.positions.set(this.live.positions);
    pose.quaternions.set(this.live.quaternions);
  }

  vectorAt(index: number, time: number, components: Float64Array): void {
    if (!this.shown) this.base.vectorAt(index, time, components);
    else for (let axis = 0; axis < 3; axis += 1) components[axis] = this.liveVectors[3 * index + axis]!;
  }

  placeAt(index: number, time: number, place: Float64Array): void {
    if (!this.shown) this.base.placeAt(index, time, place);
    else for (let axis = 0; axis < 3; axis += 1) place[axis] = this.livePlaces[3 * index + axis]!;
  }
}

/** Return the source of a motion, or of bodies that rest at the origin where there is none. */
export function sourceOf(scene: Scene, motion: Motion | null): StateSource {
  const bodies = scene.bodies.length;
  return new StoredMotion(motion ?? restMotion(bodies), bodies);
}

function restMotion(bodies: number): Motion {
  const quaternions = new Float32Array(restPose(bodies - 1).quaternions);
  const positions = new Float32Array(3 * (bodies - 1));
  return { times: new Float64Array(1), positions, quaternions, curves: [], vectors: [], events: [] };
}
