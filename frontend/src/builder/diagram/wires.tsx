/** Wires: from what brings a name to what reads it, with the name; and the lines by which parts are fixed. */

import { ViewportPortal } from "@xyflow/react";
import type { MouseEvent, ReactElement } from "react";
import { pathOf, type Curve } from "../model/curves";
import type { EntryId } from "../model/entries";
import type { Attachment, DiagramGraph } from "../model/graph";
import { arrowHead, labelBox, wireCurve, type Box, type WireEnd } from "../model/wire_paths";
import type { Wire } from "../model/wires";
import { select } from "../store";
import { badgeSpot, borderSpot } from "./coupling_lines";
import { endOfPort } from "./elements";
import type { BodyFlowNode, JointFlowEdge } from "./flow";

interface Props {
  readonly graph: DiagramGraph;
  readonly nodes: readonly BodyFlowNode[];
  readonly edges: readonly JointFlowEdge[];
  readonly selection: readonly string[];
}

const BADGE_HEIGHT = 28;
const LONGEST = 26; // letters of a label
const LETTER = 6.6;

interface DrawnWire {
  readonly wire: Wire;
  readonly from: string;
  readonly to: string;
  readonly curve: Curve;
  readonly label: string;
  readonly box: Box | null;
}

/** Return the boxes of all nodes and badges, by what they are of. */
function boxesOf(nodes: readonly BodyFlowNode[], edges: readonly JointFlowEdge[]): ReadonlyMap<EntryId, WireEnd> {
  const byId = new Map(nodes.map((each) => [each.id, each]));
  const boxes = new Map<EntryId, WireEnd>();
  for (const { id, position, width = 0, height = 0, data } of nodes) {
    boxes.set(id, { middle: [position.x + width / 2, position.y + height / 2], width, height, sided: data.node.kind === "signal" });
  }
  for (const edge of edges) {
    const middle = badgeSpot(edge, byId);
    if (middle !== null) boxes.set(edge.id, { middle, width: edge.data?.width ?? 0, height: BADGE_HEIGHT, sided: false });
  }
  return boxes;
}

/** Return what stands on a wire: names that neither what it comes from says already, nor the name of an output. */
function labelOf(names: readonly string[], from: string): string {
  const others = names.filter((each) => each !== from && !each.includes("."));
  const text = others.length === 0 ? "" : names.join(", ");
  return text.length > LONGEST ? `${text.slice(0, LONGEST - 1)}…` : text;
}

function drawnWires({ graph, nodes, edges }: Props): DrawnWire[] {
  const boxes = boxesOf(nodes, edges);
  const names = new Map([...nodes.map(({ id, data }) => [id, data.node.name] as const), ...edges.map(({ id, data }) => [id, data?.edge.name ?? ""] as const)]);
  const taken: Box[] = [...boxes.values()].map(({ middle: [x, y], width, height }) => ({ x: x - width / 2, y: y - height / 2, width, height }));
  return graph.wires.flatMap((wire) => {
    const [source, target] = [boxes.get(wire.source), boxes.get(wire.target)];
    if (source === undefined || target === undefined) return [];
    const curve = wireCurve(source, target);
    const [from, to] = [names.get(wire.source) ?? "", names.get(wire.target) ?? ""];
    const label = labelOf(wire.names, from);
    const box = label === "" ? null : labelBox(curve, LETTER * label.length + 8, taken);
    if (box !== null) taken.push(box);
    return [{ wire, from, to, curve, label, box }];
  });
}

export function Wires(props: Props): ReactElement | null {
  const { graph, nodes, selection } = props;
  if (graph.wires.length === 0 && graph.attachments.length === 0) return null;
  const wires = drawnWires(props);
  const isMarked = ({ wire }: DrawnWire): boolean => selection.includes(wire.source) || selection.includes(wire.target);
  return (
    <ViewportPortal>
      <svg className="wires" aria-hidden="true">
        <Attachments attachments={graph.attachments} nodes={nodes} />
        {wires.map((each) => <WireLine key={`${each.wire.source} ${each.wire.target}`} drawn={each} marked={isMarked(each)} />)}
        {wires.map((each) => <WireLabel key={`${each.wire.source} ${each.wire.target}`} drawn={each} marked={isMarked(each)} />)}
      </svg>
    </ViewportPortal>
  );
}

function WireLine({ drawn, marked }: { readonly drawn: DrawnWire; readonly marked: boolean }): ReactElement {
  const { wire, from, to, curve } = drawn;
  const path = pathOf(curve);
  const click = (event: MouseEvent): void => {
    event.stopPropagation();
    select([wire.target], `${to} selected, which reads ${wire.names.join(", ")} of ${from}`);
  };
  return (
    <g className={`wire${marked ? " selected" : ""}`} data-testid={`wire-${from}-${to}`}>
      <path d={path} className="wire-line" />
      <polygon points={arrowHead(curve)} />
      <path d={path} className="wire-reach nopan" onClick={click}><title>{`${to} reads ${wire.names.join(", ")}`}</title></path>
    </g>
  );
}

function WireLabel({ drawn, marked }: { readonly drawn: DrawnWire; readonly marked: boolean }): ReactElement | null {
  const { box, label, wire } = drawn;
  if (box === null) return null;
  return (
    <text x={box.x + box.width / 2} y={box.y + box.height / 2 + 4} className={`wire-label${marked ? " selected" : ""}`}>
      {label}<title>{wire.names.join(", ")}</title>
    </text>
  );
}

/** Double lines from parts to the frames where they are fixed. */
function Attachments({ attachments, nodes }: { readonly attachments: readonly Attachment[]; readonly nodes: readonly BodyFlowNode[] }): ReactElement {
  const byId = new Map(nodes.map((each) => [each.id, each]));
  return (
    <>
      {attachments.map(({ part, node, frame }) => {
        const [own, other] = [byId.get(part), byId.get(node)];
        if (other?.data.ports.some((each) => each.frame === frame) !== true || own === undefined) return null;
        const { x, y } = endOfPort(other, frame);
        const [endX, endY] = borderSpot(own, [x, y]);
        return <path key={part} className="attachment" d={`M${x.toFixed(1)},${y.toFixed(1)} L${endX.toFixed(1)},${endY.toFixed(1)}`} data-testid={`attachment-${own.data.node.name}`} />;
      })}
    </>
  );
}
