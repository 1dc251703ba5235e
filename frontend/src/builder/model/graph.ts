/** The diagram of a model: bodies as nodes, what joins their frames as edges. */

import { couplingLinks, type CouplingLink } from "./couplings";
import { endsOf, entriesOf, framesOf, GROUND, referenceOf, textOf, type EntryId } from "./entries";
import type { JsonObject, Model } from "../types";

export interface DiagramNode {
  readonly id: EntryId;
  readonly kind: "body" | "ground" | "coupling";
  readonly name: string;
  readonly section: string;
  readonly type: string;
  /** Names of frames; the first, "", is the body's own axes at its centre of mass. */
  readonly frames: readonly string[];
  /** What stands under the name. */
  readonly detail: string;
}

export interface DiagramEdge {
  readonly id: EntryId;
  readonly section: string;
  readonly type: string;
  readonly name: string;
  readonly source: EntryId;
  readonly sourceFrame: string;
  readonly target: EntryId;
  readonly targetFrame: string;
  /** Place among the edges of the same two nodes, and how many there are. */
  readonly lane: number;
  readonly lanes: number;
}

export interface DiagramGraph {
  readonly nodes: readonly DiagramNode[];
  readonly edges: readonly DiagramEdge[];
  /** From couplings, which are nodes, to joints, which are edges. */
  readonly links: readonly CouplingLink[];
}

export function diagramOf(data: Model): DiagramGraph {
  const entries = entriesOf(data);
  const owners = new Map<string, EntryId>([[GROUND, GROUND]]);
  for (const each of entries) if (each.section === "body" && !owners.has(each.name)) owners.set(each.name, each.id);
  const frames = new Map<EntryId, readonly string[]>();
  for (const id of owners.values()) frames.set(id, ["", ...framesOf(data, id)]);
  const nodes: DiagramNode[] = [groundNode(frames.get(GROUND)!)];
  const edges: Omit<DiagramEdge, "lane" | "lanes">[] = [];
  for (const { id, section, type, name, value } of entries) {
    if (section === "body") nodes.push(bodyNode(id, name, value, framesOf(data, id)));
    else {
      const ends = joinedEnds(value, owners, frames);
      if (ends === null) nodes.push({ id, kind: "coupling", name, section, type, frames: [], detail: couplingDetail(value) });
      else edges.push({ id, section, type: type === "" ? section : type, name, ...ends });
    }
  }
  const couplings = new Set(nodes.filter((each) => each.kind === "coupling").map((each) => each.id));
  const links = couplingLinks(entries, entries.filter((each) => couplings.has(each.id)), new Set(edges.map((each) => each.id)));
  return { nodes: nodes.map((node) => withLinks(node, links)), edges: inLanes(edges), links };
}

function groundNode(frames: readonly string[]): DiagramNode {
  return { id: GROUND, kind: "ground", name: "Ground", section: GROUND, type: GROUND, frames, detail: "" };
}

function bodyNode(id: EntryId, name: string, value: JsonObject, frames: readonly string[]): DiagramNode {
  return { id, kind: "body", name, section: "body", type: "body", frames: ["", ...frames], detail: textOf(value["mass"]) };
}

/** A coupling whose joints are drawn names their coordinates, once each. */
function withLinks(node: DiagramNode, links: readonly CouplingLink[]): DiagramNode {
  const own = links.filter((each) => each.coupling === node.id);
  return own.length === 0 ? node : { ...node, detail: own.map((each) => each.coordinate).join(", ") };
}

function couplingDetail(value: JsonObject): string {
  const coupled = value["coupled"];
  return Array.isArray(coupled) ? coupled.map((each) => textOf(each as string)).filter((each) => each !== "").join(", ") : "";
}

type Ends = Pick<DiagramEdge, "source" | "sourceFrame" | "target" | "targetFrame">;

/** Return the nodes and frames that an entry joins, or null where it joins none or one is missing. */
function joinedEnds(value: JsonObject, owners: ReadonlyMap<string, EntryId>, frames: ReadonlyMap<EntryId, readonly string[]>): Ends | null {
  const ends = endsOf(value);
  if (ends === null) return null;
  const [start, end] = ends.map(referenceOf);
  const source = owners.get(start!.body);
  const target = owners.get(end!.body);
  if (source === undefined || target === undefined) return null;
  const within = frames.get(source)!.includes(start!.frame) && frames.get(target)!.includes(end!.frame);
  return within ? { source, sourceFrame: start!.frame, target, targetFrame: end!.frame } : null;
}

function inLanes(edges: readonly Omit<DiagramEdge, "lane" | "lanes">[]): DiagramEdge[] {
  const groups = new Map<string, number>();
  const keyOf = (edge: Ends): string => [edge.source, edge.target].sort().join(" ");
  const lanes = edges.map((edge) => {
    const lane = groups.get(keyOf(edge)) ?? 0;
    groups.set(keyOf(edge), lane + 1);
    return lane;
  });
  return edges.map((edge, index) => ({ ...edge, lane: lanes[index]!, lanes: groups.get(keyOf(edge))! }));
}

/** Return what the arrangement of a diagram depends on, as a text. */
export function topologyOf({ nodes, edges, links }: DiagramGraph): string {
  const points = nodes.map((each) => `${each.id}:${each.name}:${each.frames.join(",")}`);
  const coupled = links.map((each) => `${each.coupling}~${each.joint}`);
  return [...points, ...edges.map((each) => `${each.source}-${each.target}`), ...coupled].join(";");
}
