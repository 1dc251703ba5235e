/** What pointer and keys do to the diagram. */

import type { Connection, Edge, EdgeChange, FinalConnectionState, Node, NodeChange } from "@xyflow/react";
import type { DragEvent, KeyboardEvent, MouseEvent } from "react";
import { insertElement } from "../commands/insert";
import { entryAt, GROUND, PART, referenceText, type EntryId } from "../model/entries";
import { reconnect } from "../model/edit";
import { diagramOf } from "../model/graph";
import { GRID, snapped, spotsOf, withLayout, type Spot } from "../model/layout";
import { portFor } from "../model/ports";
import { edit, endGesture, say, select, useStore } from "../store";
import { frameOf, handleOf, spotAt, type BodyFlowNode, type JointFlowEdge } from "./flow";

export const DRAGGED = "application/x-symbody-element";

/** Take what the pointer selected in the diagram; edges and nodes are reported apart. */
export function takeSelection(changes: readonly (NodeChange<BodyFlowNode> | EdgeChange<JointFlowEdge>)[]): void {
  const chosen = new Set(useStore.getState().selection);
  let any = false;
  for (const each of changes) {
    if (each.type !== "select") continue;
    any = true;
    if (each.selected) chosen.add(each.id);
    else chosen.delete(each.id);
  }
  if (any) select([...chosen]);
}

function nameOf(id: EntryId): string {
  return id === GROUND ? GROUND : (entryAt(useStore.getState().data, id)?.name ?? "");
}

/** Return the frame of a port; those of parts belong to bodies that begin with the part's prefix. */
function referenceOfPort(id: EntryId, handle: string | null): string {
  const frame = frameOf(handle);
  return id.startsWith(`${PART}/`) ? `${nameOf(id)}_${frame}` : referenceText({ body: nameOf(id), frame });
}

/** Whether joints can lead to a node: to bodies, the ground, and ports of parts. */
function takesJoints(id: EntryId, handle: string | null | undefined): boolean {
  return id === GROUND || id.startsWith("body/") || (id.startsWith(`${PART}/`) && frameOf(handle) !== "");
}

function endsOfConnection({ source, target, sourceHandle, targetHandle }: Connection): [string, string] {
  const [from, to] = [referenceOfPort(source, sourceHandle), referenceOfPort(target, targetHandle)];
  // the ground is where a joint starts
  return target === GROUND ? [to, from] : [from, to];
}

export function isValid({ source, target }: Connection | Edge): boolean {
  return source !== target;
}

let lastPointer: [number, number] = [0, 0];

export function connect(connection: Connection): void {
  const ends = endsOfConnection(connection);
  // the end of the gesture, which comes next, has the place of the pointer
  queueMicrotask(() => { useStore.setState({ popup: { kind: "types", x: lastPointer[0], y: lastPointer[1], ends } }); });
}

function nodeAt(x: number, y: number): EntryId | undefined {
  return document.elementFromPoint(x, y)?.closest<HTMLElement>(".react-flow__node")?.dataset["id"];
}

/** A drop on a body beside its ports joins the nearest one that is free. */
export function endConnection(event: globalThis.MouseEvent | TouchEvent, { isValid: taken, fromNode, fromHandle }: FinalConnectionState): void {
  const point = "changedTouches" in event ? event.changedTouches[0] : event;
  if (point === undefined) return;
  lastPointer = [point.clientX, point.clientY];
  const target = nodeAt(...lastPointer);
  if (taken || fromNode === null || target === undefined) return;
  if (target === fromNode.id) say("A body cannot be connected to itself.");
  else if (!takesJoints(target, null)) say("Joints and forces join bodies. A signal is used by writing its name.");
  else connect({ source: fromNode.id, sourceHandle: fromHandle.id ?? null, target, targetHandle: handleOf(portFor(useStore.getState().data, target, distanceOf(target))) });
}

/** Return how far the ports of a node are from the pointer. */
function distanceOf(id: EntryId): (frame: string) => number {
  const [x, y] = lastPointer;
  return (frame) => {
    const port = document.querySelector(`.react-flow__node[data-id="${id}"] [data-handleid="${CSS.escape(handleOf(frame))}"]`)?.getBoundingClientRect();
    return port === undefined ? 0 : Math.hypot(port.left + port.width / 2 - x, port.top + port.height / 2 - y);
  };
}

export function reconnected(edge: JointFlowEdge, connection: Connection): void {
  if (connection.source === connection.target) return;
  endGesture();
  const [from, to] = [referenceOfPort(connection.source, connection.sourceHandle), referenceOfPort(connection.target, connection.targetHandle)];
  edit((data) => reconnect(data, edge.id, from, to));
}

export function moved(_: unknown, node: Node, all: readonly Node[]): void {
  movedAll(all.length > 0 ? all : [node]);
}

export function movedAll(nodes: readonly Node[]): void {
  endGesture();
  const places = new Map(nodes.map((each) => [each.id, [each.position.x, each.position.y] as Spot]));
  const before = spotsOf(useStore.getState().data, diagramOf(useStore.getState().data));
  if ([...places].every(([id, [x, y]]) => before.get(id)?.[0] === x && before.get(id)?.[1] === y)) return;
  edit((data) => withLayout(data, places));
}

/** Move what is selected by steps of the grid; presses one after the other are one step of the history. */
export function nudge(x: number, y: number): void {
  const { data, selection } = useStore.getState();
  const spots = spotsOf(data, diagramOf(data));
  const places = new Map<EntryId, Spot>();
  for (const id of selection) {
    const spot = spots.get(id);
    if (spot !== undefined) places.set(id, [spot[0] + x, spot[1] + y]);
  }
  if (places.size === 0) return;
  edit((before) => withLayout(before, places), `nudge ${selection.join()}`);
  const [place] = [...places.values()];
  say(`Moved to ${place![0]}, ${place![1]}`);
}

const ARROWS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
};

export function press(event: KeyboardEvent): void {
  const target = event.target as HTMLElement;
  if (target instanceof HTMLInputElement) return;
  const own = target.closest<HTMLElement>(".react-flow__node, .react-flow__edge");
  const id = own?.dataset["id"];
  if (id !== undefined && (event.key === "Enter" || event.key === " ")) {
    event.preventDefault();
    const { selection } = useStore.getState();
    select(event.shiftKey ? [...new Set([...selection, id])] : [id], `${nameOf(id)} selected`);
  }
  nudgeBy(event);
}

function nudgeBy(event: KeyboardEvent): void {
  const arrow = ARROWS[event.key];
  if (arrow === undefined || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  const step = event.altKey ? 1 : event.shiftKey ? 5 * GRID : GRID;
  nudge(arrow[0] * step, arrow[1] * step);
}

export function renameNode(_: unknown, node: Node): void {
  if (node.id !== GROUND) useStore.setState({ renaming: node.id });
}

export function clear(): void {
  select([]);
  useStore.setState({ popup: null, highlighted: [] });
}

export function menu(event: MouseEvent | globalThis.MouseEvent, target: EntryId | null): void {
  event.preventDefault();
  const { selection } = useStore.getState();
  if (target !== null && !selection.includes(target)) select([target]);
  useStore.setState({ popup: { kind: "menu", x: event.clientX, y: event.clientY, target } });
}

export function insertAt(event: MouseEvent): void {
  if (!(event.target as HTMLElement).classList.contains("react-flow__pane")) return;
  const [x, y] = spotAt(event.clientX, event.clientY);
  useStore.setState({ popup: { kind: "insert", x: event.clientX, y: event.clientY, spot: [snapped(x), snapped(y)] } });
}

export function insertInMiddle(): void {
  const area = document.querySelector(".diagram")?.getBoundingClientRect();
  const [x, y] = area === undefined ? [200, 200] : [area.left + area.width / 2 - 150, area.top + Math.min(60, area.height / 4)];
  useStore.setState({ popup: { kind: "insert", x, y, spot: null } });
}

export function dragOver(event: DragEvent): void {
  event.preventDefault();
  event.dataTransfer.dropEffect = "copy";
}

export function drop(event: DragEvent): void {
  const text = event.dataTransfer.getData(DRAGGED);
  if (text === "") return; // a file, which the window takes
  event.preventDefault();
  const [section, type] = text.split("/");
  const [x, y] = spotAt(event.clientX, event.clientY);
  insertElement(section ?? "", type ?? "", [snapped(x - 70), snapped(y - 30)]);
}
