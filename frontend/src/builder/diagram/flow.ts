/** The one diagram of the page: what commands need of it. */

import type { Edge, Node, ReactFlowInstance } from "@xyflow/react";
import type { CouplingLink } from "../model/couplings";
import type { EntryId } from "../model/entries";
import type { DiagramEdge, DiagramNode } from "../model/graph";
import type { Port } from "../model/port_places";
import type { Severity } from "../types";

/** A coupling that a joint takes part in. */
export interface Coupled {
  readonly id: EntryId;
  readonly name: string;
  readonly type: string;
  readonly section: string;
}

export type BodyNodeData = {
  readonly node: DiagramNode;
  /** What a coupling couples. */
  readonly links: readonly CouplingLink[];
  readonly ports: readonly Port[];
  readonly severity: Severity | null;
  readonly highlighted: boolean;
};
export type BodyFlowNode = Node<BodyNodeData, "body">;

export type JointEdgeData = {
  readonly edge: DiagramEdge;
  readonly couplings: readonly Coupled[];
  readonly severity: Severity | null;
  readonly highlighted: boolean;
  readonly rotation: boolean | null;
  readonly translation: boolean | null;
  /** Where along the line the badge is, from 0 to 1. */
  readonly part: number;
  /** Of the badge. */
  readonly width: number;
};
export type JointFlowEdge = Edge<JointEdgeData, "joint">;

type Instance = ReactFlowInstance<BodyFlowNode, JointFlowEdge>;

let instance: Instance | null = null;
/** Whether nobody moved the view since the whole diagram was shown. */
let showsAll = false;

export function keepFlow(flow: Instance): void {
  instance = flow;
}

/** The id of a port within its node; empty ids mean no port. */
export function handleOf(frame: string): string {
  return `@${frame}`;
}

export function frameOf(handle: string | null | undefined): string {
  return (handle ?? "@").slice(1);
}

/** Note that a person moved the view; moves by the program have no event. */
export function noteMove(event: unknown): void {
  if (event !== null) showsAll = false;
}

/** Show all again in a window of another size, unless a person moved the view. */
export function followWindow(): () => void {
  const fit = (): void => { if (showsAll) fitDiagram(); };
  window.addEventListener("resize", fit);
  return () => { window.removeEventListener("resize", fit); };
}

export function fitDiagram(): void {
  showsAll = true;
  if (instance?.getNodes().length === 1) {
    const area = document.querySelector(".diagram")?.getBoundingClientRect();
    void instance.setViewport({ x: 20, y: (area?.height ?? 300) / 2 - 70, zoom: 1 });
    return;
  }
  void instance?.fitView({ padding: 0.12, maxZoom: 1, duration: glide() });
}

const FIRST_LOOK = 60; // [ms], in which sizes are measured
const LOOKS = 50;

/** Fit the diagram as soon as the diagram has so many nodes; return what ends the waiting. */
export function fitWhenDrawn(count: () => number): () => void {
  let timer: ReturnType<typeof setTimeout>;
  const look = (left: number): void => {
    timer = setTimeout(() => {
      if (left > 0 && instance?.getNodes().length !== count()) look(left - 1);
      else fitDiagram();
    }, FIRST_LOOK);
  };
  look(LOOKS);
  return () => { clearTimeout(timer); };
}

/** Put the focus onto an element of the diagram, once it is drawn. */
export function focusInDiagram(id: string): void {
  const look = (left: number, before: Element | null): void => {
    if (document.activeElement !== before || before instanceof HTMLInputElement) return; // a person went on meanwhile
    document.querySelector<HTMLElement>(`.react-flow [data-id="${id}"]`)?.focus({ preventScroll: true }); // in vain while it is measured
    if (left > 0) setTimeout(() => { look(left - 1, before); }, FIRST_LOOK / 2);
  };
  setTimeout(() => { look(LOOKS, document.activeElement); });
}

export function showNode(id: string): void {
  const node = instance?.getNode(id);
  if (node === undefined) return;
  const { width = 140, height = 70 } = node.measured ?? {};
  void instance?.setCenter(node.position.x + width / 2, node.position.y + height / 2, { zoom: instance.getZoom(), duration: glide() });
}

/** Show what has just been added, once it is drawn: all, or where a person moved the view the new node. */
export function showNew(id: string): void {
  const look = (left: number): void => {
    setTimeout(() => {
      const isDrawn = instance?.getNode(id)?.measured?.width !== undefined || instance?.getEdge(id) !== undefined;
      if (!isDrawn && left > 0) look(left - 1);
      else if (showsAll) fitDiagram();
      else showNode(id);
    }, FIRST_LOOK);
  };
  look(LOOKS);
}

export function zoomDiagram(factor: number): void {
  void instance?.zoomTo(instance.getZoom() * factor, { duration: glide() });
}

export function spotAt(x: number, y: number): [number, number] {
  const { x: left, y: top } = instance?.screenToFlowPosition({ x, y }) ?? { x: 0, y: 0 };
  return [left, top];
}

function glide(): number {
  return window.matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 160;
}
