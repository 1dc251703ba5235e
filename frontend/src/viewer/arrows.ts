/** Forces and torques as arrows (torques with two heads); points of contact as dots. */

import {
  BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
} from "three";
import { arrowScale, LONGEST, usualMagnitude } from "./arrow_scale";
import type { MotionVector, Scene, VectorKind } from "./contract";
import { Curls } from "./curls";
import { anchorPoint, type Instant, type Layer } from "./layer";
import { HIGHLIGHT, VECTOR_COLORS } from "./palette";
import type { GeometryStore } from "./solids";
import type { StateSource } from "./source";

export const VECTOR_GROUPS = ["force", "torque", "contact", "reaction"] as const;
export type VectorGroup = (typeof VECTOR_GROUPS)[number];

/** Return the group of a vector: what joints and contacts do to bodies is shown apart from applied forces. */
export function vectorGroup(vector: MotionVector): VectorGroup {
  if (/^contact\b/i.test(vector.name)) return "contact";
  return /^(reaction|constraint)\b/i.test(vector.name) ? "reaction" : vector.kind;
}

const zAxis = new Vector3(0, 0, 1);
const hidden = new Matrix4().makeScale(0, 0, 0);

/** Shafts, heads and points of many arrows in three draws, over all bodies: forces act inside of them. */
class ArrowMeshes {
  readonly object = new Group();
  readonly shafts: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  readonly heads: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  private readonly points: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  private readonly direction = new Vector3();
  private readonly turn = new Quaternion();
  private readonly place = new Vector3();
  private readonly scale = new Vector3();
  private readonly matrix = new Matrix4();

  constructor(
    count: number,
    private readonly width: number,
    store: GeometryStore,
  ) {
    const material = new MeshStandardMaterial({ roughness: 0.6, emissiveIntensity: 0.25, depthTest: false, transparent: true });
    this.shafts = new InstancedMesh(store.made("shaft", () => new CylinderGeometry(1, 1, 1, 16).rotateX(Math.PI / 2)), material, count);
    this.heads = new InstancedMesh(store.made("head", () => new ConeGeometry(1, 1, 24).rotateX(Math.PI / 2)), material, 2 * count);
    this.points = new InstancedMesh(store.made("point", () => new SphereGeometry(1, 16, 12)), material, count);
    for (const mesh of this.meshes) {
      mesh.frustumCulled = false;
      mesh.renderOrder = 2;
      this.object.add(mesh);
    }
  }

  hide(index: number): void {
    this.shafts.setMatrixAt(index, hidden);
    this.points.setMatrixAt(index, hidden);
    this.heads.setMatrixAt(2 * index, hidden);
    this.heads.setMatrixAt(2 * index + 1, hidden);
  }

  /** Draw an arrow from a point along a vector [m]. */
  set(index: number, start: Vector3, along: Vector3, double: boolean): void {
    const length = along.length();
    const head = Math.min(5 * this.width, 0.6 * length);
    if (head < 0.3 * this.width) {
      this.hide(index);
      return;
    }
    this.direction.copy(along).divideScalar(length);
    this.turn.setFromUnitVectors(zAxis, this.direction);
    const shaft = length - head;
    const radius = this.width * Math.min(1, head / (4 * this.width));
    this.write(this.shafts, index, start, shaft / 2, radius, shaft);
    this.write(this.heads, 2 * index, start, length - head / 2, 2.3 * radius, head);
    if (double) this.write(this.heads, 2 * index + 1, start, length - 1.25 * head, 2.3 * radius, head);
    else this.heads.setMatrixAt(2 * index + 1, hidden);
  }

  /** Draw a dot where a vector acts. */
  setPoint(index: number, at: Vector3): void {
    this.points.setMatrixAt(index, this.matrix.compose(at, this.turn.identity(), this.scale.setScalar(1.9 * this.width)));
  }

  setColor(index: number, color: Color): void {
    this.shafts.setColorAt(index, color);
    this.points.setColorAt(index, color);
    this.heads.setColorAt(2 * index, color);
    this.heads.setColorAt(2 * index + 1, color);
  }

  flush(): void {
    for (const mesh of this.meshes) {
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
      if (mesh.instanceColor !== null) mesh.instanceColor.needsUpdate = true;
    }
  }

  dispose(): void {
    this.shafts.material.dispose();
    for (const mesh of this.meshes) mesh.dispose();
  }

  private get meshes(): readonly InstancedMesh<BufferGeometry, MeshStandardMaterial>[] {
    return [this.shafts, this.heads, this.points];
  }

  private write(mesh: InstancedMesh, index: number, start: Vector3, at: number, radius: number, length: number): void {
    this.place.copy(start).addScaledVector(this.direction, at);
    mesh.setMatrixAt(index, this.matrix.compose(this.place, this.turn, this.scale.set(radius, radius, length)));
  }
}

export class VectorArrows implements Layer {
  readonly object = new Group();
  /** Which groups are drawn. */
  readonly shown: Record<VectorGroup, boolean> = { force: true, torque: true, contact: true, reaction: true };
  /** A factor of all lengths, chosen by the user. */
  factor = 1;
  /** Where the last drawn arrows end. */
  private readonly tips: Vector3[];
  /** Whether contacts touch; other vectors act always, be they zero. */
  private readonly acts: boolean[];
  /** Whether torques curl: in the plane of a planar mechanism. */
  readonly curled: boolean;
  private readonly arrows: ArrowMeshes;
  private readonly curls: Curls;
  private readonly scales: Record<VectorKind, number>;
  private readonly longest: number;
  private readonly components = new Float64Array(3);
  private readonly place = new Float64Array(3);
  private readonly start = new Vector3();
  private readonly along = new Vector3();

  constructor(
    scene: Scene,
    private readonly source: StateSource,
    store: GeometryStore,
    size: number,
  ) {
    const { vectors } = source;
    this.arrows = new ArrowMeshes(vectors.length, 0.006 * size, store);
    this.scales = {
      force: arrowScale(usualMagnitude(vectors, "force", source.times), size),
      torque: arrowScale(usualMagnitude(vectors, "torque", source.times), size),
    };
    this.longest = LONGEST * size;
    this.tips = vectors.map(() => new Vector3());
    this.acts = vectors.map(() => true);
    this.curled = scene.normal !== null;
    this.curls = new Curls(vectors.length, 0.45 * size, store);
    this.object.add(this.arrows.object, this.curls.mesh);
    this.paint("", "");
  }

  /** Return where an arrow ends, or null where none is drawn, as of a contact that does not touch. */
  tip(index: number): Vector3 | null {
    return this.isShown(index) && this.acts[index] === true ? this.tips[index]! : null;
  }

  isShown(index: number): boolean {
    return this.shown[vectorGroup(this.source.vectors[index]!)];
  }

  /** Return the metres that one newton, or newton metre, is drawn with; 0 if there is nothing to draw. */
  metresPer(kind: VectorKind): number {
    const used = this.source.vectors.some((each, index) => each.kind === kind && this.isShown(index));
    return used ? this.scales[kind] * this.factor : 0;
  }

  update(instant: Instant): void {
    const { vectors } = this.source;
    for (let index = 0; index < vectors.length; index += 1) {
      const vector = vectors[index]!;
      this.arrows.hide(index);
      this.curls.hide(index);
      if (!this.isShown(index)) continue;
      this.source.vectorAt(index, instant.time, this.components);
      if (vector.places === null) anchorPoint(vector.anchor, instant, this.start);
      else {
        this.source.placeAt(index, instant.time, this.place);
        this.start.fromArray(this.place);
      }
      this.along.fromArray(this.components).multiplyScalar(this.scales[vector.kind] * this.factor);
      this.along.clampLength(0, this.longest * Math.max(1, this.factor));
      this.acts[index] = vector.places === null || this.along.lengthSq() > 0;
      const tip = this.tips[index]!.addVectors(this.start, this.along);
      if (this.curled && vector.kind === "torque") this.curls.set(index, this.start, this.along, tip);
      else this.arrows.set(index, this.start, this.along, vector.kind === "torque");
      if (vector.places !== null && this.acts[index] === true) this.arrows.setPoint(index, this.start);
    }
    this.flush();
  }

  paint(selected: string, hovered: string): void {
    const color = new Color();
    this.source.vectors.forEach((vector, index) => {
      const marked = vector.name === selected || vector.name === hovered;
      color.set(marked ? HIGHLIGHT : VECTOR_COLORS[vectorGroup(vector)]);
      this.arrows.setColor(index, color);
      this.curls.setColor(index, color);
    });
    this.flush();
  }

  vectorOf(mesh: unknown, instance: number): MotionVector | undefined {
    if (mesh === this.arrows.shafts || mesh === this.curls.mesh) return this.source.vectors[instance];
    return mesh === this.arrows.heads ? this.source.vectors[instance >> 1] : undefined;
  }

  dispose(): void {
    this.arrows.dispose();
    this.curls.dispose();
  }

  private flush(): void {
    this.arrows.flush();
    this.curls.flush();
  }
}
