/** Where the nodes of a diagram are, and on which sides of them their ports. */

import { Graph, layout as arrange } from "@dagrejs/dagre";
import { diagramOf, topologyOf, type DiagramGraph, type DiagramNode } from "./graph";
import { GROUND, layoutNameOf, referenceText } from "./entries";
import { spotsBesideReaders } from "./beside_readers";
import { endAt, portsOf } from "./port_places";
import { arrangedSignals } from "./signal_layout";
import { isArray, isObject, valueAt, withValue } from "./pointers";
import { GRID, SIDES, type Side, type Size, type Spot } from "./spots";
import { sizeOf, snapped } from "./sizes";
import type { Json, Model } from "../types";

export { GRID, SIDES, sizeOf, snapped };
export type { Side, Size, Spot };

/** Return the name under which the layout of a file keeps a node. */
export function layoutName(node: DiagramNode): string {
  return layoutNameOf(node.id, node.name);
}

const AROUND: readonly Spot[] = [[1, 0], [0, 1], [1, 1], [0, -1], [1, -1], [-1, 0], [-1, 1], [-1, -1]];

let lastTopology = "";
let lastSpots: ReadonlyMap<string, Spot> = new Map();

/** Arrange anew what is asked for next, by the wires as they are then. */
export function forgetArrangement(): void {
  lastTopology = "";
}

/** Return an arrangement without overlap; the same for the same bodies and connections. */
export function automaticSpots(graph: DiagramGraph): ReadonlyMap<string, Spot> {
  const topology = topologyOf(graph);
  if (topology !== lastTopology) {
    lastSpots = arranged(graph);
    lastTopology = topology;
  }
  return lastSpots;
}

function arranged(graph: DiagramGraph): ReadonlyMap<string, Spot> {
  // joints that close loops say so on their badges
  const loops = graph.edges.length >= graph.nodes.length;
  const longest = Math.max(0, ...graph.edges.map((each) => (loops ? 90 : 44) + 8 * each.name.length));
  const plan = new Graph({ multigraph: true });
  plan.setGraph({ rankdir: "LR", nodesep: 70, ranksep: Math.max(130, 70 + longest), edgesep: 30, marginx: 40, marginy: 40 });
  plan.setDefaultEdgeLabel(() => ({}));
  const mechanical = graph.nodes.filter((each) => each.kind !== "coupling" && each.kind !== "signal");
  for (const node of mechanical) plan.setNode(node.id, { ...sizeOf(node) });
  const order = distances(graph);
  graph.edges.forEach(({ source, target }, index) => {
    if (source === target) return;
    // away from the ground, so that chains run from left to right
    const forward = (order.get(source) ?? 0) <= (order.get(target) ?? 0);
    plan.setEdge(forward ? source : target, forward ? target : source, {}, String(index));
  });
  graph.attachments.forEach(({ node, part }, index) => plan.setEdge(node, part, {}, `part ${index}`));
  arrange(plan);
  const spots = new Map<string, Spot>();
  let bottom = 0;
  for (const node of mechanical) {
    const { x, y } = plan.node(node.id) as unknown as { x: number; y: number };
    const { width, height } = sizeOf(node);
    spots.set(node.id, [snapped(x - width / 2), snapped(y - height / 2)]);
    bottom = Math.max(bottom, y + height / 2);
  }
  const couplings = graph.nodes.filter((each) => each.kind === "coupling");
  placeCouplings(graph, spots, bottom + 60);
  const below = couplings.length === 0 ? bottom : bottom + 60 + Math.max(...couplings.map((each) => sizeOf(each).height));
  const right = Math.max(0, ...mechanical.map((each) => spots.get(each.id)![0] + sizeOf(each).width));
  const beside = besideReaders(graph, spots);
  const others = { ...graph, nodes: graph.nodes.filter((each) => !beside.has(each.id)) };
  const signals = arrangedSignals(others, sizeOf, (id) => middleAt(graph, spots, id), right);
  for (const [id, [x, y]] of beside) spots.set(id, [snapped(x), snapped(y)]);
  for (const [id, [x, y]] of signals) spots.set(id, [snapped(x), snapped(y + below + 80)]);
  return spots;
}

function besideReaders(graph: DiagramGraph, spots: ReadonlyMap<string, Spot>): ReadonlyMap<string, Spot> {
  const nodes = graph.nodes.filter((each) => spots.has(each.id));
  const sides = sidesOf({}, { ...graph, nodes }, spots);
  const byId = new Map(nodes.map((node) => [node.id, { node, ports: portsOf(node, (frame) => sides.get(`${node.id} ${frame}`)!) }]));
  return spotsBesideReaders(graph, spots, sizeOf, (id, frame) => {
    const { node, ports } = byId.get(id)!;
    return endAt(spots.get(id)!, sizeOf(node), ports.find((each) => each.frame === frame)!);
  });
}

/** Return how far right the middle of a node, or of what joins two nodes, is; null before it has a place. */
function middleAt({ nodes, edges }: DiagramGraph, spots: ReadonlyMap<string, Spot>, id: string): number | null {
  const ends = edges.filter((each) => each.id === id).flatMap(({ source, target }) => [source, target]);
  const middles = nodes.filter((each) => (ends.length > 0 ? ends.includes(each.id) : each.id === id) && spots.has(each.id)).map((node) => spots.get(node.id)![0] + sizeOf(node).width / 2);
  return middles.length === 0 ? null : middles.reduce((sum, each) => sum + each, 0) / middles.length;
}

/** Set couplings in a row below everything else, each as near as can be to the joints that it couples. */
function placeCouplings(graph: DiagramGraph, spots: Map<string, Spot>, top: number): void {
  const sizes = new Map(graph.nodes.map((node) => [node.id, sizeOf(node)]));
  const middleOf = (id: string): number => (spots.get(id)?.[0] ?? 0) + (sizes.get(id)?.width ?? 0) / 2;
  const wanted = graph.nodes.filter((node) => node.kind === "coupling").map((node) => {
    const joints = graph.links.filter((each) => each.coupling === node.id).map((each) => each.joint);
    const middles = graph.edges.filter((each) => joints.includes(each.id)).map(({ source, target }) => (middleOf(source) + middleOf(target)) / 2);
    const middle = middles.length === 0 ? Infinity : middles.reduce((sum, each) => sum + each, 0) / middles.length;
    return { id: node.id, width: sizeOf(node).width, middle };
  });
  let left = 40;
  for (const { id, width, middle } of wanted.sort((one, other) => one.middle - other.middle)) {
    const at = Number.isFinite(middle) ? Math.max(left, middle - width / 2) : left;
    spots.set(id, [snapped(at), snapped(top)]);
    left = at + width + 30;
  }
}

/** Return how many connections each node is from the ground. */
function distances(graph: DiagramGraph): Map<string, number> {
  const far = new Map<string, number>([[GROUND, 0]]);
  let front = [GROUND];
  while (front.length > 0) {
    const next: string[] = [];
    const fixed = graph.attachments.map(({ node, part }) => ({ source: node, target: part }));
    for (const { source, target } of [...graph.edges, ...fixed]) {
      for (const [from, to] of [[source, target], [target, source]] as const) {
        if (!front.includes(from) || far.has(to)) continue;
        far.set(to, far.get(from)! + 1);
        next.push(to);
      }
    }
    front = next;
  }
  return far;
}

/** Return where every node is: as the file says, else automatically. */
export function spotsOf(data: Model, graph: DiagramGraph): ReadonlyMap<string, Spot> {
  const kept = valueAt(data, "/layout/nodes");
  const spots = new Map<string, Spot>();
  const open: DiagramNode[] = [];
  for (const node of graph.nodes) {
    const spot = isObject(kept) ? spotFrom(kept[layoutName(node)]) : null;
    if (spot === null) open.push(node);
    else spots.set(node.id, spot);
  }
  if (open.length === 0) return spots;
  const automatic = automaticSpots(graph);
  const beside = spotBelow(graph, spots);
  for (const node of open) {
    const usual = automatic.get(node.id) ?? [40, 40];
    spots.set(node.id, freeSpot(node.kind === "signal" && beside !== null ? beside : usual, node, graph, spots));
  }
  return spots;
}

/** Return a spot below all nodes that have one; null where none has. */
function spotBelow({ nodes }: DiagramGraph, spots: ReadonlyMap<string, Spot>): Spot | null {
  const placed = nodes.filter((each) => spots.has(each.id));
  if (placed.length === 0) return null;
  return [Math.min(...placed.map((each) => spots.get(each.id)![0])), 40 + Math.max(...placed.map((each) => spots.get(each.id)![1] + sizeOf(each).height))];
}

function spotFrom(value: Json | undefined): Spot | null {
  if (!isArray(value) || value.length !== 2) return null;
  const [x, y] = value.map(Number);
  return Number.isFinite(x) && Number.isFinite(y) ? [x!, y!] : null;
}

/** Return the spot nearest to one at which a node overlaps none of the others. */
export function freeSpot(spot: Spot, node: DiagramNode, graph: DiagramGraph, others: ReadonlyMap<string, Spot>): Spot {
  const own = sizeOf(node);
  const overlaps = (x: number, y: number): boolean => graph.nodes.some((each) => {
    const at = others.get(each.id);
    if (at === undefined || each.id === node.id) return false;
    const size = sizeOf(each);
    return x < at[0] + size.width + 20 && at[0] < x + own.width + 20 && y < at[1] + size.height + 20 && at[1] < y + own.height + 20;
  });
  for (let far = 0; ; far += 2 * GRID) {
    for (const [across, down] of AROUND) {
      const place: Spot = [spot[0] + across * far, spot[1] + down * far];
      if (!overlaps(...place)) return place;
    }
  }
}

/** Return data that says where every node is, so that an edit moves none of them. */
export function withLayout(data: Model, moved: ReadonlyMap<string, Spot> = new Map()): Model {
  const graph = diagramOf(data);
  const spots = spotsOf(data, graph);
  const entries = graph.nodes.map((node) => [layoutName(node), [...(moved.get(node.id) ?? spots.get(node.id)!)]] as const);
  return withValue(data, "/layout/nodes", Object.fromEntries(entries));
}

/** Return data without places of nodes: the page arranges them. */
export function withoutLayout(data: Model): Model {
  return withValue(data, "/layout", undefined);
}

/** Return the side of each port, by "id frame": as the file says, else towards what it is joined to. */
export function sidesOf(data: Model, graph: DiagramGraph, spots: ReadonlyMap<string, Spot>): ReadonlyMap<string, Side> {
  const kept = valueAt(data, "/layout/sides");
  const boxes = new Map(graph.nodes.map((node) => [node.id, { at: spots.get(node.id)!, size: sizeOf(node) }]));
  const leads = new Map<string, Leading>();
  for (const { source, sourceFrame, target, targetFrame } of graph.edges) {
    addTowards(leads, `${source} ${sourceFrame}`, boxes.get(source)!, boxes.get(target)!);
    addTowards(leads, `${target} ${targetFrame}`, boxes.get(target)!, boxes.get(source)!);
  }
  const sides = new Map<string, Side>();
  for (const node of graph.nodes) {
    node.frames.forEach((frame, index) => {
      const key = `${node.id} ${frame}`;
      const said = isObject(kept) ? kept[referenceText({ body: layoutName(node), frame })] : undefined;
      const free: Side = node.kind === "ground" ? "right" : frame === "" ? "bottom" : index % 2 === 1 ? "left" : "right";
      sides.set(key, SIDES.find((each) => each === said) ?? sideTowards(leads.get(key)) ?? free);
    });
  }
  return sides;
}

interface Placed {
  readonly at: Spot;
  readonly size: Size;
}

/** Return the room between two intervals, with the sign of the direction; 0 where they overlap. */
function gap(start: number, length: number, other: number, otherLength: number): number {
  return other > start + length ? other - start - length : Math.min(0, other + otherLength - start);
}

/** What the edges of a port lead to: the room on either side, and the sum of that below. */
interface Leading {
  readonly left: number;
  readonly right: number;
  readonly down: number;
}

function addTowards(leads: Map<string, Leading>, key: string, from: Placed, to: Placed): void {
  const { left, right, down } = leads.get(key) ?? { left: 0, right: 0, down: 0 };
  const across = gap(from.at[0], from.size.width, to.at[0], to.size.width);
  const below = gap(from.at[1], from.size.height, to.at[1], to.size.height);
  leads.set(key, { left: left + Math.max(0, -across), right: right + Math.max(0, across), down: down + below });
}

function sideTowards(leading: Leading | undefined): Side | null {
  if (leading === undefined) return null;
  const { left, right, down } = leading;
  // a line to either side leaves in the middle
  if (left > 0 && right > 0) return down < 0 ? "top" : "bottom";
  if (left + right === 0 && down === 0) return null;
  if (left + right >= 0.6 * Math.abs(down)) return right > 0 ? "right" : "left";
  return down > 0 ? "bottom" : "top";
}
