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
}

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
    const before = sampleBefore(this.times, time);
    const weight = this.weight(before, time);
    const after = Math.min(before + 1, this.times.length - 1);
    const { values } = this.vectors[index]!;
    for (let axis = 0; axis < 3; axis += 1) {
      const from = values[3 * before + axis]!;
      components[axis] = from + weight * (values[3 * after + axis]! - from);
    }
  }

  private weight(before: number, time: number): number {
    const from = this.times[before]!;
    const to = this.times[Math.min(before + 1, this.times.length - 1)]!;
    return to > from ? Math.min(1, Math.max(0, (time - from) / (to - from))) : 0;
  }
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

/** One state that is replaced from outside, as a live slider does. */
export class LivePose implements StateSource {
  readonly start = 0;
  readonly end = 0;
  readonly times = new Float64Array(1);
  readonly curves: readonly MotionCurve[] = [];
  readonly vectors: readonly MotionVector[] = [];
  readonly events: readonly MotionEvent[] = [];
  private readonly pose: Pose;

  constructor(bodies: number) {
    this.pose = restPose(bodies);
  }

  /** Take positions (B, 3) and quaternions (B, 4) of all bodies but the ground, flat or as rows. */
  set(positions: readonly (number | readonly number[])[], quaternions: readonly (number | readonly number[])[]): void {
    this.pose.positions.set(positions.flat().slice(0, this.pose.positions.length - 3), 3);
    this.pose.quaternions.set(quaternions.flat().slice(0, this.pose.quaternions.length - 4), 4);
  }

  poseAt(_time: number, pose: Pose): void {
    pose.positions.set(this.pose.positions);
    pose.quaternions.set(this.pose.quaternions);
  }

  vectorAt(_index: number, _time: number, components: Float64Array): void {
    components.fill(0);
  }
}

/** Return the source of a motion, or of a scene that rests where there is none. */
export function sourceOf(scene: Scene, motion: Motion | null): StateSource {
  return motion === null ? new LivePose(scene.bodies.length) : new StoredMotion(motion, scene.bodies.length);
}
