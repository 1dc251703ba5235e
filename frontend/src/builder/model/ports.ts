/** Which port of a body a joint takes where none is named. */

import { withoutFreePlaces } from "./coordinates";
import { endsOf, entriesOf, entryAt, framesOf, GROUND, referenceText, type EntryId } from "./entries";
import type { Model } from "../types";

/** Return how many elements join each frame. */
function usesOf(data: Model): Map<string, number> {
  const uses = new Map<string, number>();
  for (const { value } of entriesOf(data)) for (const end of endsOf(value) ?? []) uses.set(end, (uses.get(end) ?? 0) + 1);
  return uses;
}

/** Return the frame that a new joint takes: a free one, the nearest of them; of bodies without frames their own axes. */
export function portFor(data: Model, id: EntryId, distance: (frame: string) => number = () => 0): string {
  const body = id === GROUND ? GROUND : (entryAt(data, id)?.name ?? "");
  const frames = framesOf(data, id);
  const choices = id === GROUND ? ["", ...frames] : frames.length > 0 ? frames : [""];
  const uses = usesOf(data);
  const usedOf = (frame: string): number => uses.get(referenceText({ body, frame })) ?? 0;
  const least = Math.min(...choices.map(usedOf));
  return choices.filter((each) => usedOf(each) === least).sort((one, other) => distance(one) - distance(other))[0]!;
}

/** Return data after a change, without places of bodies that moved freely before it and are held by a joint now. */
export function withHeldBodies(before: Model, after: Model): Model {
  if (before["joint"] === after["joint"]) return after;
  const joined = joinedBodies(before);
  return withoutFreePlaces(after, [...joinedBodies(after)].filter((each) => !joined.has(each)));
}

/** Return the bodies that joints hold. */
export function joinedBodies(data: Model): Set<string> {
  return new Set(entriesOf(data).filter((each) => each.section === "joint").flatMap(({ value }) => (endsOf(value) ?? []).map((end) => end.split(".")[0]!)));
}
