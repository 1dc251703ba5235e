/** Lines along which chosen points pass: whole, or up to the time. */

import { Group, Vector3 } from "three";
import type { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import type { Anchor, Scene } from "./contract";
import { createLine, disposeLine } from "./fat_lines";
import { anchorPoint, type Counts, type Instant, type Layer } from "./layer";
import { bodyColor } from "./palette";
import { anchorPath } from "./paths";
import { sampleBefore, type StateSource } from "./source";

export type TraceMode = "past" | "whole";

/** A point that can be traced: a frame of a body. */
export interface TracePoint {
  /** "crank.tip" */
  readonly name: string;
  readonly anchor: Anchor;
}

interface Trace {
  readonly point: TracePoint;
  readonly line: LineSegments2;
  readonly path: Float32Array;
  ended: number; // the segment that was cut at the time
}

/** Return every frame of every body but the ground. */
export function tracePoints(scene: Scene): TracePoint[] {
  return scene.bodies.flatMap((body, index) =>
    index === 0 ? [] : body.frames.map((frame) => ({ name: `${body.name}.${frame.name}`, anchor: { body: index, at: frame.at } })),
  );
}

export class Traces implements Layer {
  readonly object = new Group();
  mode: TraceMode = "past";
  private traces: Trace[] = [];
  private readonly here = new Vector3();

  constructor(
    private readonly scene: Scene,
    private readonly source: StateSource,
    private readonly counts: Counts,
  ) {}

  get names(): string[] {
    return this.traces.map((each) => each.point.name);
  }

  /** Draw the traces of these points and of no others. */
  choose(points: readonly TracePoint[]): void {
    const gone = this.traces.filter((each) => !points.some((point) => point.name === each.point.name));
    for (const each of gone) disposeLine(each.line);
    this.traces = points.map((point) => this.traces.find((each) => each.point.name === point.name) ?? this.create(point));
  }

  update(instant: Instant): void {
    const last = this.source.times.length - 2;
    const segment = Math.min(sampleBefore(this.source.times, instant.time), last);
    if (last < 0) return;
    for (const trace of this.traces) {
      const whole = this.mode === "whole";
      this.cut(trace, whole ? last : segment, whole ? null : anchorPoint(trace.point.anchor, instant, this.here));
    }
  }

  dispose(): void {
    for (const each of this.traces) disposeLine(each.line);
    this.traces = [];
  }

  private create(point: TracePoint): Trace {
    const path = anchorPath(this.scene, this.source, point.anchor);
    const line = createLine(path, bodyColor(point.anchor.body), 2);
    this.counts.rebuilt += 1;
    this.object.add(line);
    return { point, line, path, ended: -1 };
  }

  /** Let the line end in a segment, at a point or at the segment's own end. */
  private cut(trace: Trace, segment: number, at: Vector3 | null): void {
    const attribute = trace.line.geometry.getAttribute("instanceEnd");
    if (trace.ended >= 0) {
      const p = 3 * (trace.ended + 1);
      attribute.setXYZ(trace.ended, trace.path[p]!, trace.path[p + 1]!, trace.path[p + 2]!);
    }
    trace.ended = at === null ? -1 : segment;
    if (at !== null) attribute.setXYZ(segment, at.x, at.y, at.z);
    if ("data" in attribute) attribute.data.needsUpdate = true;
    trace.line.geometry.instanceCount = segment + 1;
  }
}
