import { describe, expect, it } from "vitest";
import { addElement, addFrame, changeType, copyEntries, newEntry, pasteEntries, reconnect, removeEntries, removeFrame } from "../../src/builder/model/edit";
import { entriesOf, entryNamed } from "../../src/builder/model/entries";
import { patched, valueAt, withValue } from "../../src/builder/model/pointers";
import { renameCoordinate, renameEntry, renameFrame, renameParameter } from "../../src/builder/model/rename";
import { isInTree, withTree } from "../../src/builder/model/trees";
import { elementNamed, elements, schema, sliderCrank } from "./models";

describe("renaming", () => {
  it("takes along all references to a body, and its place in the diagram", () => {
    const placed = withValue(sliderCrank, "/layout", { nodes: { Crank: [1, 2] }, sides: { "Crank.A": "left" } });
    const renamed = renameEntry(schema, placed, "body/0", "Arm");
    expect(entryNamed(renamed, "A")?.value["between"]).toEqual(["ground", "Arm.A"]);
    expect(entryNamed(renamed, "B")?.value["between"]).toEqual(["Arm.B", "Rod.B"]);
    expect(valueAt(renamed, "/layout")).toEqual({ nodes: { Arm: [1, 2] }, sides: { "Arm.A": "left" } });
    expect(JSON.stringify(renamed)).not.toContain("Crank");
  });

  it("takes along what is joined to a frame, of that body alone", () => {
    const renamed = renameFrame(sliderCrank, "body/0", "B", "tip");
    expect(entryNamed(renamed, "B")?.value["between"]).toEqual(["Crank.tip", "Rod.B"]);
    expect(Object.keys(valueAt(renamed, "/body/0/frames") as object)).toEqual(["A", "tip"]);
  });

  it("takes along initial values and rates of a coordinate", () => {
    const renamed = renameCoordinate(schema, sliderCrank, "theta", "q");
    expect(entryNamed(renamed, "A")?.value["coordinate"]).toBe("q");
    expect(Object.keys(renamed["initial"] as object)).toEqual(["q", "beta", "s", "q_dot"]);
  });

  it("changes a parameter in formulas, and neither in names nor in longer words", () => {
    const model = withValue(sliderCrank, "/body/2/mass", "L1*L12 + L1_dot");
    const renamed = renameParameter(schema, model, "L1", "r");
    expect(valueAt(renamed, "/body/0/frames/A/at/0")).toBe("-r/2");
    expect(valueAt(renamed, "/body/2/mass")).toBe("r*L12 + r_dot");
    const axis = renameParameter(schema, withValue(sliderCrank, "/parameters/x", "1"), "x", "long");
    expect(entryNamed(axis, "D")?.value["axis"]).toBe("x");
  });
});

describe("adding and removing", () => {
  it("gives new elements names that are free, and all their required fields", () => {
    const one = addElement(schema, sliderCrank, elementNamed("body"), null, null);
    const two = addElement(schema, one.data, elementNamed("body"), null, [0, 0]);
    const names = entriesOf(two.data).map((each) => each.name);
    expect(new Set(names).size).toBe(names.length);
    for (const element of elements) {
      const entry = newEntry(schema, element, "N", ["ground", "Rod.C"]);
      const definition = valueAt(schema, `/$defs/${element.definition}`) as { required?: string[]; properties: object };
      expect(Object.keys(entry)).toEqual(expect.arrayContaining(definition.required ?? []));
      expect(Object.keys(definition.properties)).toEqual(expect.arrayContaining(Object.keys(entry)));
    }
  });

  it("removes with a body all that joins it, and leaves the ground", () => {
    const cut = removeEntries(sliderCrank, ["body/1", "ground"]);
    expect(entriesOf(cut).map((each) => each.name)).toEqual(["Crank", "Piston", "A", "D"]);
    expect(removeEntries(sliderCrank, ["ground"])).toBe(sliderCrank);
  });

  it("removes initial values of automatic coordinates, and none of others", () => {
    const free = withValue(sliderCrank, "/initial", { theta: "1", Rod_x: "1", Rod_qw_dot: "0", Rod_2: "1", Rod2_x: "1", Rodney: "1" });
    expect(Object.keys(removeEntries(free, ["body/1"])["initial"] as object)).toEqual(["theta", "Rod2_x", "Rodney"]);
    expect(removeEntries(withValue(sliderCrank, "/initial", { s: "1" }), ["joint/3"])["initial"]).toBeUndefined();
  });

  it("joins to the body what was joined to a removed frame", () => {
    const cut = removeFrame(sliderCrank, "body/0", "B");
    expect(entryNamed(cut, "B")?.value["between"]).toEqual(["Crank", "Rod.B"]);
  });

  it("pastes copies under free names, joined among themselves, without the names of coordinates", () => {
    const { data, ids } = pasteEntries(schema, sliderCrank, copyEntries(sliderCrank, ["body/0", "body/1"]));
    expect(ids).toHaveLength(3);
    const names = entriesOf(data).map((each) => each.name);
    expect(new Set(names).size).toBe(names.length);
    const joint = entriesOf(data).at(-1)!;
    expect(joint.value["between"]).toEqual(["Crank1.B", "Rod1.B"]);
    expect(joint.value["coordinate"]).toBeUndefined();
  });

  it("adds frames, changes types and ends", () => {
    expect(Object.keys(valueAt(addFrame(sliderCrank, "body/0").data, "/body/0/frames") as object)).toEqual(["A", "B", "C"]);
    const slid = changeType(schema, sliderCrank, "joint/0", elementNamed("prismatic"));
    expect(valueAt(slid, "/joint/0")).toMatchObject({ name: "A", type: "prismatic", between: ["ground", "Crank.A"], coordinate: "theta", axis: "z" });
    expect(valueAt(reconnect(sliderCrank, "joint/0", "ground", "Rod.C"), "/joint/0/between")).toEqual(["ground", "Rod.C"]);
  });
});

describe("trees and repairs", () => {
  it("say as little as possible", () => {
    const out = withTree(withTree(sliderCrank, "joint/1", "rotation", false), "joint/1", "translation", false);
    expect(valueAt(out, "/joint/1/tree")).toBe(false);
    expect(isInTree(out, null, "joint/1", "rotation")).toBe(false);
    const half = withTree(out, "joint/1", "rotation", true);
    expect(valueAt(half, "/joint/1/tree")).toEqual({ rotation: true, translation: false });
    const free = withTree(withTree(half, "joint/1", "rotation", null), "joint/1", "translation", null);
    expect(valueAt(free, "/joint/1/tree")).toBeUndefined();
  });

  it("follow a patch of the server", () => {
    const next = patched(sliderCrank, [
      { op: "add", path: "/parameters/k", value: "1" }, { op: "replace", path: "/joint/1/tree", value: false }, { op: "add", path: "/inputs/-", value: "T" }, { op: "remove", path: "/initial/s" },
    ]); // prettier-ignore
    expect(valueAt(next, "/parameters/k")).toBe("1");
    expect(valueAt(next, "/inputs")).toEqual(["F", "T"]);
    expect(valueAt(next, "/initial/s")).toBeUndefined();
    expect(valueAt(sliderCrank, "/parameters/k")).toBeUndefined();
  });
});
