/** What of a picture a scene decides: the layers, and where its bodies are. */

import { Matrix4, Vector3 } from "three";
import { VectorArrows } from "./arrows";
import { BodyLines } from "./body_lines";
import { Connectors } from "./connectors";
import type { Scene } from "./contract";
import { Footprints } from "./footprints";
import { Ground } from "./ground";
import type { Counts, Instant, Layer } from "./layer";
import { FrameAxes, JointMarks } from "./marks";
import { centreOf, drawnSize, motionExtent, shortestLengths, visitStates, type Extent } from "./paths";
import { GeometryStore, Solids } from "./solids";
import { restPose, type Pose, type StateSource } from "./source";
import { Traces } from "./traces";

export class Contents {
  readonly pose: Pose;
  readonly instant: Instant & { time: number };
  readonly extent: Extent;
  readonly store: GeometryStore;
  readonly solids: Solids;
  readonly connectors: Connectors;
  readonly arrows: VectorArrows;
  readonly axes: FrameAxes;
  readonly joints: JointMarks;
  readonly traces: Traces;
  readonly footprints: Footprints;
  readonly ground: Ground;
  readonly layers: readonly Layer[];
  /** Where a mechanism that goes far begins. */
  readonly first = new Vector3();

  constructor(
    readonly scene: Scene,
    readonly source: StateSource,
    counts: Counts,
    former: Contents | null = null,
  ) {
    this.pose = restPose(scene.bodies.length);
    this.instant = { time: source.start, matrices: scene.bodies.map(() => new Matrix4()) };
    this.store = new GeometryStore(scene, former?.store);
    this.extent = motionExtent(scene, source, this.store);
    visitStates(scene, source, [source.start], ({ matrices }) => { centreOf(scene, matrices, this.first); });
    this.solids = new Solids(scene, this.store);
    this.connectors = new Connectors(scene, this.store, shortestLengths(scene, source), counts);
    this.arrows = new VectorArrows(scene, source, this.store, drawnSize(scene, this.extent));
    this.axes = new FrameAxes(scene, this.store);
    this.joints = new JointMarks(scene, this.store);
    this.traces = new Traces(scene, source, counts);
    this.footprints = new Footprints(source, this.store, drawnSize(scene, this.extent));
    this.ground = new Ground(scene, this.extent);
    this.layers = [this.ground, this.solids, new BodyLines(scene), this.connectors, this.axes, this.footprints, this.arrows, this.traces, this.joints];
    this.store.tidy();
  }

  /** Write how far a camera has gone along with a mechanism that goes far, since the start. */
  travel(into: Vector3): void {
    centreOf(this.scene, this.instant.matrices, into).sub(this.first);
    if (this.extent.fixed !== null) into.projectOnPlane(this.extent.fixed);
  }

  dispose(): void {
    for (const layer of this.layers) {
      layer.object.removeFromParent();
      layer.dispose();
    }
    this.store.dispose();
  }
}

/** Return what scenes of one mechanism have in common, whatever its sizes: a text. */
export function castOf(scene: Scene): string {
  const { bodies, joints, connectors, up, normal } = scene;
  return JSON.stringify([
    bodies.map((body) => [body.name, body.frames.map((frame) => frame.name)]),
    joints.map((joint) => [joint.name, joint.type]),
    connectors.map((connector) => [connector.element, connector.kind]),
    up, normal,
  ]); // prettier-ignore
}
