import { describe, expect, it } from "vitest";
import { previewOf, quaternionsOf, readLive, sceneFor, stateOf, type Simulation } from "../src/live/simulation";

describe("what a live page adds to its simulation", () => {
  it("turns rotation matrices into unit quaternions, whatever the angle", () => {
    for (const angle of [0, 0.3, 1.5, 3.1, Math.PI]) {
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      const found = quaternionsOf(Float64Array.from([c, -s, 0, s, c, 0, 0, 0, 1]));
      const sign = found[0]! < -1e-9 || found[3]! < -1e-9 ? -1 : 1;
      expect(found.map((each) => sign * each)).toEqual([Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)].map((each) => expect.closeTo(each, 12) as unknown));
    }
  });

  it("adds the changes that several parameters make to the shapes", () => {
    const scene = { bodies: [{ size: [1, 2] }] };
    const tables = [
      { parameter: "L", min: 0, max: 2, entries: [[["bodies", 0, "size", 0], [0, 1, 2]]] },
      { parameter: "D", min: 0, max: 1, entries: [[["bodies", 0, "size", 0], [0, 0.5]]] },
    ] as Parameters<typeof sceneFor>[1];
    const now: Record<string, number> = { L: 1.5, D: 1 };
    const first: Record<string, number> = { L: 1, D: 0 };
    const found = sceneFor(scene, tables, (name) => now[name]!, (name) => first[name]!);
    expect(found).toEqual({ bodies: [{ size: [2, 2] }] });
    expect(scene.bodies[0]!.size[0]).toBe(1);
  });

  it("moves the corners of a mesh, whose numbers stand side by side for each value", () => {
    const text = (values: number[]): string => btoa(String.fromCharCode(...new Uint8Array(Float32Array.from(values).buffer)));
    const { tables } = readLive({
      controls: [],
      tables: [{ parameter: "b", min: 0, max: 2, entries: [[["meshes", 0, "vertices"], text([0, 0, 0, 1, 10, 0, 4, 20, 0])]] }],
    });
    const scene = { meshes: [{ vertices: text([1, 10, 5]) }] };
    const found = sceneFor(scene, tables, () => 1.5, () => 1) as { meshes: { vertices: Float32Array }[] };
    expect([...found.meshes[0]!.vertices]).toEqual([2.5, 15, 5]);
  });

  it("refuses damaged sliders", () => {
    expect(() => readLive(null)).toThrow("sliders");
    expect(() => readLive({ controls: [{ name: "m", kind: "mass", min: 0, max: 1 }], tables: [] })).toThrow("damaged");
    expect(readLive({ controls: [], tables: [] }).controls).toEqual([]);
  });

  it("previews a motion as far as it goes", () => {
    let time = 0;
    const simulation = {
      numbers: { startTime: 0, codes: { RUNNING: 0 } },
      get code() { return time > 1 ? 4 : 0; },
      advanceTo: (target: number) => { time = target; return true; },
      computePose: () => ({ positions: new Float64Array(3), axes: Float64Array.from([1, 0, 0, 0, 1, 0, 0, 0, 1]) }),
    } as unknown as Simulation;
    const motion = previewOf(simulation, 1, []);
    expect(motion.times.length).toBeLessThan(20);
    expect(motion.quaternions.length).toBe(4 * motion.times.length);
  });

  it("takes what follows the bodies as arrows: a place, and components in the first row of axes", () => {
    const simulation = {
      time: 0.5, numbers: { startTime: 0, codes: { RUNNING: 0 } }, code: 4, advanceTo: () => true,
      computePose: () => ({ positions: Float64Array.from([1, 2, 3, 4, 5, 6]), axes: Float64Array.from([1, 0, 0, 0, 1, 0, 0, 0, 1, 7, 8, 9, 0, 0, 0, 0, 0, 0]) }),
    } as unknown as Simulation; // prettier-ignore
    expect(stateOf(simulation, 1)).toEqual({ positions: [1, 2, 3], quaternions: [1, 0, 0, 0], vectors: [7, 8, 9], places: [4, 5, 6], time: 0.5 });
    const vector = { name: "contact heel", kind: "force" as const, anchor: { body: 1, at: [0, 0, 0] as const }, values: new Float32Array(3), places: new Float32Array(3), prints: true };
    const { vectors } = previewOf(simulation, 1, [vector]);
    expect(Array.from(vectors[0]!.values)).toEqual([7, 8, 9]);
    expect(Array.from(vectors[0]!.places!)).toEqual([4, 5, 6]);
  });
});
