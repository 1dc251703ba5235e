/** A small drawing of an example's diagram, made from its data. */

import { useEffect, useMemo, useState, type ReactElement } from "react";
import { api } from "../api";
import { diagramOf, type DiagramGraph } from "../model/graph";
import { sizeOf, spotsOf, type Spot } from "../model/layout";
import type { Model } from "../types";

const kept = new Map<string, Model>();

/** Load an example's data once; a card without it has no drawing. */
function useExample(name: string): Model | null {
  const [data, setData] = useState<Model | null>(kept.get(name) ?? null);
  useEffect(() => {
    if (kept.has(name)) return;
    api.open({ example: name }).then((answer) => {
      kept.set(name, answer.data);
      setData(answer.data);
    }, () => undefined);
  }, [name]);
  return data;
}

export function SketchOf({ name }: { readonly name: string }): ReactElement {
  const data = useExample(name);
  return useMemo(() => (data === null ? <svg className="sketch" aria-hidden="true" /> : <Sketch data={data} />), [data]);
}

function Sketch({ data }: { readonly data: Model }): ReactElement {
  const graph = diagramOf(data);
  const spots = spotsOf(data, graph);
  const boxes = graph.nodes.map((node) => ({ node, at: spots.get(node.id)!, size: sizeOf(node) }));
  const left = Math.min(...boxes.map(({ at }) => at[0])) - 20;
  const top = Math.min(...boxes.map(({ at }) => at[1])) - 20;
  const width = Math.max(...boxes.map(({ at, size }) => at[0] + size.width)) - left + 20;
  const height = Math.max(...boxes.map(({ at, size }) => at[1] + size.height)) - top + 20;
  return (
    <svg className="sketch" viewBox={`${left} ${top} ${width} ${height}`} aria-hidden="true">
      {graph.edges.map((edge) => <path key={edge.id} className={edge.section} d={lineOf(edge, graph, spots)} />)}
      {boxes.map(({ node, at, size }) => <rect key={node.id} className={node.kind} x={at[0]} y={at[1]} width={size.width} height={size.height} rx={10} />)}
    </svg>
  );
}

function lineOf(edge: DiagramGraph["edges"][number], graph: DiagramGraph, spots: ReadonlyMap<string, Spot>): string {
  const [start, end] = [edge.source, edge.target].map((id) => {
    const [x, y] = spots.get(id)!;
    const { width, height } = sizeOf(graph.nodes.find((each) => each.id === id)!);
    return [x + width / 2, y + height / 2] as Spot;
  }) as [Spot, Spot];
  const bend = 46 * (edge.lane - (edge.lanes - 1) / 2) * (edge.source > edge.target ? -1 : 1);
  const length = Math.hypot(end[0] - start[0], end[1] - start[1]) || 1;
  const middle = [(start[0] + end[0]) / 2 - (2 * bend * (end[1] - start[1])) / length, (start[1] + end[1]) / 2 + (2 * bend * (end[0] - start[0])) / length];
  return `M${start.join()} Q${middle.join()} ${end.join()}`;
}
