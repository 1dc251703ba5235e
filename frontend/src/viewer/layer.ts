/** What the parts of a picture have in common. */

import { Matrix4, Quaternion, Vector3, type Object3D } from "three";
import type { Anchor, Point, Quaternion as Quadruple } from "./contract";
import type { Theme } from "./palette";
import type { Pose } from "./source";

/** What a picture is drawn from: a time and the matrix of each body, the ground first. */
export interface Instant {
  readonly time: number;
  readonly matrices: readonly Matrix4[];
}

/** A part of the picture that follows the time. */
export interface Layer {
  readonly object: Object3D;
  update(instant: Instant): void;
  setTheme?(theme: Theme): void;
  dispose(): void;
}

/** What can be picked and selected. */
export interface SceneElement {
  readonly kind: "body" | "joint" | "connector" | "vector" | "part";
  readonly name: string;
  /** Such as "revolute" or "spring". */
  readonly type: string;
  /** The place of the body that it is on. */
  readonly body: number;
}

/** Counts for tests and benchmarks. */
export interface Counts {
  /** Geometries that were made anew after the first picture. */
  rebuilt: number;
  /** Pictures drawn. */
  frames: number;
}

const position = new Vector3();
const rotation = new Quaternion();
const one = new Vector3(1, 1, 1);

/** Write the matrices of all bodies of a pose. */
export function writeMatrices(pose: Pose, matrices: readonly Matrix4[]): void {
  const { positions, quaternions } = pose;
  for (let body = 0; body < matrices.length; body += 1) {
    const q = 4 * body;
    position.fromArray(positions, 3 * body);
    rotation.set(quaternions[q + 1]!, quaternions[q + 2]!, quaternions[q + 3]!, quaternions[q]!);
    matrices[body]!.compose(position, rotation, one);
  }
}

/** Return a matrix of a place and a quaternion with its scalar first. */
export function placeMatrix(at: Point, quaternion: Quadruple, scale: Vector3 = one): Matrix4 {
  const [w, x, y, z] = quaternion;
  return new Matrix4().compose(new Vector3(...at), new Quaternion(x, y, z, w).normalize(), scale);
}

/** Write where an anchor is in ground's axes. */
export function anchorPoint(anchor: Anchor, instant: Instant, into: Vector3): Vector3 {
  return into.fromArray(anchor.at).applyMatrix4(instant.matrices[anchor.body]!);
}

const zAxis = new Vector3(0, 0, 1);
const along = new Vector3();
const scale = new Vector3();

/** Write the matrix that puts a shape of unit length along z, centred, between two points. */
export function spanMatrix(start: Vector3, end: Vector3, radius: number, into: Matrix4): Matrix4 {
  along.subVectors(end, start);
  const length = along.length();
  if (length < 1e-12) return into.makeScale(0, 0, 0).setPosition(start);
  rotation.setFromUnitVectors(zAxis, along.divideScalar(length));
  position.addVectors(start, end).multiplyScalar(0.5);
  return into.compose(position, rotation, scale.set(radius, radius, length));
}
