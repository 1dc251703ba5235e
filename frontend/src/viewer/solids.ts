/** The solids of all bodies: one instanced mesh for each geometry, so that hundreds cost a few draws. */

import { Color, DoubleSide, FrontSide, Group, InstancedMesh, Matrix4, MeshStandardMaterial } from "three";
import type { BufferGeometry } from "three";
import type { Scene, Solid } from "./contract";
import { createEdges, edgeMaterial, edgesOf } from "./edges";
import type { Instant, Layer } from "./layer";
import { placeMatrix } from "./layer";
import { bodyColor, HIGHLIGHT, LIGHT, NO_LIGHTS } from "./palette";
import { makeGeometry, shapeOf } from "./shapes";

export type Look = "solid" | "transparent" | "wire";

interface Entry {
  readonly body: number;
  readonly element: string;
  readonly local: Matrix4;
  readonly color: Color;
}

interface Batch {
  readonly mesh: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  readonly entries: Entry[];
}

const MANY = 150; // solids; beyond, round ones have fewer sides
const matrix = new Matrix4();
const mixed = new Color();
const glare = new Color(LIGHT);

/** Geometries by their key, shared by the bodies and their ghosts, and by the next scene of the same mechanism. */
export class GeometryStore {
  private readonly coarse: boolean;
  private readonly used = new Set<string>();
  private readonly geometries: Map<string, BufferGeometry>;

  /** Takes over from `former` what does not belong to its scene. */
  constructor(
    private readonly scene: Scene,
    former: GeometryStore | null = null,
  ) {
    this.coarse = scene.bodies.reduce((sum, body) => sum + body.solids.length, 0) > MANY;
    this.geometries = former === null || former.coarse !== this.coarse ? new Map<string, BufferGeometry>() : former.handOver();
  }

  get(key: string): BufferGeometry {
    return this.made(key, () => makeGeometry(key, this.scene.meshes, this.coarse));
  }

  /** Return the geometry of a key, made if there is none. */
  made(key: string, make: () => BufferGeometry): BufferGeometry {
    this.used.add(key);
    const geometry = this.geometries.get(key) ?? make();
    this.geometries.set(key, geometry);
    return geometry;
  }

  /** Free what nothing of the scene uses. */
  tidy(): void {
    for (const [key, geometry] of this.geometries) {
      if (this.used.has(key)) continue;
      geometry.dispose();
      this.geometries.delete(key);
    }
  }

  dispose(): void {
    for (const geometry of this.geometries.values()) geometry.dispose();
    this.geometries.clear();
  }

  /** Give all but the meshes of the scene to the next one; what is given is not freed here. */
  private handOver(): Map<string, BufferGeometry> {
    const given = [...this.geometries].filter(([key]) => !/^(edges )?mesh/.test(key));
    for (const [key] of given) this.geometries.delete(key);
    return new Map(given);
  }
}

export class Solids implements Layer {
  readonly object = new Group();
  private readonly batches: Batch[] = [];
  private readonly materials = new Map<string, MeshStandardMaterial>();
  private readonly edges = new Group();
  private readonly edgeMaterial = edgeMaterial();

  /** `copies` of the solids of all bodies from `firstBody` on, their opacities times `fade`. */
  constructor(
    scene: Scene,
    private readonly store: GeometryStore,
    private readonly copies = 1,
    private readonly fade = 1,
    firstBody = 0,
  ) {
    const groups = new Map<string, { solid: Solid; entries: Entry[] }>();
    scene.bodies.forEach((body, index) => {
      if (index < firstBody) return;
      for (const solid of body.solids) {
        if (solid.kind === "line") continue;
        const { key, scale } = shapeOf(solid);
        const group = `${key}|${solid.opacity}`;
        const batch = groups.get(group) ?? { solid, entries: [] };
        groups.set(group, batch);
        batch.entries.push({
          body: index,
          element: solid.element,
          local: placeMatrix(solid.at, solid.quaternion, scale),
          color: new Color(solid.color === "" ? bodyColor(index) : solid.color),
        });
      }
    });
    for (const { solid, entries } of groups.values()) this.batches.push(this.createBatch(solid, entries));
    this.object.add(this.edges);
    this.paint("", "");
  }

  get count(): number {
    return this.batches.reduce((sum, batch) => sum + batch.mesh.count, 0);
  }

  update(instant: Instant): void {
    this.writeCopy(0, instant.matrices);
  }

  /** Put one copy where the bodies are. */
  writeCopy(copy: number, matrices: readonly Matrix4[]): void {
    for (const { mesh, entries } of this.batches) {
      const first = copy * entries.length;
      for (let index = 0; index < entries.length; index += 1) {
        const entry = entries[index]!;
        mesh.setMatrixAt(first + index, matrix.multiplyMatrices(matrices[entry.body]!, entry.local));
      }
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null; // the next pick computes it
    }
  }

  /** Draw the selected element in the colour of selections, lights in theirs, what is under the pointer lighter. */
  paint(selected: string, hovered: string, lights = NO_LIGHTS): void {
    for (const { mesh, entries } of this.batches) {
      for (let index = 0; index < mesh.count; index += 1) {
        const { element, color } = entries[index % entries.length]!;
        mixed.copy(color).lerp(glare, lights.get(element) ?? 0);
        if (selected !== "" && element === selected) mixed.set(HIGHLIGHT);
        else if (hovered !== "" && element === hovered) mixed.offsetHSL(0, 0, 0.12);
        mesh.setColorAt(index, mixed);
      }
      if (mesh.instanceColor !== null) mesh.instanceColor.needsUpdate = true;
    }
  }

  setLook(look: Look): void {
    this.edges.visible = look !== "wire";
    for (const [key, material] of this.materials) {
      const opacity = Number(key.split("|")[0]) * this.fade * (look === "transparent" ? 0.35 : 1);
      material.wireframe = look === "wire";
      setOpacity(material, opacity);
    }
  }

  /** Return what an instance of a mesh shows, or undefined for a mesh of others. */
  entryOf(mesh: unknown, instance: number): { body: number; element: string } | undefined {
    const batch = this.batches.find((each) => each.mesh === mesh);
    return batch?.entries[instance % batch.entries.length];
  }

  dispose(): void {
    for (const { mesh } of this.batches) mesh.dispose();
    for (const material of this.materials.values()) material.dispose();
    this.edgeMaterial.dispose();
    this.object.removeFromParent();
  }

  private createBatch(solid: Solid, entries: Entry[]): Batch {
    const { key, doubleSided } = shapeOf(solid);
    const material = this.material(solid.opacity, doubleSided);
    const mesh = new InstancedMesh(this.store.get(key), material, entries.length * this.copies);
    mesh.frustumCulled = false;
    this.object.add(mesh);
    if (this.fade === 1 && solid.opacity === 1) this.addDetails(mesh, key);
    return { mesh, entries };
  }

  /** Shadows and edges, which translucent copies have not. */
  private addDetails(mesh: Batch["mesh"], key: string): void {
    mesh.castShadow = mesh.receiveShadow = true;
    const edges = this.store.made(`edges ${key}`, () => edgesOf(mesh.geometry));
    if (edges.hasAttribute("position") && edges.getAttribute("position").count > 0) this.edges.add(createEdges(mesh, edges, this.edgeMaterial));
  }

  private material(opacity: number, doubleSided: boolean): MeshStandardMaterial {
    const key = `${opacity}|${doubleSided ? "double" : "front"}`;
    const material =
      this.materials.get(key) ??
      new MeshStandardMaterial({
        roughness: 0.5, metalness: 0.05, side: doubleSided ? DoubleSide : FrontSide, shadowSide: DoubleSide,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1, // edges lie on faces
      }); // prettier-ignore
    this.materials.set(key, material);
    setOpacity(material, opacity * this.fade);
    return material;
  }
}

function setOpacity(material: MeshStandardMaterial, opacity: number): void {
  material.opacity = opacity;
  material.transparent = opacity < 1;
  material.depthWrite = opacity >= 0.5;
  material.needsUpdate = true;
}
