/** Objects of before where they say the same: what is drawn from them is not drawn anew. */

import { useEffect, useRef } from "react";
import type { Model } from "../types";

// Of a model these are not in the diagram.
const ASIDE = ["name", "gravity", "parameters", "initial"];

/** Return whether two models have the same diagram: their parts are the same objects, as edits leave them. */
export function isSameDrawing(one: Model, other: Model): boolean {
  const names = new Set([...Object.keys(one), ...Object.keys(other)]);
  return [...names].every((name) => ASIDE.includes(name) || one[name] === other[name]);
}

export function isEqual(one: unknown, other: unknown): boolean {
  return one === other || JSON.stringify(one) === JSON.stringify(other);
}

/** Return items, each the object of before where it is equal; the array of before where all are. */
export function kept<T extends { readonly id: string }>(before: readonly T[], items: T[]): T[] {
  const earlier = new Map(before.map((each) => [each.id, each]));
  const result = items.map((each) => {
    const former = earlier.get(each.id);
    return former !== undefined && isEqual(former, each) ? former : each;
  });
  const same = result.length === before.length && result.every((each, index) => each === before[index]);
  return same ? (before as T[]) : result;
}

/** Return items as `kept` does, those of the last rendering being the ones of before. */
export function useKept<T extends { readonly id: string }>(items: T[]): T[] {
  const last = useRef<T[]>([]);
  const result = kept(last.current, items);
  useEffect(() => { last.current = result; }, [result]);
  return result;
}
