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
export function shapeOf({ kind, size, mesh }: Solid): Shape {
  const [a, b, c] = [size[0] ?? 1, size[1] ?? 1, size[2] ?? 1];
  switch (kind) {
    case "box":
      return { key: kind, scale: new Vector3(a, b, c), doubleSided: false };
    case "cylinder":
    case "cone":
      return { key: kind, scale: new Vector3(a, a, b), doubleSided: false };
    case "sphere":
      return { key: kind, scale: new Vector3(a, a, a), doubleSided: false };
    case "capsule":
      return { key: `capsule ${(b / Math.max(a, 1e-9)).toPrecision(3)}`, scale: new Vector3(a, a, a), doubleSided: false };
    default:
      return { key: `mesh ${mesh ?? 0}`, scale: new Vector3(a, b, c), doubleSided: true };
  }
}

type Maker = (around: number, parameter: number) => BufferGeometry;

const MAKERS: Readonly<Record<string, Maker>> = {
  box: () => new BoxGeometry(1, 1, 1),
  cylinder: (around) => new CylinderGeometry(1, 1, 1, around).rotateX(Math.PI / 2),
  cone: (around) => new ConeGeometry(1, 1, around).rotateX(Math.PI / 2),
  sphere: (around) => new SphereGeometry(1, around, Math.round(0.6 * around)).rotateX(Math.PI / 2),
  capsule: (around, length) => new CapsuleGeometry(1, length, Math.round(around / 4), around).rotateX(Math.PI / 2),
};

/** Return the geometry of a key; cylinders, cones and capsules stand along z; `coarse` where there are many. */
export function makeGeometry(key: string, meshes: readonly SceneMesh[], coarse = false): BufferGeometry {
  const [kind = "", parameter = "0"] = key.split(" ");
  const make = MAKERS[kind];
  return make === undefined ? meshGeometry(meshes[Number(parameter)]!) : make(coarse ? 16 : 36, Number(parameter));
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
