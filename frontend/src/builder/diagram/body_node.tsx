/** A body, the ground or a coupling: a box with its frames as ports. */

import { Handle, Position, useUpdateNodeInternals, type NodeProps } from "@xyflow/react";
import { memo, useEffect, type ReactElement } from "react";
import { count } from "../shell/counts";
import { Icon } from "../shell/icons";
import type { CouplingLink } from "../model/couplings";
import { select, useStore } from "../store";
import { handleOf, type BodyFlowNode, type Port } from "./flow";
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
    <div className={`body-node ${node.kind}${state}`} data-testid={`node-${node.name}`}>
      {ports.map((port) => <PortHandle key={port.frame} body={node.name} port={port} ground={node.kind === "ground"} />)}
      <div className="body-name">
        {node.kind === "coupling" && <Icon name={node.type} fallback={node.section} size={15} />}
        {renaming ? <NameEditor id={id} name={node.name} /> : <strong>{node.name}</strong>}
      </div>
      <Detail node={node} links={links} />
      {severity !== null && <span className={`node-flag ${severity}`} title={severity}><Icon name={severity} size={14} /></span>}
    </div>
  );
});

function Detail({ node, links }: Pick<BodyFlowNode["data"], "node" | "links">): ReactElement | null {
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
