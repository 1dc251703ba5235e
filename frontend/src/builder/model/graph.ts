/** The diagram of a model: bodies as nodes, what joins their frames as edges, wires where formulas read names. */

import { splitWires, type CouplingLink } from "./couplings";
import { endsOf, entriesOf, framesOf, GROUND, inputsOf, PART, referenceOf, textOf, type Entry, type EntryId } from "./entries";
import { wiresOf, type Wire } from "./wires";
import type { JsonObject, Model } from "../types";

export interface DiagramNode {
  readonly id: EntryId;
  readonly kind: "body" | "ground" | "coupling" | "signal" | "part";
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

/** Where a part, a file of its own, is fixed. */
export interface Attachment {
  readonly part: EntryId;
  readonly node: EntryId;
  readonly frame: string;
}

export interface DiagramGraph {
  readonly nodes: readonly DiagramNode[];
  readonly edges: readonly DiagramEdge[];
  /** From couplings, which are nodes, to joints, which are edges. */
  readonly links: readonly CouplingLink[];
  /** Between nodes and edges that are drawn. */
  readonly wires: readonly Wire[];
  readonly attachments: readonly Attachment[];
}

/** Sections whose entries are names in formulas. */
export const SIGNALS: readonly string[] = ["table", "signal", "block"];

/** What references lead to: bodies with their frames, and parts, whose bodies begin with their prefix. */
interface Owners {
  readonly bodies: ReadonlyMap<string, EntryId>;
  readonly frames: ReadonlyMap<EntryId, readonly string[]>;
  readonly parts: readonly Entry[];
}

export function diagramOf(data: Model): DiagramGraph {
  const entries = entriesOf(data);
  const owners = ownersOf(data, entries);
  const nodes: DiagramNode[] = [groundNode(owners.frames.get(GROUND)!)];
  const edges: Omit<DiagramEdge, "lane" | "lanes">[] = [];
  for (const entry of entries) {
    const { id, section, type, name, value } = entry;
    const ends = section === "body" || section === PART ? null : joinedEnds(value, owners);
    if (ends === null) nodes.push(nodeOf(data, entry));
    else edges.push({ id, section, type: type === "" ? section : type, name, ...ends });
  }
  const tables = new Set(entries.filter((each) => each.section === "table").map((each) => each.name));
  // a table with the name of an input is its law, and is drawn instead
  for (const input of inputsOf(data)) if (!tables.has(input.name)) nodes.push({ ...emptyNode(input), kind: "signal" });
  const ids = (kind: DiagramNode["kind"]): Set<EntryId> => new Set(nodes.filter((each) => each.kind === kind).map((each) => each.id));
  const drawn = new Set([...nodes.map((each) => each.id), ...edges.map((each) => each.id)]);
  const { links, others } = splitWires(wiresOf(data), ids("coupling"), drawn);
  const wires = others.filter((each) => drawn.has(each.source) && drawn.has(each.target));
  const attachments = owners.parts.flatMap(({ id, value }) => attachmentOf(id, textOf(value["at"] ?? GROUND), owners));
  const ends = [...edges.flatMap((each) => [[each.source, each.sourceFrame], [each.target, each.targetFrame]] as const)];
  const finished = nodes.map((node) => withReadings(withLinks(withPorts(node, ends), links), wires));
  return { nodes: finished, edges: inLanes(edges), links, wires, attachments };
}

function ownersOf(data: Model, entries: readonly Entry[]): Owners {
  const bodies = new Map<string, EntryId>([[GROUND, GROUND]]);
  for (const each of entries) if (each.section === "body" && !bodies.has(each.name)) bodies.set(each.name, each.id);
  const frames = new Map<EntryId, readonly string[]>();
  for (const id of bodies.values()) frames.set(id, ["", ...framesOf(data, id)]);
  return { bodies, frames, parts: entries.filter((each) => each.section === PART) };
}

function groundNode(frames: readonly string[]): DiagramNode {
  return { id: GROUND, kind: "ground", name: "Ground", section: GROUND, type: GROUND, frames, detail: "" };
}

function emptyNode({ id, name, section, type }: Entry): DiagramNode {
  return { id, kind: "coupling", name, section, type, frames: [], detail: "" };
}

function nodeOf(data: Model, entry: Entry): DiagramNode {
  const { id, section, value } = entry;
  const node = emptyNode(entry);
  if (section === "body") return { ...node, kind: "body", type: "body", frames: ["", ...framesOf(data, id)], detail: textOf(value["mass"]) };
  if (section === PART) return { ...node, kind: "part", type: PART, detail: textOf(value["file"]) };
  if (SIGNALS.includes(section)) return { ...node, kind: "signal", detail: signalDetail(section, value) };
  return { ...node, detail: couplingDetail(value) };
}

/** A part has a port for each of its frames that something here is joined to. */
function withPorts(node: DiagramNode, ends: readonly (readonly [EntryId, string])[]): DiagramNode {
  if (node.kind !== "part") return node;
  return { ...node, frames: [...new Set(ends.filter(([id]) => id === node.id).map(([, frame]) => frame))] };
}

/** A coupling whose joints are drawn names their coordinates, once each. */
function withLinks(node: DiagramNode, links: readonly CouplingLink[]): DiagramNode {
  const own = links.filter((each) => each.coupling === node.id);
  return own.length === 0 ? node : { ...node, detail: own.map((each) => each.coordinate).join(", ") };
}

/** A block names what it reads. */
function withReadings(node: DiagramNode, wires: readonly Wire[]): DiagramNode {
  if (node.section !== "block") return node;
  return { ...node, detail: wires.filter((each) => each.target === node.id).flatMap((each) => each.names).join(", ") };
}

function signalDetail(section: string, value: JsonObject): string {
  if (section === "table") return textOf(value["file"]) === "" ? "points" : textOf(value["file"]);
  if (section !== "signal") return "";
  if (value["rate"] !== undefined) return `rate ${textOf(value["rate"])}`;
  return value["output"] === undefined ? `= ${textOf(value["value"])}` : textOf(value["output"]);
}

function couplingDetail(value: JsonObject): string {
  const coupled = value["coupled"];
  return Array.isArray(coupled) ? coupled.map((each) => textOf(each as string)).filter((each) => each !== "").join(", ") : "";
}

type Ends = Pick<DiagramEdge, "source" | "sourceFrame" | "target" | "targetFrame">;

/** Return the nodes and frames that an entry joins, or null where it joins none or one is missing. */
function joinedEnds(value: JsonObject, owners: Owners): Ends | null {
  const ends = endsOf(value);
  if (ends === null) return null;
  const [start, end] = ends.map((each) => endOf(each, owners));
  if (start === undefined || end === undefined || start === null || end === null) return null;
  return { source: start.node, sourceFrame: start.frame, target: end.node, targetFrame: end.frame };
}

interface PlaceOfEnd {
  readonly node: EntryId;
  readonly frame: string;
}

/** Return the node and the frame of a reference; of the body of a part, its name there with the frame. */
function endOf(text: string, { bodies, frames, parts }: Owners): PlaceOfEnd | null {
  const { body, frame } = referenceOf(text);
  const node = bodies.get(body);
  if (node !== undefined) return frames.get(node)!.includes(frame) ? { node, frame } : null;
  const fitting = parts.filter(({ name }) => name !== "" && body.startsWith(`${name}_`)).sort((one, other) => other.name.length - one.name.length);
  const [part] = fitting;
  return part === undefined ? null : { node: part.id, frame: text.slice(part.name.length + 1) };
}

function attachmentOf(part: EntryId, at: string, owners: Owners): Attachment[] {
  const end = endOf(at, owners);
  return end === null || end.node === part ? [] : [{ part, ...end }];
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

/** Return by what an arrangement is known: names that formulas read change with every key, and move nothing. */
export function topologyOf({ nodes, edges, attachments }: DiagramGraph): string {
  const points = nodes.map((each) => `${each.id}:${each.name}:${each.frames.join(",")}`);
  const fixed = attachments.map((each) => `${each.part}@${each.node}`);
  return [...points, ...edges.map((each) => `${each.source}-${each.target}`), ...fixed].join(";");
}
