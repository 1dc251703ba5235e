/** Places in JSON data, written as JSON pointers. */

import type { Json, JsonObject, Model, PatchStep } from "../types";

export function isObject(value: Json | undefined): value is JsonObject {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

export function isArray(value: Json | undefined): value is readonly Json[] {
  return Array.isArray(value);
}

export function splitPointer(pointer: string): string[] {
  if (pointer === "") return [];
  return pointer.slice(1).split("/").map((part) => part.replaceAll("~1", "/").replaceAll("~0", "~"));
}

export function joinPointer(...parts: (string | number)[]): string {
  return parts.map((part) => `/${String(part).replaceAll("~", "~0").replaceAll("/", "~1")}`).join("");
}

export function valueAt(data: Json | undefined, pointer: string): Json | undefined {
  let value = data;
  for (const part of splitPointer(pointer)) {
    if (isArray(value)) value = value[Number(part)];
    else if (isObject(value)) value = value[part];
    else return undefined;
  }
  return value;
}

/** Return data with a value at a pointer, or without it where the value is undefined. */
export function withValue(data: Model, pointer: string, value: Json | undefined): Model {
  return replaced(data, splitPointer(pointer), value) as Model;
}

function replaced(data: Json | undefined, parts: readonly string[], value: Json | undefined): Json | undefined {
  const [first, ...rest] = parts;
  if (first === undefined) return value;
  if (isArray(data)) {
    const items = [...data];
    const inner = replaced(items[Number(first)], rest, value);
    if (inner === undefined) items.splice(Number(first), 1);
    else items[Number(first)] = inner;
    return items;
  }
  const fields: Record<string, Json> = { ...(isObject(data) ? data : {}) };
  const inner = replaced(fields[first], rest, value);
  if (inner === undefined) Reflect.deleteProperty(fields, first);
  else fields[first] = inner;
  return fields;
}

/** Return data after the steps of a repair. */
export function patched(data: Model, steps: readonly PatchStep[]): Model {
  return steps.reduce((before, step) => {
    const parent = step.path.slice(0, step.path.lastIndexOf("/"));
    const items = valueAt(before, parent);
    if (step.op === "add" && isArray(items)) {
      const last = splitPointer(step.path).at(-1)!;
      const index = last === "-" ? items.length : Number(last);
      return withValue(before, parent, [...items.slice(0, index), step.value ?? null, ...items.slice(index)]);
    }
    return withValue(before, step.path, step.op === "remove" ? undefined : (step.value ?? null));
  }, data);
}

/** Return data whose object keys keep their order while one has another name. */
export function withKey(data: Model, pointer: string, before: string, after: string): Model {
  const fields = valueAt(data, pointer);
  if (!isObject(fields) || before === after) return data;
  const entries = Object.entries(fields).map(([key, value]) => [key === before ? after : key, value] as const);
  return withValue(data, pointer, Object.fromEntries(entries));
}
