/** Where points of bodies are along the motion: paths of traces, extents of the whole. */

import { Box3, Matrix4, Vector3 } from "three";
import type { Anchor, Scene, Solid } from "./contract";
import { placeMatrix, writeMatrices, type Instant } from "./layer";
import { makeGeometry, shapeOf } from "./shapes";
import { restPose, type StateSource } from "./source";

const SAMPLES = 80;
const MOST_GROUND = 1.8; // a ground that is larger, in parts of what moves, may stick out
const MOST_POINTS = 24_000; // that a view is fitted to

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
function bodyBox(scene: Scene, body: number): Box3 {
  const box = new Box3();
  const { solids, frames } = scene.bodies[body]!;
  for (const solid of solids) box.union(solidBox(scene, solid));
  // a ground's frames may be far from all that is drawn
  if (body > 0 || box.isEmpty()) for (const frame of frames) box.expandByPoint(new Vector3(...frame.at));
  const anchors = scene.connectors.flatMap((each) => [each.start, each.end]);
  for (const anchor of anchors) if (anchor.body === body) box.expandByPoint(new Vector3(...anchor.at));
  return box;
}

function solidBox(scene: Scene, solid: Solid): Box3 {
  const { key, scale } = shapeOf(solid);
  const box = new Box3();
  if (solid.mesh !== null) {
    box.setFromArray(scene.meshes[solid.mesh]!.vertices);
  } else {
    const geometry = makeGeometry(key, scene.meshes, true);
    geometry.computeBoundingBox();
    box.union(geometry.boundingBox ?? box);
    geometry.dispose();
  }
  return box.isEmpty() ? box : box.applyMatrix4(placeMatrix(solid.at, solid.quaternion, scale));
}

/** What a camera has to hold: points on everything along the motion, and their box. */
export interface Extent {
  readonly points: Float32Array;
  readonly box: Box3;
}

/** Return the extent of the whole motion, without a ground that is far larger than the rest. */
export function motionExtent(scene: Scene, source: StateSource): Extent {
  const local = scene.bodies.map((_, body) => boxCorners(bodyBox(scene, body)));
  const samples = Math.min(Math.max(Math.floor(MOST_POINTS / (8 * local.length)), 6), SAMPLES);
  const moving: number[] = [];
  const corner = new Vector3();
  visitStates(scene, source, chosenTimes(source, samples), ({ matrices }) => {
    for (let body = 1; body < local.length; body += 1) {
      for (const each of local[body]!) corner.copy(each).applyMatrix4(matrices[body]!).toArray(moving, moving.length);
    }
  });
  const ground = local[0]!.flatMap((each) => each.toArray());
  const extent = diagonal(moving);
  const points = moving.length === 0 || diagonal(ground) < MOST_GROUND * extent ? [...ground, ...moving] : moving;
  const box = new Box3().setFromArray(points.length === 0 ? [0, 0, 0] : points);
  if (diagonal(points) < 0.05 * scene.size) {
    box.expandByScalar(0.5 * scene.size);
    points.push(...boxCorners(box).flatMap((each) => each.toArray()));
  }
  return { points: new Float32Array(points), box };
}

function diagonal(points: number[]): number {
  return points.length === 0 ? 0 : new Box3().setFromArray(points).getSize(new Vector3()).length();
}

function boxCorners(box: Box3): Vector3[] {
  const { min, max } = box;
  if (box.isEmpty()) return [];
  return Array.from({ length: 8 }, (_, i) => new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}

/** Return an extent that holds more points. */
export function withPoints(extent: Extent, more: readonly Vector3[]): Extent {
  const points = new Float32Array([...extent.points, ...more.flatMap((each) => each.toArray())]);
  return { points, box: new Box3().setFromArray(points) };
}

/** Return where the arrow of gravity starts and ends: beside the upper left of a box, where it hides nothing. */
export function gravityEnds(scene: Scene, box: Box3): [Vector3, Vector3] | null {
  if (scene.gravity === null) return null;
  const size = box.getSize(new Vector3());
  const length = 0.13 * size.length();
  const up = new Vector3(...scene.up).normalize();
  const left = new Vector3(-1, 0, 0);
  if (scene.normal !== null) left.set(...scene.normal).cross(up).normalize();
  if (Math.abs(left.dot(up)) > 0.9 || left.lengthSq() < 0.5) left.set(0, -1, 0);
  const reach = (along: Vector3): number =>
    (Math.abs(along.x) * size.x + Math.abs(along.y) * size.y + Math.abs(along.z) * size.z) / 2;
  const start = box.getCenter(new Vector3()).addScaledVector(left, reach(left) + 0.3 * length).addScaledVector(up, reach(up));
  const end = start.clone().addScaledVector(new Vector3(...scene.gravity).normalize(), length);
  return [start, end];
}
