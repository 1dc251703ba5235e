import { Matrix4, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { vectorGroup } from "../src/viewer";
import { arrowScale, formatQuantity, largestMagnitude, roundDown } from "../src/viewer/arrow_scale";
import { viewDirection } from "../src/viewer/camera_rig";
import { Connectors } from "../src/viewer/connectors";
import { spanMatrix, type Counts } from "../src/viewer/layer";
import type { Scene, Solid } from "../src/viewer/contract";
import type { Pose, StateSource } from "../src/viewer/source";
import { anchorPath, motionExtent, shortestLengths, visitStates } from "../src/viewer/paths";
import { elementNamed } from "../src/viewer/picker";
import { GeometryStore, Solids } from "../src/viewer/solids";
import { tracePoints, Traces } from "../src/viewer/traces";
import { fixture } from "./fixture";

const { scene, source } = fixture("four_bar");

describe("arrows", () => {
  it("gives the largest arrow a part of the scene's size", () => {
    const largest = largestMagnitude(source.vectors, "force");
    expect(largest).toBeGreaterThan(30);
    expect(arrowScale(largest, 2) * largest).toBeCloseTo(0.9, 12);
    expect(arrowScale(0, 2)).toBe(0);
  });

  it.each([[1, 1], [9.99, 5], [0.0021, 0.002], [450, 200], [50, 50], [1e-7, 1e-7]])("rounds %d down to %d", (value, round) => {
    expect(roundDown(value)).toBeCloseTo(round, 12);
  });

  it("writes quantities with prefixes", () => {
    expect(formatQuantity(20, "N")).toBe("20\u202fN");
    expect(formatQuantity(5000, "N")).toBe("5\u202fkN");
    expect(formatQuantity(2e6, "N\u202fm")).toBe("2\u202fMN\u202fm");
  });

  it("separates reactions from applied forces", () => {
    expect(source.vectors.map(vectorGroup)).toEqual(["reaction", "force", "torque"]);
  });
});

describe("views", () => {
  it("looks at a planar scene against its normal", () => {
    expect(viewDirection(scene, "front").toArray()).toEqual([0, 0, 1]);
    expect(viewDirection(scene, "right").toArray()).toEqual([1, 0, 0]);
  });

  it("has x to the right in space, up upwards", () => {
    const space = { ...scene, normal: null, up: [0, 0, 1] as const };
    const [front, right, top] = (["front", "right", "top"] as const).map((each) => viewDirection(space, each));
    expect(front!.distanceTo(new Vector3(0, -1, 0))).toBeLessThan(1e-12);
    expect(right!.distanceTo(new Vector3(1, 0, 0))).toBeLessThan(1e-12);
    expect(top!.distanceTo(new Vector3(0, 0, 1))).toBeLessThan(1e-3);
  });

  it("fits to everything that moves", () => {
    const { box, points } = motionExtent(scene, source);
    expect(box.min.x).toBeLessThan(-0.4);
    expect(box.max.x).toBeGreaterThanOrEqual(1.7);
    expect(points.length % 3).toBe(0);
  });
});

describe("the floor", () => {
  const quaternion = [1, 0, 0, 0] as const;
  /** A bar of 1 m in the air that turns about its end at the height of 0.3 m, with a foot on the ground or above it. */
  function arm(foot: number): [Scene, StateSource] {
    const [ground, bar] = scene.bodies;
    const solid = { ...bar!.solids[0]!, mesh: null, kind: "box", size: [0.1, 0.1, 0.1], quaternion } as Solid;
    const bodies = [
      { ...ground!, solids: [{ ...solid, at: [0, 0, foot + 0.05] }], frames: [] },
      { ...bar!, solids: [{ ...solid, at: [1, 0, 0] }], frames: [] },
    ] as Scene["bodies"];
    const standing = { ...scene, bodies, joints: [{ ...scene.joints[0]!, type: "revolute" }], connectors: [], meshes: [], normal: null, up: [0, 0, 1], size: 1 } as Scene;
    const motion = {
      ...source,
      start: 0,
      end: 1,
      poseAt(time: number, pose: Pose) {
        pose.positions.set([0, 0, 0.3], 3);
        pose.quaternions.set([Math.cos(time), 0, Math.sin(time), 0], 4); // falls by 2 rad
      },
    } as unknown as StateSource;
    return [standing, motion];
  }

  it("is at the foot of what stands on a base, though its arm falls deeper", () => {
    const { box } = motionExtent(...arm(0));
    expect(box.min.z).toBeCloseTo(0, 12);
  });

  it("is below all that hangs", () => {
    const { box } = motionExtent(...arm(0.8));
    expect(box.min.z).toBeLessThan(-0.6);
  });
});

describe("solids", () => {
  it("draws each geometry once for all bodies that share it", () => {
    const chain = fixture("chain");
    const solids = new Solids(chain.scene, new GeometryStore(chain.scene));
    expect(solids.count).toBe(601);
    expect(solids.object.children.length).toBeLessThanOrEqual(4); // the last holds the edges
    solids.dispose();
  });
});

describe("connectors", () => {
  it("keep their geometries while they stretch", () => {
    const counts: Counts = { rebuilt: 0, frames: 0 };
    const connectors = new Connectors(scene, new GeometryStore(scene), shortestLengths(scene, source), counts);
    const made = counts.rebuilt;
    const geometries = (): string[] => {
      const ids: string[] = [];
      connectors.object.traverse((each) => { if ("geometry" in each) ids.push((each.geometry as { uuid: string }).uuid); });
      return ids;
    };
    const before = geometries();
    visitStates(scene, source, [0, 1, 2, 3], (instant) => { connectors.update(instant); });
    expect(geometries()).toEqual(before);
    expect(counts.rebuilt).toBe(made);
    connectors.dispose();
  });

  it("span from one point to another", () => {
    const matrix = spanMatrix(new Vector3(1, 0, 0), new Vector3(1, 4, 0), 0.5, new Matrix4());
    expect(new Vector3(0, 0, -0.5).applyMatrix4(matrix).distanceTo(new Vector3(1, 0, 0))).toBeLessThan(1e-12);
    expect(new Vector3(0, 0, 0.5).applyMatrix4(matrix).distanceTo(new Vector3(1, 4, 0))).toBeLessThan(1e-12);
  });
});

describe("traces", () => {
  const point = tracePoints(scene).find((each) => each.name === "coupler.P")!;

  it("passes where the frame is", () => {
    const path = anchorPath(scene, source, point.anchor);
    expect(path).toHaveLength(3 * source.times.length);
    visitStates(scene, source, [source.times[30]!], ({ matrices }) => {
      const place = new Vector3(...point.anchor.at).applyMatrix4(matrices[2]!);
      expect(place.distanceTo(new Vector3().fromArray(path, 90))).toBeLessThan(1e-6);
    });
  });

  it("ends at the time, and is whole again after", () => {
    const traces = new Traces(scene, source, { rebuilt: 0, frames: 0 });
    traces.choose([point]);
    const [line] = traces.object.children as { geometry?: { instanceCount: number } }[] as [{ geometry: { instanceCount: number } }];
    visitStates(scene, source, [1.23], (instant) => { traces.update(instant); });
    expect(line.geometry.instanceCount).toBe(25);
    traces.mode = "whole";
    visitStates(scene, source, [1.23], (instant) => { traces.update(instant); });
    expect(line.geometry.instanceCount).toBe(120);
    traces.dispose();
  });
});

describe("elementNamed", () => {
  it("finds bodies, joints and connectors by their names", () => {
    expect(elementNamed(scene, "rocker")).toMatchObject({ kind: "body", body: 3 });
    expect(elementNamed(scene, "C")).toMatchObject({ kind: "joint", type: "revolute" });
    expect(elementNamed(scene, "spring")).toMatchObject({ kind: "connector", type: "spring" });
    expect(elementNamed(scene, "nothing")).toBeNull();
  });
});
