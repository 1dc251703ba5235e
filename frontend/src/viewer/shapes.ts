/** Geometries of solids: unit shapes that all solids of a kind share. */

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  ConeGeometry,
  CylinderGeometry,
  SphereGeometry,
  Vector3,
} from "three";
import { toCreasedNormals } from "three/addons/utils/BufferGeometryUtils.js";
import type { SceneMesh, Solid } from "./contract";

const CREASE = Math.PI / 5;
const MOST_CREASED = 60_000; // triangles; beyond, normals are averaged, which is faster

/** A geometry by its key, and the factors that give it the size of the solid. */
export interface Shape {
  readonly key: string;
  readonly scale: Vector3;
  readonly doubleSided: boolean;
}

/** Return which geometry a solid shares, and its factors. */
export function shapeOf(solid: Solid): Shape {
  const [a = 1, b = 1, c = 1] = solid.size;
  switch (solid.kind) {
    case "box":
      return { key: "box", scale: new Vector3(a, b, c), doubleSided: false };
    case "cylinder":
    case "cone":
      return { key: solid.kind, scale: new Vector3(a, a, b), doubleSided: false };
    case "sphere":
      return { key: "sphere", scale: new Vector3(a, a, a), doubleSided: false };
    case "capsule":
      return { key: `capsule ${(b / a).toPrecision(3)}`, scale: new Vector3(a, a, a), doubleSided: false };
    case "mesh":
    case "line":
      return { key: `mesh ${solid.mesh ?? 0}`, scale: new Vector3(a, b, c), doubleSided: true };
  }
}

/** Return the geometry of a key; cylinders, cones and capsules stand along z; `coarse` where there are many. */
export function makeGeometry(key: string, meshes: readonly SceneMesh[], coarse = false): BufferGeometry {
  const around = coarse ? 16 : 36;
  const [kind, parameter = "0"] = key.split(" ");
  switch (kind) {
    case "box":
      return new BoxGeometry(1, 1, 1);
    case "cylinder":
      return new CylinderGeometry(1, 1, 1, around).rotateX(Math.PI / 2);
    case "cone":
      return new ConeGeometry(1, 1, around).rotateX(Math.PI / 2);
    case "sphere":
      return new SphereGeometry(1, around, coarse ? 10 : 22).rotateX(Math.PI / 2);
    case "capsule":
      return new CapsuleGeometry(1, Number(parameter), coarse ? 4 : 8, around).rotateX(Math.PI / 2);
    default:
      return meshGeometry(meshes[Number(parameter)]!);
  }
}

function meshGeometry(mesh: SceneMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(mesh.vertices, 3));
  geometry.setIndex(new BufferAttribute(mesh.triangles, 1));
  if (mesh.triangles.length / 3 > MOST_CREASED) {
    geometry.computeVertexNormals();
    return geometry;
  }
  return toCreasedNormals(geometry, CREASE);
}
