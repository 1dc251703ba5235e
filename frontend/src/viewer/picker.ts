/** What lies under a point of the picture. */

import { Raycaster, Vector2, type Camera, type Intersection, type Object3D, type Ray, type Vector3 } from "three";
import type { VectorArrows } from "./arrows";
import type { Connectors } from "./connectors";
import type { Scene } from "./contract";
import type { SceneElement } from "./layer";
import type { JointMarks } from "./marks";
import type { Solids } from "./solids";

export interface Pickable {
  readonly solids: Solids;
  readonly connectors: Connectors;
  readonly arrows: VectorArrows;
  readonly joints: JointMarks;
}

/** An element, and the point of it that is seen, in ground's axes [m]. */
export interface Hit {
  readonly element: SceneElement;
  readonly point: Vector3;
}

/** Return the element of a scene with a name, or null. */
export function elementNamed(scene: Scene, name: string): SceneElement | null {
  const body = scene.bodies.findIndex((each) => each.name === name);
  if (body >= 0) return { kind: "body", name, type: body === 0 ? "ground" : "body", body };
  const joint = scene.joints.find((each) => each.name === name);
  if (joint !== undefined) return { kind: "joint", name, type: joint.type, body: joint.end.body };
  const connector = scene.connectors.find((each) => each.element === name);
  if (connector !== undefined) return { kind: "connector", name, type: connector.kind, body: connector.end.body };
  return null;
}

export class Picker {
  private readonly ray = new Raycaster();
  private readonly point = new Vector2();

  constructor(
    private readonly scene: Scene,
    private readonly layers: Pickable,
  ) {}

  /** Return the element at a point (from -1 to 1 across the picture, upwards), or null. */
  pick(x: number, y: number, camera: Camera): SceneElement | null {
    return this.hit(x, y, camera)?.element ?? null;
  }

  /** Return the line of sight through a point of the picture. */
  sight(x: number, y: number, camera: Camera): Ray {
    this.ray.setFromCamera(this.point.set(x, y), camera);
    return this.ray.ray;
  }

  /** Return what is seen at a point of the picture, or null. */
  hit(x: number, y: number, camera: Camera): Hit | null {
    this.ray.setFromCamera(this.point.set(x, y), camera);
    const { joints, solids, connectors, arrows } = this.layers;
    if (joints.object.visible) {
      const [mark] = this.ray.intersectObject(joints.object, true);
      const joint = mark === undefined ? undefined : joints.jointOf(mark.object, mark.instanceId ?? 0);
      const element = joint === undefined ? null : elementNamed(this.scene, joint.name);
      if (mark !== undefined && element !== null) return { element, point: mark.point };
    }
    const objects: Object3D[] = [solids.object, connectors.object, arrows.object];
    const [hit] = this.ray.intersectObjects(objects, true);
    const element = hit === undefined ? null : this.elementOf(hit);
    return hit === undefined || element === null ? null : { element, point: hit.point };
  }

  private elementOf(hit: Intersection): SceneElement | null {
    const instance = hit.instanceId ?? 0;
    const { solids, connectors, arrows } = this.layers;
    const entry = solids.entryOf(hit.object, instance);
    if (entry !== undefined) {
      const element = elementNamed(this.scene, entry.element);
      return element === null ? partOf(entry) : { ...element, body: entry.body };
    }
    const connector = connectors.connectorOf(hit.object);
    if (connector !== undefined) {
      return { kind: "connector", name: connector.element, type: connector.kind, body: connector.end.body };
    }
    const vector = arrows.vectorOf(hit.object, instance);
    if (vector === undefined) return null;
    return { kind: "vector", name: vector.name, type: vector.kind, body: vector.anchor.body };
  }
}

function partOf(entry: { body: number; element: string }): SceneElement {
  return { kind: "part", name: entry.element, type: "part", body: entry.body };
}
