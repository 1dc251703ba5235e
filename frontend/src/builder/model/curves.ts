/** The lines of edges and the places of their badges. */

import type { DiagramEdge, DiagramGraph } from "./graph";
import { sizeOf } from "./sizes";
import type { Side, Spot } from "./spots";

const LANE = 44;

const OUTWARD: Readonly<Record<Side, Spot>> = { left: [-1, 0], right: [1, 0], top: [0, -1], bottom: [0, 1] };

export interface End {
  readonly x: number;
  readonly y: number;
  readonly side: Side;
}

/** The four points of a cubic curve. */
export type Curve = readonly [Spot, Spot, Spot, Spot];

/** Return the line of an edge, set off from the others of the same two nodes. */
export function curveOf(start: End, end: End, { lane, lanes, source, target }: Pick<DiagramEdge, "lane" | "lanes" | "source" | "target">): Curve {
  const [dx, dy] = [end.x - start.x, end.y - start.y];
  const length = Math.hypot(dx, dy) || 1;
  const usual = Math.min(170, Math.max(36, 0.42 * length));
  // lines from above and below bend early, before they run into the next node of the column
  const reachOf = ({ side }: End): number => ((side === "top" || side === "bottom") && Math.abs(dx) > 60 ? Math.min(usual, 48) : usual);
  const [first, second] = [reachOf(start), reachOf(end)];
  const off = (lane - (lanes - 1) / 2) * LANE * (source > target ? -1 : 1) * (4 / 3);
  const [nx, ny] = [(-dy / length) * off, (dx / length) * off];
  const [ax, ay] = OUTWARD[start.side];
  const [bx, by] = OUTWARD[end.side];
  return [
    [start.x, start.y], [start.x + ax * first + nx, start.y + ay * first + ny],
    [end.x + bx * second + nx, end.y + by * second + ny], [end.x, end.y],
  ]; // prettier-ignore
}

export function pathOf([start, first, second, end]: Curve): string {
  return `M${start.join()} C${first.join()} ${second.join()} ${end.join()}`;
}

export function pointAt(curve: Curve, part: number): Spot {
  const rest = 1 - part;
  const weights = [rest ** 3, 3 * rest ** 2 * part, 3 * rest * part ** 2, part ** 3];
  const along = (axis: 0 | 1): number => curve.reduce((sum, point, index) => sum + weights[index]! * point[axis], 0);
  return [along(0), along(1)];
}

interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

function overlap(a: Box, b: Box): number {
  const width = Math.min(a.x + a.width, b.x + b.width) - Math.max(a.x, b.x);
  const height = Math.min(a.y + a.height, b.y + b.height) - Math.max(a.y, b.y);
  return width > 0 && height > 0 ? width * height : 0;
}

const PARTS = [0.5, 0.44, 0.56, 0.38, 0.62, 0.32, 0.68, 0.26, 0.74, 0.2, 0.8, 0.14, 0.86];

/** Return for each edge the part of its line at which its badge covers least of nodes and other badges. */
export function badgeParts(
  graph: DiagramGraph, spots: ReadonlyMap<string, Spot>, endOf: (node: string, frame: string) => End, widthOf: (edge: DiagramEdge) => number,
): ReadonlyMap<string, number> { // prettier-ignore
  const nodes: Box[] = graph.nodes.map((node) => {
    const [x, y] = spots.get(node.id)!;
    const { width, height } = sizeOf(node);
    return { x: x - 8, y: y - 8, width: width + 16, height: height + 16 };
  });
  const chosen = new Map<string, { readonly part: number; readonly box: Box }>();
  // long badges have fewer places; later rounds see where all others went
  const order = [...graph.edges].sort((one, other) => widthOf(other) - widthOf(one));
  for (const edge of [...order, ...order, ...order]) {
    chosen.delete(edge.id);
    const taken = [...nodes, ...[...chosen.values()].map(({ box }) => box)];
    const curve = curveOf(endOf(edge.source, edge.sourceFrame), endOf(edge.target, edge.targetFrame), edge);
    const width = widthOf(edge) + 8;
    const boxes = PARTS.map((part) => {
      const [x, y] = pointAt(curve, part);
      return { part, box: { x: x - width / 2, y: y - 17, width, height: 34 } };
    });
    const costs = boxes.map(({ box }) => taken.reduce((sum, other) => sum + overlap(box, other), 0));
    chosen.set(edge.id, boxes[costs.indexOf(Math.min(...costs))]!);
  }
  return new Map([...chosen].map(([id, { part }]) => [id, part]));
}
