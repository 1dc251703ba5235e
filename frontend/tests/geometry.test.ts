import { describe, expect, it } from "vitest";
import { writeRope } from "../src/viewer/catenary";
import { coilPoints, writeCoil } from "../src/viewer/coil";
import { createTube } from "../src/viewer/tube";

type Triple = [number, number, number];

function point(path: Float64Array, index: number): Triple {
  return [path[3 * index]!, path[3 * index + 1]!, path[3 * index + 2]!];
}

function distance(a: Triple, b: Triple): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

function lengthOf(path: Float64Array): number {
  let sum = 0;
  for (let index = 0; index + 1 < path.length / 3; index += 1) sum += distance(point(path, index), point(path, index + 1));
  return sum;
}

describe("writeCoil", () => {
  const start: Triple = [1, 2, 3];
  const end: Triple = [1, 2, 7];

  it("begins and ends at its points, and its turns have the radius", () => {
    const path = new Float64Array(3 * coilPoints(5));
    writeCoil(start, end, 5, 0.2, [0, 0, 0], path);
    expect(point(path, 0)).toEqual(start);
    expect(distance(point(path, coilPoints(5) - 1), end)).toBeLessThan(1e-12);
    const middle = point(path, 51);
    expect(Math.hypot(middle[0] - 1, middle[1] - 2)).toBeCloseTo(0.2, 12);
  });

  it("stretches with its ends and does not spin about its axis", () => {
    const across: Triple = [0, 0, 0];
    const short = new Float64Array(3 * coilPoints(5));
    const long = new Float64Array(3 * coilPoints(5));
    writeCoil(start, end, 5, 0.2, across, short);
    writeCoil(start, [1, 2, 11], 5, 0.2, across, long);
    const [a, b] = [point(short, 40), point(long, 40)];
    expect(b[0]).toBeCloseTo(a[0], 12);
    expect(b[1]).toBeCloseTo(a[1], 12);
    expect(b[2] - 3).toBeCloseTo(2 * (a[2] - 3), 12);
  });

  it("stays finite where the ends meet", () => {
    const path = new Float64Array(3 * coilPoints(3));
    writeCoil(start, start, 3, 0.2, [0, 0, 0], path);
    expect(path.every(Number.isFinite)).toBe(true);
  });
});

describe("writeRope", () => {
  const down: Triple = [0, 0, -1];

  it.each<[string, Triple, number]>([
    ["level", [2, 0, 0], 3],
    ["slightly slack", [2, 0, 0], 2.001],
    ["very long", [0.1, 0, 0], 40],
    ["ends at two heights", [1, 1, 1.5], 4],
    ["ends one over the other", [0, 0, 1], 3],
    ["ends that meet", [0, 0, 0], 2],
  ])("has its length: %s", (_, end, length) => {
    const path = new Float64Array(3 * 400);
    writeRope([0, 0, 0], end, length, down, path);
    expect(distance(point(path, 399), end)).toBeLessThan(1e-6 * length);
    // a chain of chords is shorter than its curve by a part of (length of a chord / radius)^2 / 24
    expect(lengthOf(path) / length).toBeGreaterThan(0.99);
    expect(lengthOf(path) / length).toBeLessThan(1 + 1e-9);
  });

  it("hangs below its ends, along gravity", () => {
    const path = new Float64Array(3 * 41);
    writeRope([0, 0, 0], [2, 0, 0], 3, down, path);
    const lowest = point(path, 20);
    expect(lowest[0]).toBeCloseTo(1, 9);
    // a cosh(1 / a) with sinh(1 / a) a = 3 / 2: a = 0.6164, a sag of 1.0053
    expect(lowest[2]).toBeCloseTo(-1.0053, 3);
  });

  it("is straight where it is taut, or longer than its length", () => {
    const path = new Float64Array(3 * 5);
    writeRope([0, 0, 0], [4, 0, 0], 3.5, down, path);
    expect([...path]).toEqual([0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0]);
  });
});

describe("createTube", () => {
  it("changes its points in place and keeps its geometry", () => {
    const tube = createTube(10, 6, 0.1);
    const before = tube.geometry.getAttribute("position").array;
    for (let index = 0; index < 10; index += 1) tube.path[3 * index] = index;
    tube.update();
    const positions = tube.geometry.getAttribute("position").array;
    expect(positions).toBe(before);
    for (let vertex = 0; vertex < 60; vertex += 1) {
      expect(Math.hypot(positions[3 * vertex + 1]!, positions[3 * vertex + 2]!)).toBeCloseTo(0.1, 6);
    }
  });

  it("is closed: each edge inside belongs to two triangles", () => {
    const index = [...createTube(4, 5, 1).geometry.getIndex()!.array];
    expect(index).toHaveLength(3 * 5 * 6);
    expect(Math.max(...index)).toBe(19);
  });
});
