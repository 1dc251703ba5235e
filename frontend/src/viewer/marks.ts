/** Marks on bodies: axes of frames and points of joints. */

import {
  BufferAttribute,
  BufferGeometry,
  ConeGeometry,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  OctahedronGeometry,
  Vector3,
} from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { Scene, SceneJoint } from "./contract";
import { anchorPoint, placeMatrix, type Instant, type Layer } from "./layer";
import { HIGHLIGHT, type Theme } from "./palette";
import type { GeometryStore } from "./solids";

const AXIS_COLORS = ["#d62f2f", "#2a9d3f", "#2f6fe0"] as const;
const matrix = new Matrix4();
const place = new Vector3();

/** Three arrows along x, y, z of unit length, coloured. */
function axesGeometry(): BufferGeometry {
  const turns = [new Matrix4().makeRotationZ(-Math.PI / 2), new Matrix4(), new Matrix4().makeRotationX(Math.PI / 2)];
  const arrows = turns.flatMap((turn, axis) => {
    const shaft = new CylinderGeometry(0.022, 0.022, 0.82, 10).translate(0, 0.41, 0);
    const tip = new ConeGeometry(0.065, 0.2, 14).translate(0, 0.9, 0);
    return [shaft, tip].map((part) => colored(part.applyMatrix4(turn), AXIS_COLORS[axis]!));
  });
  return mergeGeometries(arrows);
}

function colored(geometry: BufferGeometry, color: string): BufferGeometry {
  const material = new MeshBasicMaterial({ color });
  const { r, g, b } = material.color;
  material.dispose();
  const count = geometry.getAttribute("position").count;
  const colors = new Float32Array(3 * count);
  for (let index = 0; index < count; index += 1) colors.set([r, g, b], 3 * index);
  geometry.setAttribute("color", new BufferAttribute(colors, 3));
  return geometry;
}

/** The axes of every frame of every body. */
export class FrameAxes implements Layer {
  readonly object: InstancedMesh<BufferGeometry, MeshBasicMaterial>;
  private readonly entries: { body: number; local: Matrix4 }[] = [];

  constructor(scene: Scene, store: GeometryStore) {
    const length = new Vector3().setScalar(0.09 * scene.size);
    scene.bodies.forEach((body, index) => {
      for (const frame of body.frames) {
        this.entries.push({ body: index, local: placeMatrix(frame.at, frame.quaternion, length) });
      }
    });
    const material = new MeshBasicMaterial({ vertexColors: true });
    this.object = new InstancedMesh(store.made("axes", axesGeometry), material, this.entries.length);
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  update(instant: Instant): void {
    if (!this.object.visible) return;
    this.entries.forEach(({ body, local }, index) => {
      this.object.setMatrixAt(index, matrix.multiplyMatrices(instant.matrices[body]!, local));
    });
    this.object.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.object.material.dispose();
    this.object.dispose();
  }
}

/** A small mark at each joint, drawn over the bodies. */
export class JointMarks implements Layer {
  readonly object = new Group();
  readonly mesh: InstancedMesh<BufferGeometry, MeshBasicMaterial>;
  private color = "#000000";

  constructor(
    private readonly scene: Scene,
    store: GeometryStore,
  ) {
    const geometry = store.made("joint", () => new OctahedronGeometry(1, 1));
    const material = new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.92 });
    this.mesh = new InstancedMesh(geometry, material, scene.joints.length);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 5;
    this.object.add(this.mesh);
    this.object.visible = false;
  }

  update(instant: Instant): void {
    const radius = 0.014 * this.scene.size;
    this.scene.joints.forEach((joint, index) => {
      anchorPoint(joint.start, instant, place);
      this.mesh.setMatrixAt(index, matrix.makeScale(radius, radius, radius).setPosition(place));
    });
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.boundingSphere = null;
  }

  paint(selected: string, hovered: string): void {
    const { color } = this.mesh.material;
    this.scene.joints.forEach((joint, index) => {
      const marked = joint.name === selected || joint.name === hovered;
      this.mesh.setColorAt(index, color.set(marked ? HIGHLIGHT : this.color));
    });
    color.set("#ffffff"); // the instances carry the colours
    if (this.mesh.instanceColor !== null) this.mesh.instanceColor.needsUpdate = true;
  }

  setTheme(theme: Theme): void {
    this.color = theme.joint;
    this.paint("", "");
  }

  jointOf(mesh: unknown, instance: number): SceneJoint | undefined {
    return mesh === this.mesh ? this.scene.joints[instance] : undefined;
  }

  dispose(): void {
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}
