import { describe, expect, it } from "vitest";
import { settingsFrom } from "../src/player/settings";
import { decodeData } from "../src/player/data";
import { fixture, fixtureValue } from "./fixture";

/** Return the four-bar's value with one place changed. */
function changed(path: string, value: unknown): unknown {
  const data = fixtureValue("four_bar");
  const keys = path.split(".");
  const last = keys.pop()!;
  const parent = keys.reduce<Record<string, unknown>>((each, key) => each[key] as Record<string, unknown>, data);
  parent[last] = value;
  return data;
}

describe("decodeData", () => {
  it("reads a scene with its motion", () => {
    const { scene, source, title, settings } = fixture("four_bar");
    expect(title).toBe("Four-bar linkage with a spring");
    expect(scene.bodies.map((each) => each.name)).toEqual(["ground", "crank", "coupler", "rocker"]);
    expect(scene.connectors.map((each) => each.kind)).toEqual(["spring", "damper", "rope"]);
    expect(source.end).toBeCloseTo(6, 12);
    expect(source.curves.map((each) => each.unit)).toContain("N m");
    expect(source.events[0]).toEqual({ name: "spring slack", t: 1.55 });
    expect(settings.traces).toEqual(["coupler.P"]);
  });

  it("reads a scene without a motion as one that rests", () => {
    const { source } = decodeData(changed("motion", null));
    expect(source.end - source.start).toBe(0);
  });

  it.each([
    ["scene.bodies", [], "scene.bodies"],
    ["scene.version", 2, "version 2"],
    ["scene.size", 0, "scene.size"],
    ["scene.up", [0, 1], "scene.up"],
    ["scene.bodies.1.solids.0.kind", "torus", "scene.bodies[1].solids[0].kind"],
    ["scene.bodies.1.solids.0.color", "red", "scene.bodies[1].solids[0].color"],
    ["scene.bodies.2.solids.3.mesh", 7, "scene.bodies[2].solids[3].mesh"],
    ["scene.connectors.0.start.body", 9, "scene.connectors[0].start.body"],
    ["motion.times", "AAAA", "motion.times"],
    ["motion.times", "*", "base64"],
    ["motion.positions", "AACAPw==", "motion.positions"],
    ["motion.curves.0.values", "AACAPw==", "motion.curves[0].values"],
    ["motion.vectors.0.kind", "moment", "motion.vectors[0].kind"],
  ])("names the damaged place: %s = %j", (path, value, where) => {
    expect(() => decodeData(changed(path, value))).toThrow(where);
  });

  it("refuses numbers that are not finite", () => {
    const notANumber = btoa(String.fromCharCode(...new Uint8Array(new Float64Array([NaN]).buffer)));
    expect(() => decodeData(changed("motion.times", notANumber))).toThrow("not finite");
  });

  it("says that a page carries nothing", () => {
    expect(() => decodeData(null)).toThrow("no mechanism");
  });

  it("leaves out options that are unknown or of another type", () => {
    const { settings } = decodeData(changed("options", { ghosts: 99, theme: "pink", labels: "yes", nothing: 1, view: "top" }));
    expect(settings).toMatchObject({ ghosts: 12, theme: "auto", labels: true, view: "top" });
    expect(settings).not.toHaveProperty("nothing");
  });

  it("shows the names of up to six bodies", () => {
    expect([0, 6, 7].map((bodies) => settingsFrom({}, bodies).labels)).toEqual([true, true, false]);
    expect(settingsFrom({ labels: false }, 2).labels).toBe(false);
  });
});
