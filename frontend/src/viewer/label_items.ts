/** What is labelled: bodies, joints, vectors. */

import type { Vector3 } from "three";
import { vectorGroup } from "./arrows";
import type { Scene } from "./contract";
import type { LabelItem } from "./labels";
import type { SceneElement } from "./layer";
import { bodyColor, VECTOR_COLORS } from "./palette";
import { LOOSE } from "./paths";
import type { StateSource } from "./source";

/** What labels need of a picture. */
interface Places {
  readonly shown: { labels: boolean; joints: boolean };
  positionOf(element: SceneElement, into: Vector3): boolean;
  bodyPosition(body: number, into: Vector3): Vector3;
  vectorTip(index: number): Vector3 | null;
}

function put(into: Vector3, place: Vector3): boolean {
  into.copy(place);
  return true;
}

export function labelItems(scene: Scene, source: StateSource, places: Places): LabelItem[] {
  const bodies = scene.bodies.slice(1).map((body, index): LabelItem => ({
    text: body.name,
    kind: "body",
    color: bodyColor(index + 1),
    place: (into) => places.shown.labels && put(into, places.bodyPosition(index + 1, into)),
  }));
  // a joint that holds nothing in its place is nowhere
  const joints = scene.joints.filter(({ type }) => !LOOSE.includes(type)).map((joint): LabelItem => {
    const element: SceneElement = { kind: "joint", name: joint.name, type: joint.type, body: joint.end.body };
    return {
      text: joint.name,
      kind: "joint",
      color: "",
      place: (into) => (places.shown.labels || places.shown.joints) && places.positionOf(element, into),
    };
  });
  const vectors = source.vectors.map((vector, index): LabelItem => ({
    text: vector.name,
    kind: "vector",
    color: VECTOR_COLORS[vectorGroup(vector)],
    place: (into) => {
      const tip = places.shown.labels ? places.vectorTip(index) : null;
      return tip !== null && put(into, tip);
    },
  }));
  return [...bodies, ...joints, ...vectors];
}
