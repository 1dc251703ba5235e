import { describe, expect, it } from "vitest";
import { Clock, LiveSource, restPose, sampleBefore, StoredMotion, type Motion } from "../src/viewer";

const half = Math.SQRT1_2;

/** One body that moves by 2 m along x and turns by a right angle about z within a second. */
const motion: Motion = {
  times: new Float64Array([0, 1, 1, 3]),
  positions: new Float32Array([0, 0, 0, 2, 0, 0, 5, 0, 0, 5, 4, 0]),
  quaternions: new Float32Array([1, 0, 0, 0, half, 0, 0, half, half, 0, 0, half, -half, 0, 0, -half]),
  curves: [],
  vectors: [{ name: "F", kind: "force", anchor: { body: 1, at: [0, 0, 0] }, values: new Float32Array([0, 0, 0, 4, 0, 0, 4, 0, 0, 4, 8, 0]), places: new Float32Array([1, 2, 3, 1, 2, 5, 1, 2, 5, 1, 2, 7]), prints: true }],
  events: [],
};

describe("StoredMotion", () => {
  const source = new StoredMotion(motion, 2);

  it("goes straight between samples and along the arc", () => {
    const pose = restPose(2);
    source.poseAt(0.5, pose);
    expect([...pose.positions]).toEqual([0, 0, 0, 1, 0, 0]);
    expect(pose.quaternions[4]).toBeCloseTo(Math.cos(Math.PI / 8), 6);
    expect(pose.quaternions[7]).toBeCloseTo(Math.sin(Math.PI / 8), 6);
  });

  it("leaves the ground where it is", () => {
    const pose = restPose(2);
    source.poseAt(0.7, pose);
    expect([...pose.quaternions.slice(0, 4)]).toEqual([1, 0, 0, 0]);
  });

  it("holds the ends, and jumps where two samples have one time", () => {
    const pose = restPose(2);
    source.poseAt(-1, pose);
    expect(pose.positions[3]).toBe(0);
    source.poseAt(99, pose);
    expect(pose.positions[4]).toBe(4);
    source.poseAt(1, pose);
    expect(pose.positions[3]).toBe(5);
  });

  it("takes a quaternion and its negative for one", () => {
    const pose = restPose(2);
    source.poseAt(2, pose);
    expect(Math.abs(pose.quaternions[4]!)).toBeCloseTo(half, 6);
    expect(Math.hypot(...pose.quaternions.slice(4))).toBeCloseTo(1, 12);
  });

  it("mixes vectors", () => {
    const components = new Float64Array(3);
    source.vectorAt(0, 2, components);
    expect([...components]).toEqual([4, 4, 0]);
  });

  it("moves a vector that is fixed on no body straight between its places", () => {
    const place = new Float64Array(3);
    source.placeAt(0, 0.5, place);
    expect([...place]).toEqual([1, 2, 4]);
    source.placeAt(0, 2, place);
    expect([...place]).toEqual([1, 2, 6]);
  });
});

describe("sampleBefore", () => {
  it.each([[-1, 0], [0, 0], [0.9, 0], [1, 2], [2.9, 2], [3, 2], [9, 2]])("time %d lies behind sample %d", (time, sample) => {
    expect(sampleBefore(motion.times, time)).toBe(sample);
  });

  it("takes the only sample", () => {
    expect(sampleBefore(new Float64Array([2]), 5)).toBe(0);
  });
});

describe("LiveSource", () => {
  it("shows a state until it is taken back", () => {
    const source = new LiveSource(new StoredMotion(motion, 2), 2);
    const pose = restPose(2);
    expect(source.show({ positions: [[7, 8, 9]], quaternions: [[0, 0, 0, 1]] })).toBe(true);
    source.poseAt(0, pose);
    expect([...pose.positions.slice(3)]).toEqual([7, 8, 9]);
    source.show(null);
    source.poseAt(0, pose);
    expect(pose.positions[3]).toBe(0);
  });

  it("refuses a state of another number of bodies", () => {
    const source = new LiveSource(new StoredMotion(motion, 2), 2);
    expect(source.show({ positions: [[1, 2, 3], [4, 5, 6]], quaternions: [[1, 0, 0, 0]] })).toBe(false);
  });
});

describe("Clock", () => {
  it("runs at its speed and stops at the end", () => {
    const clock = new Clock(1, 3);
    clock.loop = false;
    clock.speed = 2;
    clock.play();
    clock.advance(0.5);
    expect(clock.time).toBe(2);
    clock.advance(5);
    expect([clock.time, clock.playing]).toEqual([3, false]);
    clock.play(); // from the end it begins again
    expect(clock.time).toBe(1);
  });

  it("loops without losing the rest of a step", () => {
    const clock = new Clock(0, 2);
    clock.play();
    clock.advance(4.5);
    expect(clock.time).toBeCloseTo(0.5, 12);
  });

  it("stays within its range", () => {
    const clock = new Clock(0, 2);
    clock.seek(-3);
    expect(clock.time).toBe(0);
    clock.seek(9);
    expect(clock.time).toBe(2);
    clock.seek(NaN);
    expect(clock.time).toBe(0);
  });

  it("has nothing to play where there is one instant", () => {
    const clock = new Clock(0, 0);
    clock.play();
    expect(clock.playing).toBe(false);
  });

  it("goes through the speeds", () => {
    const clock = new Clock(0, 1);
    clock.changeSpeed(1);
    expect(clock.speed).toBe(2);
    for (let step = 0; step < 9; step += 1) clock.changeSpeed(-1);
    expect(clock.speed).toBe(0.1);
  });
});
