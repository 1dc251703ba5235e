/** Where points of bodies are along the motion: paths of traces, extents of the whole. */

import { Box3, Matrix4, Vector3, type BufferGeometry } from "three";
import type { Anchor, Scene, Solid } from "./contract";
import { placeMatrix, writeMatrices, type Instant } from "./layer";
import { shapeOf } from "./shapes";
import { GeometryStore } from "./solids";
import { restPose, type StateSource } from "./source";

const SAMPLES = 80;
const MOST_GROUND = 1.8; // a ground that is larger, in parts of what moves, may stick out
const MOST_POINTS = 24_000; // that a view is fitted to
/** Types of joints that hold nothing in its place. */
export const LOOSE: readonly string[] = ["free", "cartesian", "rectangular", "planar"];
const STANDS = 0.1; // of the size of a mechanism, by which an arm on its base may be lower than that at the start
const HIGH = 12; // times its size: a mechanism above ground that is seen rises and falls in a picture that stays level
const FAR = 3; // times its own extent: a mechanism that moves farther is followed by the camera

/** Call `visit` with the state at each of the times; the instant is reused. */
export function visitStates(
  scene: Scene,
  source: StateSource,
  times: ArrayLike<number>,
  visit: (instant: Instant, index: number) => void,
): void {
  const pose = restPose(scene.bodies.length);
  const matrices = scene.bodies.map(() => new Matrix4());
  for (let index = 0; index < times.length; index += 1) {
    const time = times[index]!;
    source.poseAt(time, pose);
    writeMatrices(pose, matrices);
    visit({ time, matrices }, index);
  }
}

/** Return evenly chosen times of a source, its ends included. */
export function chosenTimes(source: StateSource, count: number): number[] {
  if (source.end <= source.start) return [source.start];
  return Array.from({ length: count }, (_, i) => source.start + ((source.end - source.start) * i) / (count - 1));
}

/** Return the points (N, 3) that an anchor passes at the source's times. */
export function anchorPath(scene: Scene, source: StateSource, anchor: Anchor): Float32Array {
  const path = new Float32Array(3 * source.times.length);
  const point = new Vector3();
  visitStates(scene, source, source.times, (instant, index) => {
    point.fromArray(anchor.at).applyMatrix4(instant.matrices[anchor.body]!).toArray(path, 3 * index);
  });
  return path;
}

/** Return the least length of each connector along the motion [m]. */
export function shortestLengths(scene: Scene, source: StateSource): number[] {
  const shortest = scene.connectors.map(() => Infinity);
  const [start, end] = [new Vector3(), new Vector3()];
  visitStates(scene, source, chosenTimes(source, SAMPLES), ({ matrices }) => {
    scene.connectors.forEach((connector, index) => {
      start.fromArray(connector.start.at).applyMatrix4(matrices[connector.start.body]!);
      end.fromArray(connector.end.at).applyMatrix4(matrices[connector.end.body]!);
      shortest[index] = Math.min(shortest[index]!, start.distanceTo(end));
    });
  });
  return shortest;
}

/** Return the box of a body's shapes, frames and the anchors on it, in its own axes. */
function bodyBox(scene: Scene, body: number, store: GeometryStore): Box3 {
  const box = new Box3();
  const { solids, frames } = scene.bodies[body]!;
  for (const solid of solids) box.union(solidBox(scene, solid, store));
  // a ground's frames may be far from all that is drawn
  if (body > 0 || box.isEmpty()) for (const frame of frames) box.expandByPoint(new Vector3(...frame.at));
  const anchors = scene.connectors.flatMap((each) => [each.start, each.end]);
  for (const anchor of anchors) if (anchor.body === body) box.expandByPoint(new Vector3(...anchor.at));
  return box;
}

function solidBox(scene: Scene, solid: Solid, store: GeometryStore): Box3 {
  const { key, scale } = shapeOf(solid);
  const box = solid.mesh === null ? unitBox(store.get(key)) : new Box3().setFromArray(scene.meshes[solid.mesh]!.vertices);
  return box.isEmpty() ? box : box.applyMatrix4(placeMatrix(solid.at, solid.quaternion, scale));
}

/** Return the box of a shape of unit size; its geometry keeps it. */
function unitBox(geometry: BufferGeometry): Box3 {
  if (geometry.boundingBox === null) geometry.computeBoundingBox();
  return geometry.boundingBox?.clone() ?? new Box3();
}

/** What a camera has to hold: points on everything along the motion, and their box. */
export interface Extent {
  readonly points: Float32Array;
  readonly box: Box3;
  /** Whether the mechanism goes far: then the points are those of a camera that goes along with its centre. */
  readonly roams: boolean;
  /** Along which direction such a camera stays where it is: upwards, so that what bounces does so above its ground. */
  readonly fixed: Vector3 | null;
  /** The least height of all that is seen, across the plane of a planar mechanism: that of its floor. */
  readonly level: number;
}

/** Return the length that arrows and footprints are drawn by: the scene's size, or more where the picture shows more [m]. */
export function drawnSize(scene: Scene, extent: Extent): number {
  return Math.max(scene.size, 0.5 * extent.box.getSize(new Vector3()).length());
}

/** Write the mean place of all bodies but the ground, by their mass [m]. */
export function centreOf(scene: Scene, matrices: readonly Matrix4[], into: Vector3): Vector3 {
  const whole = scene.bodies.slice(1).reduce((sum, body) => sum + body.mass, 0);
  into.set(0, 0, 0);
  const place = new Vector3();
  for (let body = 1; body < matrices.length; body += 1) {
    const share = whole > 0 ? scene.bodies[body]!.mass / whole : 1 / (matrices.length - 1);
    into.addScaledVector(place.setFromMatrixPosition(matrices[body]!), share);
  }
  return into;
}

/** Return the extent of the whole motion, without a ground that is far larger than the rest. */
export function motionExtent(scene: Scene, source: StateSource, store = new GeometryStore(scene)): Extent {
  const local = scene.bodies.map((_, body) => boxCorners(bodyBox(scene, body, store)));
  const samples = Math.min(Math.max(Math.floor(MOST_POINTS / (8 * local.length)), 6), SAMPLES);
  const moving: number[] = [];
  const carried: number[] = []; // beside the centre, which is where it is at the start
  const [corner, first, centre, gone] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
  const fixed = staysLevel(scene, source, local);
  let atStart = 0;
  visitStates(scene, source, chosenTimes(source, samples), ({ matrices }, index) => {
    centreOf(scene, matrices, centre);
    if (index === 0) first.copy(centre);
    gone.subVectors(centre, first);
    if (fixed !== null) gone.projectOnPlane(fixed);
    for (let body = 1; body < local.length; body += 1) {
      for (const each of local[body]!) {
        corner.copy(each).applyMatrix4(matrices[body]!).toArray(moving, moving.length);
        corner.sub(gone).toArray(carried, carried.length);
      }
    }
    if (index === 0) atStart = moving.length;
  });
  if (!isTied(scene) && diagonal(moving) > FAR * diagonal(carried)) {
    const level = lowest([...moving, ...carried], floorNormal(scene)); // nothing that falls passes the floor
    return { points: new Float32Array(carried), box: new Box3().setFromArray(carried), roams: true, fixed, level };
  }
  const ground = local[0]!.flatMap((each) => each.toArray());
  const seen = aboveBase(scene, ground, moving, atStart);
  const extent = diagonal(seen);
  const whole = seen.length === 0 || diagonal(ground) < MOST_GROUND * extent;
  const points = [...(whole ? ground : heldPoints(scene)), ...seen];
  const box = new Box3().setFromArray(points.length === 0 ? [0, 0, 0] : points);
  if (diagonal(points) < 0.05 * scene.size) {
    box.expandByScalar(0.5 * scene.size);
    points.push(...boxCorners(box).flatMap((each) => each.toArray()));
  }
  const level = lowest(boxCorners(box).flatMap((each) => each.toArray()), floorNormal(scene));
  return { points: new Float32Array(points), box, roams: false, fixed, level };
}

/** Return upwards where the ground is seen and the mechanism does not rise or fall by far more than its own size, else null. */
function staysLevel(scene: Scene, source: StateSource, local: readonly Vector3[][]): Vector3 | null {
  if (scene.gravity === null || scene.bodies[0]!.solids.length === 0) return null;
  const up = new Vector3(...scene.up).normalize();
  const heights: number[] = [];
  const corners: number[] = [];
  const point = new Vector3();
  visitStates(scene, source, chosenTimes(source, SAMPLES), ({ matrices }, index) => {
    centreOf(scene, matrices, point);
    heights.push(point.dot(up));
    if (index > 0) return;
    local.forEach((each, body) => { if (body > 0) for (const corner of each) point.copy(corner).applyMatrix4(matrices[body]!).toArray(corners, corners.length); });
  });
  return Math.max(...heights) - Math.min(...heights) < HIGH * diagonal(corners) ? up : null;
}

/**
 * Return which points of a motion the picture is fitted to: of a mechanism that stands on a base, those above its foot, where
 * the floor is. It stands there if nothing is much lower at the start, the first `atStart` numbers; what hangs is seen whole.
 */
function aboveBase(scene: Scene, ground: number[], moving: number[], atStart: number): number[] {
  if (scene.normal !== null || scene.bodies[0]!.solids.length === 0) return moving;
  const up = new Vector3(...scene.up).normalize();
  const base = lowest(ground, up);
  const foot = Math.min(base, lowest(moving.slice(0, atStart), up));
  if (base - foot > STANDS * scene.size) return moving;
  return moving.filter((_, at) => height(moving, at - (at % 3), up) >= foot);
}

/** Return the unit vector across the floor: upwards, or towards who looks at a planar mechanism. */
export function floorNormal(scene: Scene): Vector3 {
  return new Vector3(...(scene.normal ?? scene.up)).normalize();
}

/** Return the least height of points (N, 3). */
function lowest(points: number[], up: Vector3): number {
  let least = Infinity;
  for (let at = 0; at < points.length; at += 3) least = Math.min(least, height(points, at, up));
  return least;
}

function height(points: number[], at: number, up: Vector3): number {
  return points[at]! * up.x + points[at + 1]! * up.y + points[at + 2]! * up.z;
}

/** Return the points (N, 3) of the ground that hold the mechanism: of a ground that is too large they are seen. */
function heldPoints(scene: Scene): number[] {
  const joints = scene.joints.filter(({ type }) => !LOOSE.includes(type));
  const anchors = [...joints, ...scene.connectors].flatMap(({ start, end }) => [start, end]);
  return anchors.filter(({ body }) => body === 0).flatMap(({ at }) => [...at]);
}

/** Return whether a joint, such as a guide that shows the way, holds the mechanism on the ground. */
function isTied(scene: Scene): boolean {
  return scene.joints.some(({ type, start, end }) => (start.body === 0 || end.body === 0) && !LOOSE.includes(type));
}

function diagonal(points: number[]): number {
  return points.length === 0 ? 0 : new Box3().setFromArray(points).getSize(new Vector3()).length();
}

function boxCorners(box: Box3): Vector3[] {
  const { min, max } = box;
  if (box.isEmpty()) return [];
  return Array.from({ length: 8 }, (_, i) => new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}
