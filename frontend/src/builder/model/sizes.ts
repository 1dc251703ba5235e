/** How large nodes are. */

import { INPUTS } from "./entries";
import type { DiagramNode } from "./graph";
import { GRID, type Size } from "./spots";

/** Return the size that a node is drawn with. */
export function sizeOf(node: DiagramNode): Size {
  if (node.kind === "signal") return signalSize(node);
  const label = Math.max(node.kind === "ground" ? 6 : 2, ...node.frames.map((each) => each.length));
  const detail = node.kind === "coupling" ? 8 * node.detail.length + 40 : 0; // with a frame about each coordinate
  const width = Math.max(node.kind === "coupling" ? 110 : 140, 9 * node.name.length + 30 + 17 * Math.min(label, 14), Math.min(detail, 320));
  // ports may all be on one side
  const height = Math.max(node.kind === "body" ? 70 : 50, 22 * (node.frames.length - 1));
  return { width: 2 * snapped(width / 2), height: 2 * snapped(height / 2) };
}

/** Return the size of a signal; long formulas are shortened. */
function signalSize({ name, section, detail }: DiagramNode): Size {
  const title = 8.6 * name.length + 52;
  if (section === INPUTS) return { width: 2 * snapped(Math.max(70, title) / 2), height: 40 };
  return { width: 2 * snapped(Math.max(110, title, Math.min(7.4 * detail.length + 34, 210)) / 2), height: 60 };
}

export function snapped(value: number): number {
  return GRID * Math.round(value / GRID);
}
