/** A tube around a path, written in place: the number of points never changes. */

import { BufferAttribute, BufferGeometry } from "three";

export interface Tube {
  readonly geometry: BufferGeometry;
  /** Points (P, 3) of the path; change them, then call `update`. */
  readonly path: Float64Array;
  update(): void;
}

/** Return a tube of so many points, sides and a radius [m]. */
export function createTube(points: number, sides: number, radius: number): Tube {
  const path = new Float64Array(3 * points);
  const positions = new BufferAttribute(new Float32Array(3 * points * sides), 3);
  const normals = new BufferAttribute(new Float32Array(3 * points * sides), 3);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", positions);
  geometry.setAttribute("normal", normals);
  geometry.setIndex(tubeIndex(points, sides));
  return {
    geometry,
    path,
    update(): void {
      writeTube(path, sides, radius, positions.array as Float32Array, normals.array as Float32Array);
      positions.needsUpdate = true;
      normals.needsUpdate = true;
      geometry.boundingSphere = null; // computed anew by the next pick
      geometry.boundingBox = null;
    },
  };
}

function tubeIndex(points: number, sides: number): number[] {
  const index: number[] = [];
  for (let ring = 0; ring + 1 < points; ring += 1) {
    for (let side = 0; side < sides; side += 1) {
      const a = ring * sides + side;
      const b = ring * sides + ((side + 1) % sides);
      index.push(a, b, a + sides, b, b + sides, a + sides);
    }
  }
  return index;
}

/** Write rings around a path; each ring's axes are the last ones, turned as little as possible. */
export function writeTube(
  path: Float64Array,
  sides: number,
  radius: number,
  positions: Float32Array,
  normals: Float32Array,
): void {
  const points = path.length / 3;
  const tangent: [number, number, number] = [0, 0, 1];
  const across: [number, number, number] = [0, 0, 0];
  for (let ring = 0; ring < points; ring += 1) {
    direction(path, ring, points, tangent);
    turnAcross(tangent, across);
    const upX = tangent[1] * across[2] - tangent[2] * across[1];
    const upY = tangent[2] * across[0] - tangent[0] * across[2];
    const upZ = tangent[0] * across[1] - tangent[1] * across[0];
    for (let side = 0; side < sides; side += 1) {
      const c = Math.cos((2 * Math.PI * side) / sides);
      const s = Math.sin((2 * Math.PI * side) / sides);
      const at = 3 * (ring * sides + side);
      normals[at] = c * across[0] + s * upX;
      normals[at + 1] = c * across[1] + s * upY;
      normals[at + 2] = c * across[2] + s * upZ;
      for (let axis = 0; axis < 3; axis += 1) {
        positions[at + axis] = path[3 * ring + axis]! + radius * normals[at + axis]!;
      }
    }
  }
}

function direction(path: Float64Array, ring: number, points: number, tangent: [number, number, number]): void {
  const from = 3 * Math.max(ring - 1, 0);
  const to = 3 * Math.min(ring + 1, points - 1);
  const x = path[to]! - path[from]!;
  const y = path[to + 1]! - path[from + 1]!;
  const z = path[to + 2]! - path[from + 2]!;
  const length = Math.hypot(x, y, z);
  if (length < 1e-12) return; // points that coincide keep the last direction
  tangent[0] = x / length;
  tangent[1] = y / length;
  tangent[2] = z / length;
}

/** Make `across` a unit vector perpendicular to `tangent`, as near to its last value as it goes. */
export function turnAcross(tangent: readonly [number, number, number], across: [number, number, number]): void {
  if (!project(tangent, across)) {
    const slight = Math.abs(tangent[0]) < 0.9;
    across[0] = slight ? 1 : 0;
    across[1] = slight ? 0 : 1;
    across[2] = 0;
    project(tangent, across);
  }
}

function project(tangent: readonly [number, number, number], across: [number, number, number]): boolean {
  const along = tangent[0] * across[0] + tangent[1] * across[1] + tangent[2] * across[2];
  const x = across[0] - along * tangent[0];
  const y = across[1] - along * tangent[1];
  const z = across[2] - along * tangent[2];
  const length = Math.hypot(x, y, z);
  if (length < 1e-6) return false;
  across[0] = x / length;
  across[1] = y / length;
  across[2] = z / length;
  return true;
}
