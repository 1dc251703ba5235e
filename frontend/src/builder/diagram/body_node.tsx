/** A body, the ground, a part, a coupling or a signal: a box, with its frames as ports. */

import { Handle, Position, useUpdateNodeInternals, type NodeProps } from "@xyflow/react";
import { memo, useEffect, type ReactElement } from "react";
import { count } from "../shell/counts";
import { Icon } from "../shell/icons";
import { INPUTS } from "../model/entries";
import type { CouplingLink } from "../model/couplings";
import { select, useStore } from "../store";
import type { Port } from "../model/port_places";
import { handleOf, type BodyFlowNode } from "./flow";
import { NameEditor } from "./name_editor";

const POSITIONS: Readonly<Record<Port["side"], Position>> = {
  left: Position.Left, right: Position.Right, top: Position.Top, bottom: Position.Bottom,
};

export const BodyNode = memo(function BodyNode({ id, data, selected }: NodeProps<BodyFlowNode>): ReactElement {
  const { node, links, ports, severity, highlighted } = data;
  useEffect(() => { count("node"); });
  const update = useUpdateNodeInternals();
  const arrangement = ports.map(({ frame, side, part }) => `${frame}${side}${part.toFixed(3)}`).join();
  useEffect(() => { update(id); }, [id, update, arrangement]);
  const renaming = useStore((state) => state.renaming === id);
  const glowing = useStore(({ glowing: ids }) => ids.includes(id));
  const state = `${selected ? " selected" : ""}${highlighted ? " highlighted" : glowing ? " glowing" : ""}${severity === null ? "" : ` ${severity}`}`;
  return (
    <div className={`body-node ${node.kind} ${node.section}${state}`} data-testid={`${node.section === INPUTS ? "input" : "node"}-${node.name}`}>
      {node.kind === "signal" && <SignalPorts section={node.section} />}
      {ports.map((port) => <PortHandle key={port.frame} body={node.name} port={port} ground={node.kind === "ground"} />)}
      <div className="body-name">
        {!["body", "ground"].includes(node.kind) && <Icon name={node.type} fallback={node.section} size={15} />}
        {renaming ? <NameEditor id={id} name={node.name} /> : <strong>{node.name}</strong>}
      </div>
      <Detail node={node} links={links} />
      {severity !== null && <span className={`node-flag ${severity}`} title={severity}><Icon name={severity} size={14} /></span>}
    </div>
  );
});

/** Where wires arrive and leave; signals are joined by writing names, not by drawing. */
function SignalPorts({ section }: { section: string }): ReactElement {
  return <>{section !== INPUTS && <i className="signal-port in" />}<i className="signal-port out" /></>;
}

/** What a signal stands for; long formulas are shortened, the whole is their title. */
function SignalDetail({ node }: Pick<BodyFlowNode["data"], "node">): ReactElement | null {
  const title = useStore((state) => state.schema?.elements.find((each) => each.section === node.section && each.type === node.type)?.title ?? "");
  if (node.section === INPUTS) return null;
  const text = node.section === "block" ? `${title}${node.detail === "" ? "" : ` of ${node.detail}`}` : node.detail;
  return <div className="body-detail" title={text}>{text}</div>;
}

function Detail({ node, links }: Pick<BodyFlowNode["data"], "node" | "links">): ReactElement | null {
  if (node.kind === "signal") return <SignalDetail node={node} />;
  if (links.length > 0) return <LinkedJoints links={links} />;
  return node.detail === "" ? null : <div className="body-detail">{node.kind === "body" ? <>mass {node.detail}</> : node.detail}</div>;
}

/** The coordinates that are coupled, each a way to its joint. */
function LinkedJoints({ links }: { links: readonly CouplingLink[] }): ReactElement {
  return (
    <div className="linked-joints nodrag">
      {links.map(({ joint, coordinate }) => (
        <button key={coordinate} type="button" title={`To the joint of ${coordinate}`} onClick={(event) => { event.stopPropagation(); select([joint], `Joint of ${coordinate} selected`); }}>{coordinate}</button>
      ))}
    </div>
  );
}

function PortHandle({ body, port, ground }: { body: string; port: Port; ground: boolean }): ReactElement {
  const { frame, side, part } = port;
  const across = side === "left" || side === "right";
  const place = { [across ? "top" : "left"]: `${(100 * part).toFixed(2)}%` };
  const own = frame === "";
  const label = own ? (ground ? "origin" : "cm") : frame;
  const title = own ? (ground ? "Axes of the ground" : `${body}: axes at the centre of mass`) : `Frame ${body}.${frame}`;
  return (
    <>
      <Handle
        type="source" id={handleOf(frame)} position={POSITIONS[side]} style={place} title={`${title}. Drag to another body.`}
        className={`port${own ? " own" : ""}`} data-testid={`port-${own ? body : `${body}.${frame}`}`}
      />
      <span className={`port-label ${side}${own ? " own" : ""}`} style={place}>{label}</span>
    </>
  );
}
