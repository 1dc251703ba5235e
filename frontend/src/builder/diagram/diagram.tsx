/** The diagram: the model as nodes and edges that the pointer and the keyboard change. */

import {
  applyNodeChanges, Background, BackgroundVariant, ConnectionMode, Panel, ReactFlow, SelectionMode, useStore as useFlow, type NodeChange,
} from "@xyflow/react"; // prettier-ignore
import "@xyflow/react/dist/base.css";
import { useCallback, useEffect, useMemo, useState, type MouseEvent as ReactMouseEvent, type ReactElement } from "react";
import { useStoreWithEqualityFn } from "zustand/traditional";
import { diagramOf, type DiagramGraph } from "../model/graph";
import { GRID } from "../model/layout";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import { BodyNode } from "./body_node";
import { ConnectionLine } from "./connection_line";
import { CouplingLines } from "./coupling_lines";
import { flowEdges, flowNodes, severities } from "./elements";
import { fitDiagram, fitWhenDrawn, followWindow, keepFlow, noteMove, zoomDiagram, type BodyFlowNode, type JointFlowEdge } from "./flow";
import * as gestures from "./gestures";
import { isEqual, isSameDrawing, kept, useKept } from "./kept";
import { Guides, useGuides } from "./guides";
import { JointEdge } from "./joint_edge";
import { Wires } from "./wires";
import type { Problem } from "../types";

const NODE_TYPES = { body: BodyNode };
const EDGE_TYPES = { joint: JointEdge };
const NO_PROBLEMS: readonly Problem[] = [];
// Properties of the diagram that stay the same objects: others would have every node drawn anew.
const SNAP: [number, number] = [GRID, GRID];
const PAN_BUTTONS = [1, 2];
const MORE_KEYS = ["Shift", "Control", "Meta"];
const nodeMenu = (event: MouseEvent | ReactMouseEvent, node: BodyFlowNode): void => { gestures.menu(event, node.id); };
const edgeMenu = (event: MouseEvent | ReactMouseEvent, edge: JointFlowEdge): void => { gestures.menu(event, edge.id); };
const paneMenu = (event: MouseEvent | ReactMouseEvent): void => { gestures.menu(event, null); };
const movedAll = (_: unknown, all: BodyFlowNode[]): void => { gestures.movedAll(all); };

/** Return the nodes that are drawn: those of the model, where the pointer has them now. */
function useNodes(): [BodyFlowNode[], JointFlowEdge[], (changes: NodeChange<BodyFlowNode>[]) => void, DiagramGraph] {
  const data = useStoreWithEqualityFn(useStore, (state) => state.data, isSameDrawing);
  const problems = useStoreWithEqualityFn(useStore, (state) => state.check?.problems ?? NO_PROBLEMS, isEqual);
  const summary = useStoreWithEqualityFn(useStore, (state) => state.check?.summary ?? null, isEqual);
  const selection = useStore((state) => state.selection);
  const highlighted = useStore((state) => state.highlighted);
  const wires = useStoreWithEqualityFn(useStore, (state) => state.check?.wires ?? null, isEqual);
  // the diagram has the wires that the last check brought
  const graph = useMemo(() => diagramOf(data), [data, wires]);
  const marks = useMemo(() => ({ selection, highlighted, worst: severities(problems) }), [selection, highlighted, problems]);
  const own = useKept(useMemo(() => flowNodes(data, graph, marks), [data, graph, marks]));
  const edges = useKept(useMemo(() => flowEdges(data, graph, own, summary, marks), [data, graph, own, summary, marks]));
  const [nodes, setNodes] = useState(own);
  useEffect(() => {
    setNodes((before) => {
      const measured = new Map(before.map((each) => [each.id, each.measured]));
      return kept(before, own.map((each) => {
        const size = measured.get(each.id);
        return size === undefined ? each : { ...each, measured: size };
      }));
    });
  }, [own]);
  const change = useCallback((changes: NodeChange<BodyFlowNode>[]): void => {
    gestures.takeSelection(changes);
    const others = changes.filter((each) => each.type === "position" || each.type === "dimensions");
    if (others.length > 0) setNodes((before) => applyNodeChanges(others, before));
  }, []);
  return [nodes, edges, change, graph];
}

export function Diagram(): ReactElement {
  const [nodes, edges, change, graph] = useNodes();
  const selection = useStore((state) => state.selection);
  const free = useAlt();
  const document = useStore((state) => state.document?.id);
  const guides = useGuides(nodes, gestures.moved);
  useEffect(followWindow, []);
  useEffect(() => fitWhenDrawn(() => diagramOf(useStore.getState().data).nodes.length), [document]);
  return (
    <section className="diagram" aria-label="Diagram" data-testid="diagram" onKeyDown={gestures.press} onDragOver={gestures.dragOver} onDrop={gestures.drop}>
      <ReactFlow<BodyFlowNode, JointFlowEdge>
        nodes={nodes} edges={edges} nodeTypes={NODE_TYPES} edgeTypes={EDGE_TYPES}
        onInit={keepFlow} onMoveEnd={noteMove} onNodesChange={change} onEdgesChange={gestures.takeSelection}
        connectionMode={ConnectionMode.Loose} connectionRadius={28} connectionLineComponent={ConnectionLine}
        isValidConnection={gestures.isValid} onConnect={gestures.connect} onConnectEnd={gestures.endConnection}
        onReconnect={gestures.reconnected} reconnectRadius={14}
        onNodeDrag={guides.follow} onNodeDragStop={guides.stop} onSelectionDragStop={movedAll}
        onNodeDoubleClick={gestures.renameNode} onPaneClick={gestures.clear} onDoubleClick={gestures.insertAt}
        onNodeContextMenu={nodeMenu} onEdgeContextMenu={edgeMenu} onPaneContextMenu={paneMenu}
        snapToGrid={!free} snapGrid={SNAP} selectionMode={SelectionMode.Partial}
        selectionOnDrag panOnDrag={PAN_BUTTONS} panOnScroll zoomOnDoubleClick={false} multiSelectionKeyCode={MORE_KEYS}
        selectionKeyCode={null} deleteKeyCode={null} disableKeyboardA11y minZoom={0.03} maxZoom={2.5} elevateEdgesOnSelect
        nodeDragThreshold={2}
      >
        <Background variant={BackgroundVariant.Dots} gap={2 * GRID} size={1.2} />
        <Wires graph={graph} nodes={nodes} edges={edges} selection={selection} />
        <CouplingLines links={graph.links} nodes={nodes} edges={edges} selection={selection} />
        <Guides lines={guides.lines} />
        <Panel position="bottom-left"><ZoomButtons /></Panel>
        <Legibility />
      </ReactFlow>
      {nodes.length === 1 && <EmptyHint />}
    </section>
  );
}

const FAR = 0.6; // scale below which frames, masses and icons could not be read
const LEAST_NAME = 9.5 / 13; // of the height of a name at scale 1
const MOST_NAME = 1.7;

/** From afar names alone are shown, larger than drawn to scale. */
function Legibility(): null {
  const scale = useFlow(({ transform }) => (transform[2] >= FAR ? 1 : Math.round(20 * transform[2]) / 20));
  useEffect(() => {
    const { classList, style } = document.querySelector<HTMLElement>(".diagram")!;
    classList.toggle("far", scale < FAR);
    style.setProperty("--name-scale", String(scale < FAR ? Math.min(MOST_NAME, LEAST_NAME / scale) : 1));
  }, [scale]);
  return null;
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
