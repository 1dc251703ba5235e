/** Torques of planar mechanisms: arrows that curl about the normal, seen where a straight one would be a dot. */

import {
  BufferGeometry,
  Color,
  ConeGeometry,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Quaternion,
  TorusGeometry,
  Vector3,
} from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { GeometryStore } from "./solids";

const LEAST = 0.02; // of the longest arrow: below, nothing is drawn
const zAxis = new Vector3(0, 0, 1);
const hidden = new Matrix4().makeScale(0, 0, 0);

/** Three quarters of a ring of unit radius, counter-clockwise about z, with a head. */
function curlGeometry(): BufferGeometry {
  const ring = new TorusGeometry(1, 0.07, 10, 48, 1.5 * Math.PI);
  const head = new ConeGeometry(0.24, 0.56, 20).rotateZ(-Math.PI / 2).translate(0.22, -1, 0);
  return mergeGeometries([ring, head]);
}

export class Curls {
  readonly mesh: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  private readonly direction = new Vector3();
  private readonly turn = new Quaternion();
  private readonly scale = new Vector3();
  private readonly matrix = new Matrix4();

  constructor(
    count: number,
    private readonly size: number,
    store: GeometryStore,
  ) {
    this.mesh = new InstancedMesh(store.made("curl", curlGeometry), new MeshStandardMaterial({ roughness: 0.6 }), count);
    this.mesh.frustumCulled = false;
    for (let index = 0; index < count; index += 1) this.hide(index);
  }

  hide(index: number): void {
    this.mesh.setMatrixAt(index, hidden);
  }

  /** Draw a ring about a point, its diameter the length of a vector [m]; write where its name stands. */
  set(index: number, center: Vector3, along: Vector3, tip: Vector3): void {
    const length = along.length();
    tip.copy(center);
    if (length < LEAST * this.size) {
      this.hide(index);
      return;
    }
    this.turn.setFromUnitVectors(zAxis, this.direction.copy(along).divideScalar(length));
    this.mesh.setMatrixAt(index, this.matrix.compose(center, this.turn, this.scale.setScalar(length / 2)));
    tip.add(this.scale.set(length / 2, 0, 0).applyQuaternion(this.turn));
  }

  setColor(index: number, color: Color): void {
    this.mesh.setColorAt(index, color);
  }

  flush(): void {
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.boundingSphere = null;
    if (this.mesh.instanceColor !== null) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}
