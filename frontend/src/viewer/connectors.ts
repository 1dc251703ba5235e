/** Springs, dampers, ropes, actuators and lines between two points; their geometry is changed in place. */

import { Color, Group, Matrix4, Mesh, MeshStandardMaterial, Vector3, type BufferGeometry } from "three";
import { writeRope } from "./catenary";
import { coilPoints, writeCoil } from "./coil";
import type { Connector, Point, Scene } from "./contract";
import { anchorPoint, spanMatrix, type Counts, type Instant, type Layer } from "./layer";
import { CONNECTOR_COLORS, HIGHLIGHT, LIGHT, NO_LIGHTS } from "./palette";
import type { GeometryStore } from "./solids";
import { createTube, type Tube } from "./tube";

const ROPE_POINTS = 40;
const TUBE_SIDES = 7;
const USUAL_TURNS = 8;
const HOUSING = 0.55; // part of the shortest length that a damper's cylinder takes

interface Part {
  readonly connector: Connector;
  readonly meshes: readonly Mesh[];
  readonly material: MeshStandardMaterial;
  /** `carrier` is the matrix of the body at the start. */
  update(start: Vector3, end: Vector3, carrier: Matrix4): void;
}

const glare = new Color(LIGHT);
const start = new Vector3();
const end = new Vector3();

export class Connectors implements Layer {
  readonly object = new Group();
  private readonly parts: Part[];

  /** `shortest` has the least length of each connector along the motion [m]. */
  constructor(scene: Scene, store: GeometryStore, shortest: readonly number[], counts: Counts) {
    const down = downOf(scene);
    this.parts = scene.connectors.map((connector, index) => {
      const material = new MeshStandardMaterial({ color: colorOf(connector), roughness: 0.4, metalness: 0.25 });
      counts.rebuilt += connector.kind === "spring" || connector.kind === "rope" ? 1 : 0;
      return createPart(connector, material, store, down, scene.size, shortest[index] ?? 0);
    });
    for (const part of this.parts) this.object.add(...part.meshes);
    this.object.traverse((each) => { each.castShadow = true; });
  }

  update(instant: Instant): void {
    for (const part of this.parts) {
      anchorPoint(part.connector.start, instant, start);
      anchorPoint(part.connector.end, instant, end);
      part.update(start, end, instant.matrices[part.connector.start.body]!);
    }
  }

  paint(selected: string, hovered: string, lights = NO_LIGHTS): void {
    for (const { connector, material } of this.parts) {
      const name = connector.element;
      material.color.set(name !== "" && name === selected ? HIGHLIGHT : colorOf(connector));
      if (name !== selected) material.color.lerp(glare, lights.get(name) ?? 0);
      if (name !== "" && name === hovered && name !== selected) material.color.offsetHSL(0, 0, 0.12);
    }
  }

  setWire(wire: boolean): void {
    for (const { material } of this.parts) material.wireframe = wire;
  }

  connectorOf(mesh: unknown): Connector | undefined {
    return this.parts.find((part) => part.meshes.some((each) => each === mesh))?.connector;
  }

  dispose(): void {
    for (const part of this.parts) {
      part.material.dispose();
      const [mesh] = part.meshes;
      if (part.connector.kind === "spring" || part.connector.kind === "rope") mesh?.geometry.dispose();
    }
  }
}

function colorOf(connector: Connector): string {
  return connector.color === "" ? CONNECTOR_COLORS[connector.kind] : connector.color;
}

function downOf(scene: Scene): Point {
  const down = new Vector3(...(scene.gravity ?? scene.up)).normalize();
  return scene.gravity === null ? down.negate().toArray() : down.toArray();
}

function createPart(
  connector: Connector,
  material: MeshStandardMaterial,
  store: GeometryStore,
  down: Point,
  size: number,
  shortest: number,
): Part {
  switch (connector.kind) {
    case "spring":
      return springPart(connector, material, size);
    case "rope":
      return ropePart(connector, material, down, size);
    case "damper":
    case "actuator":
      return telescopePart(connector, material, store.get("cylinder"), size, shortest);
    case "line":
      return rodPart(connector, material, store.get("cylinder"), size);
  }
}

function tubeMesh(tube: Tube, material: MeshStandardMaterial): Mesh {
  const mesh = new Mesh(tube.geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}

function springPart(connector: Connector, material: MeshStandardMaterial, size: number): Part {
  const turns = connector.coils > 0 ? Math.min(Math.max(Math.round(connector.coils), 2), 60) : USUAL_TURNS;
  const radius = connector.radius > 0 ? connector.radius : 0.03 * size;
  const tube = createTube(coilPoints(turns), TUBE_SIDES, 0.14 * radius);
  const across: [number, number, number] = [0, 0, 0];
  const side = new Vector3();
  let axis = -1;
  const update = (from: Vector3, to: Vector3, carrier: Matrix4): void => {
    // the turns begin in a direction of the body that carries them, the same at each return to a time
    if (axis < 0) axis = mostAcross(side.subVectors(to, from), carrier);
    side.setFromMatrixColumn(carrier, axis).toArray(across);
    writeCoil([from.x, from.y, from.z], [to.x, to.y, to.z], turns, radius, across, tube.path);
    tube.update();
  };
  return { connector, material, meshes: [tubeMesh(tube, material)], update };
}

/** Return which of a body's axes is the most perpendicular to a direction. */
function mostAcross(direction: Vector3, carrier: Matrix4): number {
  const axis = new Vector3();
  const along = [0, 1, 2].map((each) => Math.abs(axis.setFromMatrixColumn(carrier, each).dot(direction)));
  return along.indexOf(Math.min(...along));
}

function ropePart(connector: Connector, material: MeshStandardMaterial, down: Point, size: number): Part {
  const tube = createTube(ROPE_POINTS, TUBE_SIDES, connector.radius > 0 ? connector.radius : 0.006 * size);
  const direction: [number, number, number] = [...down];
  const update = (from: Vector3, to: Vector3): void => {
    writeRope([from.x, from.y, from.z], [to.x, to.y, to.z], connector.length, direction, tube.path);
    tube.update();
  };
  return { connector, material, meshes: [tubeMesh(tube, material)], update };
}

/** A cylinder of fixed length at the start, and a rod that runs out of it to the end. */
function telescopePart(
  connector: Connector,
  material: MeshStandardMaterial,
  cylinder: BufferGeometry,
  size: number,
  shortest: number,
): Part {
  const radius = connector.radius > 0 ? connector.radius : 0.025 * size;
  const housing = fixedMesh(cylinder, material);
  const rod = fixedMesh(cylinder, material);
  const ring = fixedMesh(cylinder, material);
  const mouth = new Vector3();
  const rim = new Vector3();
  const inner = 0.38 * radius;
  const update = (from: Vector3, to: Vector3): void => {
    const length = Math.max(from.distanceTo(to), 1e-9);
    const reach = Math.min(HOUSING * (shortest > 0 ? shortest : length), 0.9 * length);
    mouth.lerpVectors(from, to, reach / length);
    rim.lerpVectors(from, to, Math.max(reach - 0.35 * radius, 0) / length);
    spanMatrix(from, mouth, radius, housing.matrix);
    spanMatrix(from, to, inner, rod.matrix);
    spanMatrix(rim, mouth, 1.15 * radius, ring.matrix);
    for (const mesh of [housing, rod, ring]) mesh.matrixWorldNeedsUpdate = true;
  };
  return { connector, material, meshes: [housing, rod, ring], update };
}

function rodPart(connector: Connector, material: MeshStandardMaterial, cylinder: BufferGeometry, size: number): Part {
  const mesh = fixedMesh(cylinder, material);
  const radius = connector.radius > 0 ? connector.radius : 0.004 * size;
  const update = (from: Vector3, to: Vector3): void => {
    spanMatrix(from, to, radius, mesh.matrix);
    mesh.matrixWorldNeedsUpdate = true;
  };
  return { connector, material, meshes: [mesh], update };
}

function fixedMesh(geometry: BufferGeometry, material: MeshStandardMaterial): Mesh {
  const mesh = new Mesh(geometry, material);
  mesh.matrixAutoUpdate = false;
  mesh.matrix = new Matrix4();
  return mesh;
}
