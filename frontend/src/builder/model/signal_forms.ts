/** The three forms of a signal, of which each has exactly one: a value, an output, a state with a rate. */

import type { Entry } from "./entries";
import { pointerOf } from "./entries";
import { withValue } from "./pointers";
import type { Json, JsonObject, Model } from "../types";

export const FORMS = ["value", "output", "rate"] as const;
export type SignalForm = (typeof FORMS)[number];

/** What a new form begins with, where the one of before is no formula. */
const FIRST: Readonly<Record<SignalForm, string>> = { value: "0", output: "energy", rate: "0" };

/** Return the form that a signal has; of a file that gives several, the first. */
export function formOf(value: JsonObject): SignalForm {
  return FORMS.find((each) => value[each] !== undefined && value[each] !== null) ?? "value";
}

/** Return the fields that say nothing of a signal of this form; those that the file has are shown nevertheless. */
export function hiddenFields(value: JsonObject): string[] {
  const form = formOf(value);
  const all: readonly string[] = [...FORMS, "initial"];
  return all.filter((each) => each !== form && !(each === "initial" && form === "rate") && value[each] === undefined);
}

/** Return data in which a signal has another form; a formula goes with it. */
export function withForm(data: Model, { id, value }: Entry, form: SignalForm): Model {
  const before = formOf(value);
  if (before === form) return data;
  const text: Json = before === "output" || form === "output" ? FIRST[form] : (value[before] ?? FIRST[form]);
  const kept = Object.entries(value).filter(([key]) => !FORMS.includes(key as SignalForm) && key !== "initial");
  return withValue(data, pointerOf(id), { ...Object.fromEntries(kept), [form]: text });
}
