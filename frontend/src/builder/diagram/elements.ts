/** The nodes and edges that the diagram draws. */

import { badgeParts, type End } from "../model/curves";
import { endAt, portsOf } from "../model/port_places";
import type { DiagramEdge, DiagramGraph, DiagramNode } from "../model/graph";
import { entryOfPointer, INPUTS, type EntryId } from "../model/entries";
import { sidesOf, sizeOf, spotsOf } from "../model/layout";
import { isInTree } from "../model/trees";
import type { Model, Problem, Severity, Summary } from "../types";
import { handleOf, type BodyFlowNode, type Coupled, type JointFlowEdge } from "./flow";

const ORDER: readonly Severity[] = ["error", "warning", "note"];

/** Return the worst severity of the problems of each entry. */
export function severities(problems: readonly Problem[]): ReadonlyMap<EntryId, Severity> {
  const worst = new Map<EntryId, Severity>();
  for (const { pointer, severity } of problems) {
    const id = entryOfPointer(pointer);
    if (id === null || severity === "note") continue;
    const before = worst.get(id);
    if (before === undefined || ORDER.indexOf(severity) < ORDER.indexOf(before)) worst.set(id, severity);
  }
  return worst;
}

export interface Marks {
  readonly selection: readonly EntryId[];
  readonly highlighted: readonly EntryId[];
  readonly worst: ReadonlyMap<EntryId, Severity>;
}

export function flowNodes(data: Model, graph: DiagramGraph, { selection, highlighted, worst }: Marks): BodyFlowNode[] {
  const spots = spotsOf(data, graph);
  const sides = sidesOf(data, graph, spots);
  return graph.nodes.map((node) => {
    const [x, y] = spots.get(node.id)!;
    const size = sizeOf(node);
    return {
      id: node.id,
      type: "body",
      position: { x, y },
      width: size.width,
      height: size.height,
      selected: selection.includes(node.id),
      ariaLabel: `${roleOf(node)} ${node.name}${node.kind === "signal" && node.detail !== "" ? `: ${node.detail}` : ""}`,
      data: {
        node, links: graph.links.filter((each) => each.coupling === node.id), ports: portsOf(node, (frame) => sides.get(`${node.id} ${frame}`) ?? "right"),
        severity: worst.get(node.id) ?? null, highlighted: highlighted.includes(node.id),
      }, // prettier-ignore
    };
  });
}

function roleOf({ kind, type, section }: DiagramNode): string {
  if (section === INPUTS) return "input";
  if (kind === "signal") return type === "" ? section : `${type.replaceAll("_", " ")} block`;
  return kind === "coupling" ? type : kind;
}

/** Return where on the screen of the diagram a port is. */
export function endOfPort(node: BodyFlowNode, frame: string): End {
  const { position: { x, y }, width = 0, height = 0 } = node;
  return endAt([x, y], { width, height }, node.data.ports.find((each) => each.frame === frame)!);
}

export function flowEdges(data: Model, graph: DiagramGraph, nodes: readonly BodyFlowNode[], summary: Summary | null, { selection, highlighted, worst }: Marks): JointFlowEdge[] {
  const byId = new Map(nodes.map((each) => [each.id, each]));
  const spots = new Map(nodes.map((each) => [each.id, [each.position.x, each.position.y] as const]));
  const details = new Map(graph.edges.map((edge) => [edge.id, {
    severity: worst.get(edge.id) ?? null,
    rotation: edge.section === "joint" ? isInTree(data, summary, edge.id, "rotation") : null,
    translation: edge.section === "joint" ? isInTree(data, summary, edge.id, "translation") : null,
  }]));
  const couplingsOf = (joint: string): Coupled[] => {
    const ids = [...new Set(graph.links.filter((each) => each.joint === joint).map((each) => each.coupling))];
    return ids.flatMap((id) => graph.nodes.filter((each) => each.id === id).map(({ name, type, section }) => ({ id, name, type, section })));
  };
  const widthOf = (edge: DiagramEdge): number => {
    const { severity, rotation, translation } = details.get(edge.id)!;
    return 44 + 8 * edge.name.length + 26 * couplingsOf(edge.id).length + (severity === null ? 0 : 18) + (rotation === true && translation === true ? 0 : edge.section === "joint" ? 46 : 0);
  };
  const parts = badgeParts(graph, spots, (node, frame) => endOfPort(byId.get(node)!, frame), widthOf);
  return graph.edges.map((edge) => ({
    id: edge.id,
    type: "joint",
    source: edge.source,
    sourceHandle: handleOf(edge.sourceFrame),
    target: edge.target,
    targetHandle: handleOf(edge.targetFrame),
    selected: selection.includes(edge.id),
    reconnectable: true,
    ariaLabel: `${edge.type} ${edge.name}`,
    data: { edge, couplings: couplingsOf(edge.id), highlighted: highlighted.includes(edge.id), part: parts.get(edge.id)!, width: widthOf(edge), ...details.get(edge.id)! },
  }));
}
