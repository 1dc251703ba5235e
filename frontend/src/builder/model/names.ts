/** What names may be: symbols stand in formulas, elements have addresses. */

import { entriesOf, GROUND, namesOf, symbolsOf } from "./entries";
import { SIGNALS } from "./graph";
import type { Model } from "../types";

/** Names of the language itself; formulas never mean a symbol of the model by them. */
const RESERVED: readonly string[] = ["t", "pi", "if", "and", "or", "not"];
const LONGEST = 128;
const SYMBOL = /^[A-Za-z_\u0080-\u{10ffff}][\w\u0080-\u{10ffff}]*$/u;

/** Whether formulas can mean something by a text. */
export function isSymbol(text: string): boolean {
  return SYMBOL.test(text) && text.length <= LONGEST && !RESERVED.includes(text);
}

/** Return why a symbol cannot have a name, or "" where it can. */
export function symbolRefusal(name: string): string {
  if (name === "") return "A name is needed.";
  if (RESERVED.includes(name)) return `${name} is reserved in formulas: choose another name.`;
  if (name.length > LONGEST) return `A name has at most ${LONGEST} characters.`;
  return isSymbol(name) ? "" : "Use letters, digits and _, beginning with a letter.";
}

/** Return why an element or a frame cannot have a name, or "" where it can. */
export function elementRefusal(name: string): string {
  if (name === "") return "A name is needed.";
  if (name.toLowerCase() === GROUND) return `${name} is the name of the fixed frame: choose another name.`;
  if (/^\d+$/.test(name)) return "A name that consists only of digits would be read as a number.";
  if (/[./"']/.test(name)) return "A name has no dot, slash or quotation mark.";
  return name.length > LONGEST ? `A name has at most ${LONGEST} characters.` : "";
}

/** Return every name that a formula can contain: of parameters, inputs, coordinates and signals. */
export function formulaNames(data: Model, further: readonly string[] = []): Set<string> {
  const signals = entriesOf(data).filter((each) => SIGNALS.includes(each.section)).map((each) => each.name);
  return new Set([...symbolsOf(data), ...signals, ...further]);
}

/** Whether a word names something in a model, so that its letters stay as they are. */
export function isNameIn(data: Model, word: string): boolean {
  return /[\d_]/.test(word) || namesOf(data).has(word) || symbolsOf(data).has(word);
}
