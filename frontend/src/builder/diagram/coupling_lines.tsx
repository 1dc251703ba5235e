/** Lines from couplings, such as gears, to the joints whose coordinates they couple. */

import { ViewportPortal } from "@xyflow/react";
import type { MouseEvent, ReactElement } from "react";
import { curveOf, pointAt } from "../model/curves";
import type { CouplingLink } from "../model/couplings";
import type { Spot } from "../model/layout";
import { select } from "../store";
import { endOfPort } from "./elements";
import type { BodyFlowNode, JointFlowEdge } from "./flow";

interface Props {
  readonly links: readonly CouplingLink[];
  readonly nodes: readonly BodyFlowNode[];
  readonly edges: readonly JointFlowEdge[];
  readonly selection: readonly string[];
}

/** Return where the badge of a joint is now. */
export function badgeSpot(edge: JointFlowEdge, nodes: ReadonlyMap<string, BodyFlowNode>): Spot | null {
  const [source, target] = [nodes.get(edge.source), nodes.get(edge.target)];
  if (source === undefined || target === undefined || edge.data === undefined) return null;
  const { edge: own, part } = edge.data;
  return pointAt(curveOf(endOfPort(source, own.sourceFrame), endOfPort(target, own.targetFrame), own), part);
}

/** Return where the border of a node lies towards a point. */
export function borderSpot({ position, width = 0, height = 0 }: BodyFlowNode, [x, y]: Spot): Spot {
  const [middleX, middleY] = [position.x + width / 2, position.y + height / 2];
  const [across, down] = [x - middleX, y - middleY];
  const share = Math.min(width / 2 / Math.max(Math.abs(across), 1e-6), height / 2 / Math.max(Math.abs(down), 1e-6), 1);
  return [middleX + share * across, middleY + share * down];
}

/** Return a line that bends to the sides in turn, so that those of one coupling do not lie on each other. */
function bowed([x1, y1]: Spot, [x2, y2]: Spot, place: number): string {
  const side = (place % 2 === 0 ? 1 : -1) * (0.1 + 0.08 * Math.floor(place / 2));
  const [x, y] = [(x1 + x2) / 2 - side * (y2 - y1), (y1 + y2) / 2 + side * (x2 - x1)];
  return `M${x1.toFixed(1)},${y1.toFixed(1)} Q${x.toFixed(1)},${y.toFixed(1)} ${x2.toFixed(1)},${y2.toFixed(1)}`;
}

export function CouplingLines({ links, nodes, edges, selection }: Props): ReactElement | null {
  if (links.length === 0) return null;
  const byId = new Map(nodes.map((each) => [each.id, each]));
  return (
    <ViewportPortal>
      <svg className="coupling-lines" aria-hidden="true">
        {links.map((link, index) => {
          const node = byId.get(link.coupling);
          const edge = edges.find((each) => each.id === link.joint);
          const end = edge === undefined ? null : badgeSpot(edge, byId);
          if (node === undefined || end === null) return null;
          const start = borderSpot(node, end);
          const marked = selection.includes(link.coupling) || selection.includes(link.joint);
          const click = (event: MouseEvent): void => {
            event.stopPropagation();
            select([link.coupling], `${node.data.node.name} selected`);
          };
          const path = bowed(start, end, links.slice(0, index).filter((each) => each.coupling === link.coupling).length);
          return (
            <g key={`${link.coupling} ${link.coordinate}`} data-testid={`link-${node.data.node.name}-${edge?.data?.edge.name ?? ""}`}>
              <path d={path} className={`coupling-line${marked ? " selected" : ""}`} />
              <path d={path} className="coupling-reach nopan" onClick={click} />
            </g>
          );
        })}
      </svg>
    </ViewportPortal>
  );
}
