/** The JSON schema of a model file, resolved and walked. */

import { isArray, isObject } from "./pointers";
import type { Json, JsonObject, PaletteElement } from "../types";

export interface SchemaNode {
  readonly [key: string]: Json;
}

/** Return a node with its reference resolved; what stands beside the reference wins. */
export function resolveNode(schema: JsonObject, node: Json | undefined): SchemaNode {
  if (!isObject(node)) return {};
  const reference = node["$ref"];
  if (typeof reference !== "string") return node;
  const definitions = schema["$defs"];
  const name = reference.split("/").at(-1)!;
  const target = isObject(definitions) ? definitions[name] : undefined;
  return { ...(isObject(target) ? target : {}), ...without(node, "$ref") };
}

function without(node: JsonObject, key: string): JsonObject {
  return Object.fromEntries(Object.entries(node).filter(([each]) => each !== key));
}

export function definitionNode(schema: JsonObject, name: string): SchemaNode {
  return resolveNode(schema, { $ref: `#/$defs/${name}` });
}

/** Return the choices of a node other than null, resolved. */
export function choicesOf(schema: JsonObject, node: SchemaNode): SchemaNode[] {
  const choices = node["anyOf"] ?? node["oneOf"];
  if (!isArray(choices)) return [node];
  return choices.map((each) => resolveNode(schema, each)).filter((each) => each["type"] !== "null");
}

/** Whether a node takes a number or a formula. */
export function isFormula(node: SchemaNode): boolean {
  const { type } = node;
  return isArray(type) && type.includes("string") && type.includes("number");
}

export function hasType(node: SchemaNode, name: string): boolean {
  const { type } = node;
  return type === name || (isArray(type) && type.includes(name));
}

export function elementOf(elements: readonly PaletteElement[], section: string, type: string): PaletteElement | null {
  return elements.find((each) => each.section === section && (each.type === type || each.type === "" || type === "")) ?? null;
}

/** Return data with every formula replaced; names, letters of axes and references are none. */
export function mapFormulas(schema: JsonObject, node: SchemaNode, value: Json, change: (text: string) => string): Json {
  const choices = choicesOf(schema, node);
  if (typeof value === "string") return choices.some(isFormula) && !isLetter(choices, value) ? change(value) : value;
  if (isArray(value)) {
    const fit = choices.find((each) => each["type"] === "array");
    return fit === undefined ? value : value.map((item, index) => mapFormulas(schema, itemNode(schema, fit, item, index), item, change));
  }
  if (!isObject(value)) return value;
  const fit = choices.find((each) => hasType(each, "object"));
  if (fit === undefined) return value;
  const entries = Object.entries(value).map(([key, item]) => [key, mapFormulas(schema, fieldNode(schema, fit, key), item, change)] as const);
  return Object.fromEntries(entries);
}

function isLetter(choices: readonly SchemaNode[], value: string): boolean {
  return choices.some((each) => isArray(each["enum"]) && each["enum"].includes(value));
}

function itemNode(schema: JsonObject, node: SchemaNode, item: Json, index: number): SchemaNode {
  const prefix = node["prefixItems"];
  if (isArray(prefix)) return resolveNode(schema, prefix[index]);
  const items = resolveNode(schema, node["items"]);
  const choices = items["oneOf"];
  if (!isArray(choices) || !isObject(item)) return items;
  const own = choices.map((each) => resolveNode(schema, each));
  return own.find((each) => constantType(each) === item["type"]) ?? items;
}

/** Return the word that an entry of a node names its type by, or "" where it has none. */
export function typeOfNode(node: SchemaNode): string {
  const type = constantType(node);
  return typeof type === "string" ? type : "";
}

function constantType(node: SchemaNode): Json | undefined {
  const properties = node["properties"];
  const type = isObject(properties) ? properties["type"] : undefined;
  return isObject(type) ? type["const"] : undefined;
}

export function fieldNode(schema: JsonObject, node: SchemaNode, key: string): SchemaNode {
  const properties = node["properties"];
  if (isObject(properties) && properties[key] !== undefined) return resolveNode(schema, properties[key]);
  return resolveNode(schema, node["additionalProperties"]);
}
