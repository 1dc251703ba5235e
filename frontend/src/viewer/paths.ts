/** Where points of bodies are along the motion: paths of traces, extents of the whole. */

import { Box3, Matrix4, Vector3 } from "three";
import type { Anchor, Scene } from "./contract";
import { placeMatrix, writeMatrices, type Instant } from "./layer";
import { makeGeometry, shapeOf } from "./shapes";
import { restPose, type StateSource } from "./source";

const SAMPLES = 80;

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
  for (const solid of solids) {
    const { key, scale } = shapeOf(solid);
    const geometry = makeGeometry(key.startsWith("mesh") ? "box" : key, scene.meshes);
    if (key.startsWith("mesh")) meshBox(scene, solid.mesh ?? 0, geometry.boundingBox ??= new Box3());
    else geometry.computeBoundingBox();
    if (geometry.boundingBox !== null && !geometry.boundingBox.isEmpty()) {
      box.union(geometry.boundingBox.applyMatrix4(placeMatrix(solid.at, solid.quaternion, scale)));
    }
    geometry.dispose();
  }
  if (body > 0 || box.isEmpty()) for (const frame of frames) box.expandByPoint(new Vector3(...frame.at));
  for (const { start, end } of scene.connectors) {
    for (const anchor of [start, end]) if (anchor.body === body) box.expandByPoint(new Vector3(...anchor.at));
  }
  return box;
}

function meshBox(scene: Scene, mesh: number, into: Box3): void {
  into.setFromArray(scene.meshes[mesh]!.vertices);
}

/** Return the box of everything along the whole motion, without a ground that is far larger than the rest. */
export function motionBox(scene: Scene, source: StateSource): Box3 {
  const local = scene.bodies.map((_, body) => bodyBox(scene, body));
  const moving = new Box3();
  const corner = new Box3();
  visitStates(scene, source, chosenTimes(source, SAMPLES), ({ matrices }) => {
    for (let body = 1; body < local.length; body += 1) {
      if (!local[body]!.isEmpty()) moving.union(corner.copy(local[body]!).applyMatrix4(matrices[body]!));
    }
  });
  const ground = local[0]!;
  if (moving.isEmpty()) moving.copy(ground);
  const extent = moving.getSize(new Vector3()).length();
  if (!ground.isEmpty() && ground.getSize(new Vector3()).length() < 3 * extent) moving.union(ground);
  if (moving.isEmpty()) moving.expandByPoint(new Vector3());
  const least = moving.getSize(new Vector3()).length();
  if (least < 0.05 * scene.size) moving.expandByScalar(0.5 * scene.size);
  return moving;
}
