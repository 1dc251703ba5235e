import { describe, expect, it } from "vitest";
import { flowEdges, flowNodes } from "../../src/builder/diagram/elements";
import { curveOf, pointAt } from "../../src/builder/model/curves";
import { addElement } from "../../src/builder/model/edit";
import { diagramOf } from "../../src/builder/model/graph";
import { automaticSpots, forgetArrangement, sizeOf, spotsOf, withLayout } from "../../src/builder/model/layout";
import { valueAt } from "../../src/builder/model/pointers";
import type { Model } from "../../src/builder/types";
import { elementNamed, schema, sliderCrank, stewart } from "./models";

const NO_MARKS = { selection: [], highlighted: [], worst: new Map() };

function overlapping(data: Model): string[] {
  const graph = diagramOf(data);
  const spots = spotsOf(data, graph);
  const boxes = graph.nodes.map((node) => ({ name: node.name, at: spots.get(node.id)!, size: sizeOf(node) }));
  return boxes.flatMap((one, index) => boxes.slice(0, index).filter((other) =>
    one.at[0] < other.at[0] + other.size.width && other.at[0] < one.at[0] + one.size.width &&
    one.at[1] < other.at[1] + other.size.height && other.at[1] < one.at[1] + one.size.height).map((other) => `${one.name} ${other.name}`));
}

describe("the diagram of a model", () => {
  it("has bodies as nodes, joints as edges between frames", () => {
    const { nodes, edges } = diagramOf(sliderCrank);
    expect(nodes.map((each) => each.name)).toEqual(["Ground", "Crank", "Rod", "Piston", "F"]);
    expect(edges.map((each) => [each.name, each.source, each.sourceFrame, each.target, each.targetFrame])).toEqual([
      ["A", "ground", "", "body/0", "A"], ["B", "body/0", "B", "body/1", "B"], ["C", "body/2", "", "body/1", "C"], ["D", "ground", "", "body/2", ""],
    ]); // prettier-ignore
  });

  it("is arranged without overlap, of any size", () => {
    expect(overlapping(sliderCrank)).toEqual([]);
    expect(overlapping(stewart)).toEqual([]);
    let chain: Model = {};
    for (let body = 0; body < 100; body += 1) chain = addElement(schema, chain, elementNamed("body"), null, [40, 40]).data;
    expect(overlapping(chain)).toEqual([]);
  });

  it("has inputs of one reader beside it, not in rows below everything", () => {
    const graph = diagramOf(sliderCrank);
    const wires = graph.edges.filter((each) => each.name === "D").map((each) => ({ source: graph.nodes.at(-1)!.id, target: each.id, names: ["F"], roots: ["F"] }));
    forgetArrangement();
    const spots = automaticSpots({ ...graph, wires });
    const input = spots.get(graph.nodes.at(-1)!.id)!;
    const lowest = Math.max(...graph.nodes.slice(0, -1).map((each) => spots.get(each.id)![1] + sizeOf(each).height));
    expect(input[1]).toBeLessThan(lowest + 80); // where rows of signals begin
    forgetArrangement();
  });

  it("keeps all nodes where they are once one was placed", () => {
    const before = spotsOf(sliderCrank, diagramOf(sliderCrank));
    const placed = withLayout(sliderCrank, new Map([["body/0", [5, 6]]]));
    expect(valueAt(placed, "/layout/nodes/Crank")).toEqual([5, 6]);
    expect(valueAt(placed, "/layout/nodes/Rod")).toEqual(before.get("body/1"));
  });

  it("sets parallel edges apart, and their badges", () => {
    let data = sliderCrank;
    for (const name of ["spring", "torsion_spring", "spring"]) data = addElement(schema, data, elementNamed(name), ["ground", "Crank.A"], null).data;
    const graph = diagramOf(data);
    const lanes = graph.edges.filter((each) => each.target === "body/0" && each.source === "ground");
    expect(lanes.map((each) => [each.lane, each.lanes])).toEqual([[0, 4], [1, 4], [2, 4], [3, 4]]);
    const middles = lanes.map((edge) => pointAt(curveOf({ x: 0, y: 0, side: "right" }, { x: 200, y: 0, side: "left" }, edge), 0.5)[1]);
    const sorted = [...middles].sort((a, b) => a - b);
    sorted.slice(1).forEach((each, index) => { expect(each - sorted[index]!).toBeGreaterThan(30); });
    const nodes = flowNodes(data, graph, NO_MARKS);
    expect(flowEdges(data, graph, nodes, null, NO_MARKS)).toHaveLength(graph.edges.length);
  });

  it("shows what joins nothing as a node", () => {
    const { data } = addElement(schema, sliderCrank, elementNamed("gear"), null, null);
    expect(diagramOf(data).nodes.find((each) => each.type === "gear")).toMatchObject({ kind: "coupling", type: "gear" });
    const broken: Model = { ...sliderCrank, body: [] };
    expect(diagramOf(broken).nodes.filter((each) => each.kind === "coupling")).toHaveLength(4);
  });
});
