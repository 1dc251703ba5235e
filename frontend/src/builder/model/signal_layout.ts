/** Where signals are: from what is read to what reads it, left to right, near what they read of the mechanism. */

import { Graph, layout as arrange } from "@dagrejs/dagre";
import type { DiagramGraph, DiagramNode } from "./graph";
import type { Size, Spot } from "./spots";

const LEFT = 40;
const BESIDE = 40;
const BELOW = 30;
const LONG = 3; // how much wider than high the whole is

/** Signals that read each other, arranged from the spot [0, 0]. */
interface Cluster {
  readonly spots: ReadonlyMap<string, Spot>;
  readonly width: number;
  readonly height: number;
  /** Above which it had best be; Infinity where nothing says so. */
  readonly middle: number;
}

/** Return the spots of signals in rows, the first of which begins at 0; `middleOf` is where something of the mechanism is. */
export function arrangedSignals(
  graph: DiagramGraph, sizeOf: (node: DiagramNode) => Size, middleOf: (id: string) => number | null, width: number,
): ReadonlyMap<string, Spot> { // prettier-ignore
  const clusters = clustersOf(graph).map((nodes) => arrangedCluster(graph, nodes, sizeOf, middleOf));
  const area = clusters.reduce((sum, each) => sum + (each.width + BESIDE) * (each.height + BELOW), 0);
  const widest = Math.max(width, Math.sqrt(LONG * area), ...clusters.map((each) => each.width));
  const spots = new Map<string, Spot>();
  let top = 0;
  for (const row of rowsOf(clusters.sort((one, other) => one.middle - other.middle), widest)) {
    let left = LEFT + startOf(row, widest);
    for (const cluster of row) {
      for (const [id, [x, y]] of cluster.spots) spots.set(id, [left + x, top + y]);
      left += cluster.width + BESIDE;
    }
    top += Math.max(...row.map((each) => each.height)) + BELOW;
  }
  return spots;
}

function widthOf(row: readonly Cluster[]): number {
  return row.reduce((sum, each) => sum + each.width, BESIDE * (row.length - 1));
}

/** Return clusters in rows that are not wider than can be helped. */
function rowsOf(clusters: readonly Cluster[], widest: number): Cluster[][] {
  const rows: Cluster[][] = [];
  for (const cluster of clusters) {
    const last = rows.at(-1);
    if (last !== undefined && widthOf([...last, cluster]) <= widest) last.push(cluster);
    else rows.push([cluster]);
  }
  return rows;
}

/** Return where a row begins, so that it is below what it is joined to. */
function startOf(row: readonly Cluster[], widest: number): number {
  const middles = row.map((each) => each.middle).filter(Number.isFinite);
  if (middles.length === 0) return 0;
  const middle = middles.reduce((sum, each) => sum + each, 0) / middles.length;
  return Math.max(0, Math.min(middle - LEFT - widthOf(row) / 2, widest - widthOf(row)));
}

/** Return the signals in groups that wires join. */
function clustersOf({ nodes, wires }: DiagramGraph): DiagramNode[][] {
  const signals = nodes.filter((each) => each.kind === "signal");
  const group = new Map(signals.map(({ id }) => [id, id]));
  for (const { source, target } of wires) {
    const [from, to] = [group.get(source), group.get(target)];
    if (from === undefined || to === undefined || from === to) continue;
    for (const [id, each] of group) if (each === to) group.set(id, from);
  }
  return [...new Set(group.values())].map((own) => signals.filter(({ id }) => group.get(id) === own));
}

function arrangedCluster(graph: DiagramGraph, nodes: readonly DiagramNode[], sizeOf: (node: DiagramNode) => Size, middleOf: (id: string) => number | null): Cluster {
  const plan = new Graph();
  plan.setGraph({ rankdir: "LR", nodesep: 26, ranksep: 80 });
  plan.setDefaultEdgeLabel(() => ({}));
  for (const node of nodes) plan.setNode(node.id, { ...sizeOf(node) });
  const own = new Set(nodes.map((each) => each.id));
  for (const { source, target } of graph.wires) if (own.has(source) && own.has(target)) plan.setEdge(source, target);
  arrange(plan);
  const spots = new Map(nodes.map((node): [string, Spot] => {
    const { x, y } = plan.node(node.id) as unknown as { x: number; y: number };
    const { width, height } = sizeOf(node);
    return [node.id, [x - width / 2, y - height / 2]];
  }));
  const { width = 0, height = 0 } = plan.graph() as { width?: number; height?: number };
  const outside = graph.wires.flatMap(({ source, target }) => (own.has(target) && !own.has(source) ? [source] : own.has(source) && !own.has(target) ? [target] : []));
  const middles = outside.map(middleOf).filter((each) => each !== null);
  return { spots, width, height, middle: middles.length === 0 ? Infinity : middles.reduce((sum, each) => sum + each, 0) / middles.length };
}
