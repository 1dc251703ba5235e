/** The fields of a form, made from the schema of what they change. */

import { printedUnit } from "../../player/readable";
import { isArray, isObject } from "./pointers";
import { choicesOf, hasType, isFormula, resolveNode, type SchemaNode } from "./schema";
import { textOf } from "./entries";
import type { Json, JsonObject } from "../types";

export type FieldKind =
  | { readonly kind: "name" | "text" | "formula" | "switch" | "axis" | "tree" | "names" | "formulas" | "json" }
  | { readonly kind: "choice"; readonly values: readonly string[] }
  | { readonly kind: "vector"; readonly labels: readonly string[] }
  | { readonly kind: "matrix"; readonly rows: number; readonly columns: number }
  | { readonly kind: "reference"; readonly of: "frame" | "body" | "coordinate"; readonly labels: readonly string[] }
  | { readonly kind: "axes"; readonly count: number }
  | { readonly kind: "rows"; readonly columns: number | null }
  | { readonly kind: "group"; readonly node: SchemaNode }
  | { readonly kind: "map"; readonly node: SchemaNode; readonly names: readonly string[] }
  | { readonly kind: "list" }
  | { readonly kind: "entries"; readonly node: SchemaNode }
  | { readonly kind: "law"; readonly curve: SchemaNode }
  | { readonly kind: "shapes"; readonly kinds: readonly ShapeKind[] }
  | { readonly kind: "variant"; readonly words: readonly string[]; readonly node: SchemaNode };

/** A kind of shape, and what its sizes are called. */
export interface ShapeKind {
  readonly word: string;
  readonly sizes: readonly string[];
}

/** What a table acts with, where units differ: the force or the torque of a joint. */
export type Acting = "force" | "torque" | "";

export interface Field {
  readonly key: string;
  readonly label: string;
  readonly unit: string;
  readonly tip: string;
  readonly required: boolean;
  readonly default: Json;
  readonly control: FieldKind;
}

/** Fields that refer to other parts of the model. */
const REFERENCES: Readonly<Record<string, "frame" | "body" | "coordinate">> = {
  between: "frame", on: "frame", reaction_on: "body", resolved_in: "frame", coupled: "coordinate",
};

/** Return the fields of an object's schema, in its order; constants have none. */
export function fieldsOf(schema: JsonObject, node: SchemaNode, acting: Acting = ""): Field[] {
  const properties = isObject(node["properties"]) ? node["properties"] : {};
  const required = isArray(node["required"]) ? node["required"] : [];
  return Object.keys(properties).flatMap((key) => {
    const own = resolveNode(schema, properties[key]);
    if (own["const"] !== undefined) return [];
    return [fieldOf(schema, key, own, required.includes(key), acting)];
  });
}

/** Of keys that the schema says nothing of. */
const TIPS: Readonly<Record<string, string>> = { name: "Used in messages and outputs; unique in the model." };

export function fieldOf(schema: JsonObject, key: string, node: SchemaNode, required: boolean, acting: Acting = ""): Field {
  const description = textOf(node["description"] ?? TIPS[key]);
  const control = controlOf(schema, key, node);
  const [unit, tip] = control.kind === "map" ? ["", description] : unitAndTip(description, acting);
  return {
    key,
    label: labelOf(key),
    unit,
    tip,
    required,
    default: node["default"] ?? null,
    control,
  };
}

/** Return the unit of a description and what else it says; several units belong to several components, and stay there. */
function unitAndTip(description: string, acting: Acting): readonly [string, string] {
  const found = /\s*\[([^\]]+)\]/.exec(description);
  if (found === null) return ["", description];
  const all = found[1]!.split(", ").map(printedUnit);
  const unit = all.length === 2 && acting !== "" ? all[acting === "force" ? 0 : 1]! : all.join(", ");
  const tip = description.replace(/\s*\[[^\]]+\]/g, "").trim();
  return unit.includes(",") ? ["", `${tip} [${unit}]`.trim()] : [unit, tip];
}

/** Return the unit of a parameter and its comment in the file, which may begin with the unit. */
export function meaningOf(unit: string, comment: string): string {
  const rest = unit !== "" && comment.startsWith(unit) ? comment.slice(unit.length).replace(/^[\s:,;]+/, "") : comment;
  return [printedUnit(unit), rest].filter((each) => each !== "").join(" · ");
}

export function labelOf(key: string): string {
  const words = key.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function controlOf(schema: JsonObject, key: string, node: SchemaNode): FieldKind {
  if (key === "name") return { kind: "name" };
  const of = REFERENCES[key];
  if (of !== undefined) return { kind: "reference", of, labels: referenceLabels(key, node) };
  const choices = choicesOf(schema, node);
  const [first, ...others] = choices;
  if (first === undefined) return { kind: "json" };
  if (others.length > 0) return mixedControl(choices);
  return singleControl(schema, first, textOf(node["description"]));
}

function referenceLabels(key: string, node: SchemaNode): readonly string[] {
  if (node["type"] !== "array") return [""];
  const count = typeof node["minItems"] === "number" ? node["minItems"] : 2;
  if (key === "between") return ["Start", "End"];
  return Array.from({ length: count }, (_, index) => String(index + 1));
}

/** Return the control of a field that accepts several forms. */
function mixedControl(choices: readonly SchemaNode[]): FieldKind {
  const object = choices.find((each) => each["type"] === "object");
  if (choices.some((each) => isArray(each["enum"])) && choices.some((each) => each["type"] === "array")) return { kind: "axis" };
  const words = wordsOf(choices);
  if (words.length > 0 && choices.some((each) => each["type"] === "array")) return { kind: "axis" };
  if (object !== undefined) return tableControl(choices, words, object);
  if (choices.some(isFormula)) return { kind: "formulas" };
  const array = choices.find((each) => each["type"] === "array" && typeof each["minItems"] === "number");
  if (array !== undefined) return { kind: "vector", labels: Array.from({ length: Number(array["minItems"]) }, (_, index) => ["x", "y", "z", "x", "y", "z"][index] ?? "") };
  return { kind: "json" };
}

/** Return the control of a field that accepts a table or something else. */
function tableControl(choices: readonly SchemaNode[], words: readonly string[], table: SchemaNode): FieldKind {
  if (words.length > 0) return { kind: "variant", words, node: table };
  if (choices.some((each) => each["type"] === "boolean")) return { kind: "tree" };
  return choices.some(isFormula) ? { kind: "law", curve: table } : { kind: "json" };
}

/** Return the words among the choices. */
function wordsOf(choices: readonly SchemaNode[]): string[] {
  return choices.flatMap((each) => (isArray(each["enum"]) ? each["enum"].map(textOf) : []));
}

function singleControl(schema: JsonObject, node: SchemaNode, description: string): FieldKind {
  if (isFormula(node)) return { kind: "formula" };
  if (isArray(node["enum"])) return { kind: "choice", values: node["enum"].map(textOf) };
  if (hasType(node, "boolean")) return { kind: "switch" };
  if (hasType(node, "array")) return arrayControl(schema, node, description);
  if (isObject(node["properties"])) return { kind: "group", node };
  if (isObject(node["additionalProperties"])) return { kind: "map", node: resolveNode(schema, node["additionalProperties"]), names: keysOf(node) };
  return hasType(node, "string") ? { kind: "text" } : { kind: "json" };
}

/** Return the only keys that an object of formulas may have, where the schema names them. */
function keysOf(node: SchemaNode): readonly string[] {
  const names = node["propertyNames"];
  return isObject(names) && isArray(names["enum"]) ? names["enum"].map(textOf) : [];
}

/** Return how many items a list has, where its schema says so. */
function lengthOf(node: SchemaNode): number | null {
  return typeof node["minItems"] === "number" && node["minItems"] === node["maxItems"] ? node["minItems"] : null;
}

function arrayControl(schema: JsonObject, node: SchemaNode, description: string): FieldKind {
  const item = resolveNode(schema, node["items"]);
  const count = lengthOf(node);
  const inner = choicesOf(schema, item);
  if (count !== null) return fixedControl(item, inner, description, count);
  if (isFormula(item)) return { kind: "formulas" };
  if (isArray(item["prefixItems"])) return { kind: "list" };
  if (item["type"] === "array" && isFormula(resolveNode(schema, item["items"]))) return { kind: "rows", columns: lengthOf(item) };
  if (inner.some((each) => isObject(each["properties"]))) return { kind: "entries", node: item };
  return hasType(item, "string") ? { kind: "names" } : { kind: "json" };
}

/** Return the kinds of shapes: words of their own, and keys of tables with one entry; none where the choices are others. */
function shapeKinds(choices: readonly SchemaNode[]): ShapeKind[] {
  const table = choices.find((each) => each["type"] === "object" && each["maxProperties"] === 1);
  if (table === undefined || !isObject(table["properties"])) return [];
  const plain = wordsOf(choices);
  const sized = Object.entries(table["properties"]).map(([word, node]) => ({ word, sizes: isObject(node) ? textOf(node["title"]).split(", ") : [] }));
  return [...plain.map((word) => ({ word, sizes: [] })), ...sized];
}

/** Return the control of so many values of one form. */
function fixedControl(item: SchemaNode, inner: readonly SchemaNode[], description: string, count: number): FieldKind {
  const kinds = shapeKinds(inner);
  if (kinds.length > 0) return { kind: "shapes", kinds };
  if (inner.length > 1) return { kind: "axes", count };
  if (isFormula(item) || hasType(item, "number")) return { kind: "vector", labels: componentLabels(description, count) };
  if (item["type"] === "array") return { kind: "matrix", rows: count, columns: Number(item["minItems"] ?? count) };
  return hasType(item, "string") ? { kind: "names" } : { kind: "json" };
}

/** Return the short words that a description lists, as in "xx, yy, zz about ...", else x, y, z. */
export function componentLabels(description: string, count: number): string[] {
  const listed = /((?:\b[xyz]{2}\b,?\s*(?:and\s+)?)+)/.exec(description)?.[1]?.match(/[xyz]{2}/g) ?? [];
  if (listed.length === count) return [...listed];
  return Array.from({ length: count }, (_, index) => (count === 3 ? "xyz".charAt(index) : String(index + 1)));
}
