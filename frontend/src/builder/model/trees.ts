/** The rotation tree and the translation tree, and whether a joint is in them. */

import { entryAt, pointerOf, type EntryId } from "./entries";
import { isObject, withValue } from "./pointers";
import type { Json, Model, Summary } from "../types";

export type TreeName = "rotation" | "translation";
export const TREES: readonly TreeName[] = ["rotation", "translation"];

/** Return what the file says of a joint and a tree; null where it leaves the choice to the program. */
export function saidOfTree(tree: Json | undefined, name: TreeName): boolean | null {
  if (typeof tree === "boolean") return tree;
  if (!isObject(tree)) return null;
  const said = tree[name];
  return typeof said === "boolean" ? said : null;
}

/** Return whether a joint is in a tree now, as said or as chosen; null where neither is known. */
export function isInTree(data: Model, summary: Summary | null, id: EntryId, name: TreeName): boolean | null {
  const entry = entryAt(data, id);
  if (entry === null) return null;
  const said = saidOfTree(entry.value["tree"], name);
  if (said !== null) return said;
  const chosen = summary?.tree_choice[entry.name];
  if (chosen !== undefined) return chosen[name];
  return summary === null ? null : summary[`${name}_tree`].includes(entry.name);
}

/** Return data that says whether a joint is in a tree; null leaves the choice to the program. */
export function withTree(data: Model, id: EntryId, name: TreeName, value: boolean | null): Model {
  const before = entryAt(data, id)?.value["tree"];
  const said: Record<string, Json> = {};
  for (const each of TREES) {
    const now = each === name ? value : saidOfTree(before, each);
    if (now !== null) said[each] = now;
  }
  const count = Object.keys(said).length;
  const whole = count === 2 && said["rotation"] === said["translation"] ? said["rotation"]! : said;
  return withValue(data, pointerOf(id, "tree"), count === 0 ? undefined : whole);
}
