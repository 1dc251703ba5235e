import { Matrix4, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { LiveSource, StoredMotion, vectorGroup, type Motion, type MotionVector } from "../src/viewer";
import { arrowScale, formatQuantity, roundDown, usualMagnitude } from "../src/viewer/arrow_scale";
import { viewDirection } from "../src/viewer/camera_rig";
import { Connectors } from "../src/viewer/connectors";
import { Footprints } from "../src/viewer/footprints";
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
  it("gives the usual arrow a part of the scene's size", () => {
    const usual = usualMagnitude(source.vectors, "force", source.times);
    expect(usual).toBeGreaterThan(25);
    expect(arrowScale(usual, 2) * usual).toBeCloseTo(0.7, 12);
    expect(arrowScale(0, 2)).toBe(0);
  });

  it("takes the scale of contacts from what they bear, not from the peak of an impact or from flight", () => {
    const times = Array.from({ length: 101 }, (_, k) => k / 100);
    const sizes = times.map((t) => (t < 0.5 ? 0 : t < 0.505 ? 900 : 10));
    const foot = { name: "contact foot", kind: "force", anchor: { body: 1, at: [0, 0, 0] }, values: Float32Array.from(sizes.flatMap((z) => [0, 0, z])), places: new Float32Array(303), prints: true } as MotionVector;
    expect(usualMagnitude([foot], "force", times)).toBe(10);
    expect(usualMagnitude([foot], "torque", times)).toBe(0);
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
    expect(vectorGroup({ ...source.vectors[1]!, name: "contact heel" })).toBe("contact");
  });
});

describe("footprints", () => {
  /** A foot that stands at x = 0 until 1 s, is in the air until 2 s, and then slides from x = 1 to x = 2 in a second. */
  const times = Array.from({ length: 31 }, (_, k) => k / 10);
  const motion: Motion = {
    times: Float64Array.from(times), positions: new Float32Array(93), quaternions: Float32Array.from(times.flatMap(() => [1, 0, 0, 0])), curves: [], events: [],
    vectors: [{
      name: "contact foot", kind: "force", anchor: { body: 1, at: [0, 0, 0] },
      values: Float32Array.from(times.flatMap((t) => [0, 0, t > 1 && t < 2 ? 0 : 5])),
      places: Float32Array.from(times.flatMap((t) => [t <= 1 ? 0 : t - 1, 0, 0])),
      prints: true,
    }],
  }; // prettier-ignore
  const pair = { ...scene, size: 2, bodies: scene.bodies.slice(0, 2) };
  const shown = (of: StateSource, time: number): number => {
    const prints = new Footprints(of, new GeometryStore(pair), 2);
    prints.update({ time, matrices: [] });
    const { count } = prints.object;
    prints.dispose();
    return count;
  };

  it("are where something has touched: one where it stood, a row where it slid, none ahead of the time", () => {
    const stored = new StoredMotion(motion, 2);
    expect(shown(stored, 0.9)).toBe(1);
    expect(shown(stored, 1.8)).toBe(0); // faded
    expect(shown(stored, 3)).toBe(11); // a sample each 0.1 m
    expect(shown(stored, 2.45)).toBe(5);
  });

  it("grow with a motion that is simulated, and begin anew with it", () => {
    const live = new LiveSource(new StoredMotion(motion, 2), 2);
    const show = (time: number, force: number, x: number): boolean => live.show({ positions: [0, 0, 0], quaternions: [1, 0, 0, 0], vectors: [0, 0, force], places: [x, 0, 0], time });
    show(0, 1, 0);
    show(0.1, 1, 0.001); // stands
    expect(shown(live, 0)).toBe(1);
    show(0.2, 0, 0.5);
    show(0.3, 1, 1);
    expect(shown(live, 0)).toBe(2);
    show(0, 1, 0);
    expect(shown(live, 0)).toBe(1);
    const place = new Float64Array(3);
    show(0.1, 1, 0.7);
    live.placeAt(0, 0, place);
    expect(place[0]).toBe(0.7);
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

  it("stays level where something bounces along its ground, and falls with what has none", () => {
    const [, bar] = scene.bodies;
    const ball = { ...bar!, mass: 1, solids: [{ ...bar!.solids[0]!, mesh: null, kind: "sphere", size: [0.1], at: [0, 0, 0] } as Solid], frames: [] };
    const floor = { ...scene.bodies[0]!, solids: [{ ...ball.solids[0]!, kind: "box", size: [9, 9, 0.01], at: [0, 0, -0.1] } as Solid], frames: [] };
    const bouncing = { ...source, start: 0, end: 1, poseAt: (time: number, pose: Pose) => { pose.positions.set([4 * time, 0, Math.abs(Math.cos(9 * time))], 3); } } as unknown as StateSource;
    const free = { ...scene, joints: [], connectors: [], normal: null, up: [0, 0, 1] as const, gravity: [0, 0, -9.81] as const };
    const above = motionExtent({ ...free, bodies: [floor, ball] }, bouncing);
    expect(above.roams).toBe(true);
    expect(above.fixed?.toArray()).toEqual([0, 0, 1]);
    expect(above.box.max.z - above.box.min.z).toBeGreaterThan(1); // all of its bounces
    expect(above.box.max.x - above.box.min.x).toBeLessThan(0.3);
    const falling = motionExtent({ ...free, bodies: [{ ...floor, solids: [] }, ball] }, bouncing);
    expect(falling.fixed).toBe(null);
    expect(falling.box.max.z - falling.box.min.z).toBeLessThan(0.3);
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
