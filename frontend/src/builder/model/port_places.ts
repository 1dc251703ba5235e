/** Where on its node each port is. */

import type { End } from "./curves";
import type { DiagramNode } from "./graph";
import type { Side, Size, Spot } from "./spots";

export interface Port {
  readonly frame: string;
  readonly side: Side;
  /** Place along its side, from 0 to 1. */
  readonly part: number;
}

/** Return the ports of a node, evenly along their sides. */
export function portsOf(node: DiagramNode, sideOf: (frame: string) => Side): Port[] {
  const counts: Record<Side, number> = { left: 0, right: 0, top: 0, bottom: 0 };
  for (const frame of node.frames) counts[sideOf(frame)] += 1;
  const used: Record<Side, number> = { left: 0, right: 0, top: 0, bottom: 0 };
  return node.frames.map((frame) => {
    const side = sideOf(frame);
    used[side] += 1;
    return { frame, side, part: used[side] / (counts[side] + 1) };
  });
}

/** Return where in the diagram a port is. */
export function endAt([x, y]: Spot, { width, height }: Size, { side, part }: Port): End {
  if (side === "left" || side === "right") return { x: side === "left" ? x : x + width, y: y + part * height, side };
  return { x: x + part * width, y: side === "top" ? y : y + height, side };
}
