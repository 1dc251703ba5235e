import { describe, expect, it } from "vitest";
import { diagramOf } from "../../src/builder/model/graph";
import { initialText, withInitial } from "../../src/builder/model/initial";
import { sizeOf, spotsOf } from "../../src/builder/model/layout";
import { mergedDrafts } from "../../src/builder/commands/drafts";
import { keepWires } from "../../src/builder/model/wires";
import type { Model, ServedWire } from "../../src/builder/types";
import { sliderCrank } from "./models";

const revolute = (name: string, body: string, more: object = {}): Model => ({ name, type: "revolute", between: ["ground", body], ...more });
const gears: Model = {
  body: [{ name: "P" }, { name: "Q" }, { name: "S" }],
  joint: [revolute("A", "P", { coordinate: "alpha" }), revolute("B", "Q"), { name: "B_in", type: "planar", between: ["ground", "S"] }],
  constraint: [
    { name: "mesh", type: "gear", coupled: ["alpha", "B"], ratio: "alpha_count" },
    { name: "cam", type: "equation", equations: ["B_in_1 - sin(alpha)*alpha_dot"] },
    { name: "gone", type: "gear", coupled: ["nobody", "alpha"], ratio: "1" },
  ],
};

const wire = (source: string, target: string, names: string[], roots = names): ServedWire => ({ source, target, names, roots });
const wires = [
  wire("/joint/0", "/constraint/0", ["alpha"]), wire("/joint/1", "/constraint/0", ["B"]), wire("/joint/2", "/constraint/1", ["B_in_1"]),
  wire("/joint/0", "/constraint/1", ["alpha", "alpha_dot"], ["alpha", "alpha"]), wire("/joint/0", "/constraint/2", ["alpha"]),
]; // prettier-ignore

describe("couplings", () => {
  keepWires(gears, wires);
  const graph = diagramOf(gears);

  it("lead to the joints whose coordinates they contain, named or not", () => {
    expect(graph.links.map((each) => [each.coupling, each.joint, each.coordinate])).toEqual([
      ["constraint/0", "joint/0", "alpha"], ["constraint/0", "joint/1", "B"],
      ["constraint/1", "joint/2", "B_in_1"], ["constraint/1", "joint/0", "alpha"],
      ["constraint/2", "joint/0", "alpha"],
    ]); // prettier-ignore
    expect(graph.nodes.find((each) => each.name === "cam")?.detail).toBe("B_in_1, alpha");
  });

  it("stand beside all else, in the order of their joints", () => {
    const spots = spotsOf(gears, graph);
    const boxes = graph.nodes.map((node) => ({ kind: node.kind, at: spots.get(node.id)!, ...sizeOf(node) }));
    const couplings = boxes.filter((each) => each.kind === "coupling").sort((one, other) => one.at[0] - other.at[0]);
    const bottom = Math.max(...boxes.filter((each) => each.kind !== "coupling").map((each) => each.at[1] + each.height));
    expect(couplings.every((each) => each.at[1] > bottom)).toBe(true);
    couplings.slice(1).forEach((each, index) => { expect(each.at[0]).toBeGreaterThanOrEqual(couplings[index]!.at[0] + couplings[index]!.width); });
  });
});

describe("a pose that becomes the start", () => {
  it("changes what moved, in the unit of the file", () => {
    const data = withInitial(sliderCrank, { theta: Math.PI / 4, beta: -0.2, s: 1.25 }, { theta: 0.5, beta: -0.2, s: 1.3 });
    expect(data["initial"]).toEqual({ theta: "45 deg", beta: "-12 deg", s: "1.25", theta_dot: "5.0" });
    const held = { ...sliderCrank, initial: { theta: { value: "30 deg", priority: "hold" } } };
    expect(withInitial(held, { theta: Math.PI / 4 }, { theta: 0.5 })["initial"]).toEqual({ theta: { value: "45 deg", priority: "hold" } });
    expect(initialText(1 / 3, "1.0")).toBe("0.333333");
    expect(initialText(Math.PI, undefined)).toBe("3.14159");
  });
});

describe("drafts", () => {
  const draft = (id: string, when: string): { id: string; path: null; name: string; when: string } => ({ id, path: null, name: id, when });

  it("of server and browser are one list, the newest of each document first", () => {
    const merged = mergedDrafts([draft("a", "2026-01-02"), draft("b", "2026-01-01")], [draft("a", "2026-01-03"), draft("b", "2025-12-31"), draft("c", "2026-01-02")]);
    expect(merged.map((each) => [each.id, each.when])).toEqual([["a", "2026-01-03"], ["c", "2026-01-02"], ["b", "2026-01-01"]]);
  });
});
