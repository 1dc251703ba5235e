import { describe, expect, it } from "vitest";
import { forPalette, offered, usualFirst } from "../../src/builder/commands/insert";
import { addElement, reconnect, removeEntries } from "../../src/builder/model/edit";
import { entryNamed } from "../../src/builder/model/entries";
import { portFor, withHeldBodies } from "../../src/builder/model/ports";
import { valueAt } from "../../src/builder/model/pointers";
import { renameEntry } from "../../src/builder/model/rename";
import type { Model } from "../../src/builder/types";
import { elementNamed, elements, schema } from "./models";

const palette = offered({ schema, elements });
const EMPTY: Model = { name: "untitled" };

function added(data: Model, type: string, ends: readonly [string, string] | null = null): Model {
  const element = palette.find((each) => each.type === type) ?? elementNamed(type);
  return addElement(schema, data, element, ends, null).data;
}

describe("bodies with a size", () => {
  it("come with ports at their ends, and an inertia that follows from mass and length", () => {
    const two = added(added(EMPTY, "link"), "link");
    expect(valueAt(two, "/body/1")).toMatchObject({
      name: "Link2", mass: "m2", inertia: ["m2*L2^2/600", "m2*L2^2/12", "m2*L2^2/12"],
      frames: { A: { at: ["-L2/2", "0", "0"] }, B: { at: ["L2/2", "0", "0"] } },
    });
    expect(two["parameters"]).toEqual({ m1: "1", L1: "1", m2: "1", L2: "1" });
    const [first] = palette.filter((each) => each.section === "body");
    expect(first?.title).toBe("Link");
    expect(palette.filter((each) => each.section === "body").map((each) => each.type)).toEqual(["link", "plate", "slider", "wheel", "ball", ""]);
  });

  it("stand beside each other until they are joined, and keep their places when they are renamed", () => {
    const three = ["link", "ball", "plate"].reduce<Model>((data, type) => added(data, type), EMPTY);
    expect(three["initial"]).toEqual({ Ball1_x: "1.4", Plate1_x: "2.8" });
    const renamed = renameEntry(schema, three, "body/1", "Bob");
    expect(renamed["initial"]).toEqual({ Bob_x: "1.4", Plate1_x: "2.8" });
    expect(removeEntries(renamed, ["body/1"])["initial"]).toEqual({ Plate1_x: "2.8" });
    const joined = withHeldBodies(renamed, added(renamed, "revolute", ["Link1.B", "Bob"]));
    expect(joined["initial"]).toEqual({ Plate1_x: "2.8" });
    const elsewhere = withHeldBodies(joined, reconnect(joined, "joint/0", "Link1.B", "Plate1.A"));
    expect(elsewhere["initial"]).toBeUndefined();
  });
});

describe("a joint", () => {
  it("takes the nearest port that is free", () => {
    const one = added(added(EMPTY, "plate"), "link");
    const near = (frame: string): number => ({ A: 3, B: 1, C: 2 })[frame] ?? 0;
    expect(portFor(one, "body/0", near)).toBe("B");
    const joined = added(one, "revolute", ["ground", "Plate1.B"]);
    expect(portFor(joined, "body/0", near)).toBe("C");
    expect(portFor(joined, "body/1")).toBe("A");
    expect(portFor(added(EMPTY, "ball"), "body/0")).toBe("");
    expect(entryNamed(joined, "J1")?.value["between"]).toEqual(["ground", "Plate1.B"]);
  });

  it("is offered by how usual it is, the last one first", () => {
    localStorage.clear();
    const usual = ["revolute", "prismatic", "weld", "spherical", ""];
    expect(usualFirst(elements).slice(0, 5).map((each) => each.type)).toEqual(usual);
    localStorage.setItem("symbody-last-connection", "universal");
    expect(usualFirst(elements).slice(0, 6).map((each) => each.type)).toEqual(["universal", ...usual]);
    expect(usualFirst(elements)).toHaveLength(elements.length);
    const joints = forPalette(elements).filter((each) => each.section === "joint");
    expect(joints.slice(0, 5).map((each) => each.type)).toEqual(["revolute", "prismatic", "weld", "spherical", "bearing"]);
    expect(forPalette(elements)).toHaveLength(elements.length);
  });
});
