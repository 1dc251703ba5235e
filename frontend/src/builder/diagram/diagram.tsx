/** The diagram: the model as nodes and edges that the pointer and the keyboard change. */

import {
  applyNodeChanges, Background, BackgroundVariant, ConnectionMode, Panel, ReactFlow, SelectionMode, type NodeChange,
} from "@xyflow/react"; // prettier-ignore
import "@xyflow/react/dist/base.css";
import { useEffect, useMemo, useState, type ReactElement } from "react";
import { diagramOf } from "../model/graph";
import { GRID } from "../model/layout";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import { BodyNode } from "./body_node";
import type { CouplingLink } from "../model/couplings";
import { ConnectionLine } from "./connection_line";
import { CouplingLines } from "./coupling_lines";
import { flowEdges, flowNodes, severities } from "./elements";
import { fitDiagram, keepFlow, zoomDiagram, type BodyFlowNode, type JointFlowEdge } from "./flow";
import * as gestures from "./gestures";
import { Guides, useGuides } from "./guides";
import { JointEdge } from "./joint_edge";

const NODE_TYPES = { body: BodyNode };
const EDGE_TYPES = { joint: JointEdge };

/** Return the nodes that are drawn: those of the model, where the pointer has them now. */
function useNodes(): [BodyFlowNode[], JointFlowEdge[], (changes: NodeChange<BodyFlowNode>[]) => void, readonly CouplingLink[]] {
  const data = useStore((state) => state.data);
  const check = useStore((state) => state.check);
  const selection = useStore((state) => state.selection);
  const highlighted = useStore((state) => state.highlighted);
  const graph = useMemo(() => diagramOf(data), [data]);
  const marks = useMemo(() => ({ selection, highlighted, worst: severities(check?.problems ?? []) }), [selection, highlighted, check]);
  const own = useMemo(() => flowNodes(data, graph, marks), [data, graph, marks]);
  const edges = useMemo(() => flowEdges(data, graph, own, check?.summary ?? null, marks), [data, graph, own, check, marks]);
  const [nodes, setNodes] = useState(own);
  useEffect(() => {
    setNodes((before) => {
      const measured = new Map(before.map((each) => [each.id, each.measured]));
      return own.map((each) => {
        const size = measured.get(each.id);
        return size === undefined ? each : { ...each, measured: size };
      });
    });
  }, [own]);
  const change = (changes: NodeChange<BodyFlowNode>[]): void => {
    gestures.takeSelection(changes);
    const others = changes.filter((each) => each.type === "position" || each.type === "dimensions");
    if (others.length > 0) setNodes((before) => applyNodeChanges(others, before));
  };
  return [nodes, edges, change, graph.links];
}

export function Diagram(): ReactElement {
  const [nodes, edges, change, links] = useNodes();
  const selection = useStore((state) => state.selection);
  const free = useAlt();
  const document = useStore((state) => state.document?.id);
  const guides = useGuides(nodes);
  useEffect(() => {
    const wait = setTimeout(fitDiagram, 60); // sizes are measured first
    return () => { clearTimeout(wait); };
  }, [document]);
  return (
    <section className="diagram" aria-label="Diagram" data-testid="diagram" onKeyDown={gestures.press} onDragOver={gestures.dragOver} onDrop={gestures.drop}>
      <ReactFlow<BodyFlowNode, JointFlowEdge>
        nodes={nodes} edges={edges} nodeTypes={NODE_TYPES} edgeTypes={EDGE_TYPES}
        onInit={keepFlow} onNodesChange={change} onEdgesChange={gestures.takeSelection}
        connectionMode={ConnectionMode.Loose} connectionRadius={28} connectionLineComponent={ConnectionLine}
        isValidConnection={gestures.isValid} onConnect={gestures.connect} onConnectEnd={gestures.endConnection}
        onReconnect={gestures.reconnected} reconnectRadius={14}
        onNodeDrag={guides.follow} onNodeDragStop={(...all) => { guides.clear(); gestures.moved(...all); }} onSelectionDragStop={(_, all) => { gestures.movedAll(all); }}
        onNodeDoubleClick={gestures.renameNode} onPaneClick={gestures.clear} onDoubleClick={gestures.insertAt}
        onNodeContextMenu={(event, node) => { gestures.menu(event, node.id); }}
        onEdgeContextMenu={(event, edge) => { gestures.menu(event, edge.id); }} onPaneContextMenu={(event) => { gestures.menu(event, null); }}
        snapToGrid={!free} snapGrid={[GRID, GRID]} selectionMode={SelectionMode.Partial}
        selectionOnDrag panOnDrag={[1, 2]} panOnScroll zoomOnDoubleClick={false} multiSelectionKeyCode={["Shift", "Control", "Meta"]}
        selectionKeyCode={null} deleteKeyCode={null} disableKeyboardA11y minZoom={0.15} maxZoom={2.5} elevateEdgesOnSelect
        nodeDragThreshold={2}
      >
        <Background variant={BackgroundVariant.Dots} gap={2 * GRID} size={1.2} />
        <CouplingLines links={links} nodes={nodes} edges={edges} selection={selection} />
        <Guides lines={guides.lines} />
        <Panel position="bottom-left"><ZoomButtons /></Panel>
      </ReactFlow>
      {nodes.length === 1 && <EmptyHint />}
    </section>
  );
}

function ZoomButtons(): ReactElement {
  return (
    <div className="zoom-buttons" role="group" aria-label="Zoom of the diagram">
      <button type="button" aria-label="Zoom in" title="Zoom in" onClick={() => { zoomDiagram(1.25); }}>+</button>
      <button type="button" aria-label="Zoom out" title="Zoom out" onClick={() => { zoomDiagram(0.8); }}>−</button>
      <button type="button" aria-label="Show all" title="Show all (F)" onClick={fitDiagram}><Icon name="fit" size={15} /></button>
    </div>
  );
}

function EmptyHint(): ReactElement {
  return (
    <div className="empty-hint">
      <p><b>Drag a body here</b>, or press <kbd>/</kbd> and type.</p>
      <p>Then drag from a port to a port: that makes a joint, a spring, a force.</p>
      <button type="button" className="button" onClick={() => { select([]); gestures.insertInMiddle(); }}><Icon name="plus" size={16} /> Add an element</button>
    </div>
  );
}

/** Return whether Alt is held: nodes move freely then. */
function useAlt(): boolean {
  const [held, setHeld] = useState(false);
  useEffect(() => {
    const follow = (event: KeyboardEvent): void => { setHeld(event.altKey); };
    window.addEventListener("keydown", follow);
    window.addEventListener("keyup", follow);
    return () => {
      window.removeEventListener("keydown", follow);
      window.removeEventListener("keyup", follow);
    };
  }, []);
  return held;
}
