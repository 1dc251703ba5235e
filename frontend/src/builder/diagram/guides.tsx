/** Lines that show with what a dragged node is aligned. */

import { ViewportPortal, type Node } from "@xyflow/react";
import { useCallback, useEffect, useRef, useState, type ReactElement } from "react";
import type { BodyFlowNode } from "./flow";

export interface GuideLines {
  readonly x: number | null;
  readonly y: number | null;
}

const NONE: GuideLines = { x: null, y: null };

function middleOf(node: Node): [number, number] {
  return [node.position.x + (node.width ?? 0) / 2, node.position.y + (node.height ?? 0) / 2];
}

interface Following {
  readonly lines: GuideLines;
  readonly follow: (event: unknown, node: Node) => void;
  readonly stop: (event: unknown, node: Node, all: Node[]) => void;
}

/** Return guides for a node that is dragged; `moved` hears where it was left. */
export function useGuides(nodes: readonly BodyFlowNode[], moved: (event: unknown, node: Node, all: readonly Node[]) => void): Following {
  const [lines, setLines] = useState(NONE);
  const now = useRef(nodes);
  useEffect(() => { now.current = nodes; }, [nodes]);
  const follow = useCallback((_: unknown, dragged: Node): void => {
    const [x, y] = middleOf(dragged);
    const others = now.current.filter((each) => each.id !== dragged.id).map(middleOf);
    const aligned = { x: others.some((each) => each[0] === x) ? x : null, y: others.some((each) => each[1] === y) ? y : null };
    setLines((before) => (before.x === aligned.x && before.y === aligned.y ? before : aligned));
  }, []);
  const stop = useCallback((event: unknown, node: Node, all: Node[]): void => {
    setLines(NONE);
    moved(event, node, all);
  }, [moved]);
  return { lines, follow, stop };
}

export function Guides({ lines }: { lines: GuideLines }): ReactElement {
  return (
    <ViewportPortal>
      {lines.x !== null && <div className="guide upright" style={{ left: lines.x }} />}
      {lines.y !== null && <div className="guide level" style={{ top: lines.y }} />}
    </ViewportPortal>
  );
}
