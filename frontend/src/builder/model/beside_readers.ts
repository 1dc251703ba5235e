/** Inputs that one joint or force alone reads: beside its badge, so that their wires cross nothing. */

import { badgeParts, curveOf, pointAt, type Curve, type End } from "./curves";
import type { EntryId } from "./entries";
import type { DiagramEdge, DiagramGraph, DiagramNode } from "./graph";
import type { Size, Spot } from "./spots";

const BADGE = 30; // its height
const WIRE = 34; // length of a wire
const ROOM = 14; // between boxes
const POINTS = 24; // of a line, that a box may not lie on
const SHIFTS = [0, -0.6, 0.6, -1.2, 1.2]; // to either side, in widths

interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

function isApart(one: Box, other: Box): boolean {
  return one.x >= other.x + other.width + ROOM || other.x >= one.x + one.width + ROOM || one.y >= other.y + other.height + ROOM || other.y >= one.y + one.height + ROOM;
}

/** Return the signals that nothing but one line of the diagram reads, and that line. */
function loneSignals({ nodes, edges, wires }: DiagramGraph): (readonly [DiagramNode, DiagramEdge])[] {
  return nodes.filter((each) => each.kind === "signal").flatMap((node) => {
    const own = wires.filter((each) => each.source === node.id || each.target === node.id);
    const edge = own.length === 1 && own[0]!.source === node.id ? edges.find((each) => each.id === own[0]!.target) : undefined;
    return edge === undefined ? [] : [[node, edge] as const];
  });
}

/** Return spots of signals above or below the badge of what reads them, where there is room. */
export function spotsBesideReaders(
  graph: DiagramGraph, spots: ReadonlyMap<EntryId, Spot>, sizeOf: (node: DiagramNode) => Size, endOf: (node: EntryId, frame: string) => End,
): ReadonlyMap<EntryId, Spot> { // prettier-ignore
  const lone = loneSignals(graph);
  const beside = new Map<EntryId, Spot>();
  if (lone.length === 0) return beside;
  const placed = graph.nodes.filter((each) => spots.has(each.id));
  const widthOf = (edge: DiagramEdge): number => 90 + 8 * edge.name.length;
  const parts = badgeParts({ ...graph, nodes: placed }, spots, endOf, widthOf);
  const curves = new Map<EntryId, Curve>(graph.edges.map((edge) => [edge.id, curveOf(endOf(edge.source, edge.sourceFrame), endOf(edge.target, edge.targetFrame), edge)]));
  const badges = new Map(graph.edges.map((edge): [EntryId, Box] => {
    const [x, y] = pointAt(curves.get(edge.id)!, parts.get(edge.id)!);
    return [edge.id, { x: x - widthOf(edge) / 2, y: y - BADGE / 2, width: widthOf(edge), height: BADGE }];
  }));
  const taken: Box[] = [...placed.map((node): Box => ({ x: spots.get(node.id)![0], y: spots.get(node.id)![1], ...sizeOf(node) })), ...badges.values()];
  const points = [...curves.values()].flatMap((curve) => Array.from({ length: POINTS + 1 }, (_, k) => pointAt(curve, k / POINTS)));
  const isFree = (box: Box): boolean =>
    taken.every((each) => isApart(box, each)) && points.every(([x, y]) => isApart(box, { x: x + ROOM / 2, y: y + ROOM / 2, width: -ROOM, height: -ROOM }));
  for (const [node, edge] of lone) {
    const badge = badges.get(edge.id)!;
    const { width, height } = sizeOf(node);
    const middle = badge.x + badge.width / 2;
    const places = SHIFTS.flatMap((shift) => [badge.y - WIRE - height, badge.y + BADGE + WIRE].map((y): Box => ({ x: middle + shift * width - width / 2, y, width, height })));
    const box = places.find(isFree);
    if (box === undefined) continue;
    taken.push(box);
    beside.set(node.id, [box.x, box.y]);
  }
  return beside;
}
