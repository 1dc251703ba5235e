/** Names of coordinates as people write them: Greek letters, indices, dots. */

import { create } from "./dom";

const GREEK: Readonly<Record<string, string>> = {
  alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ", iota: "ι", kappa: "κ",
  lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ", tau: "τ", upsilon: "υ", phi: "φ", chi: "χ",
  psi: "ψ", omega: "ω", Gamma: "Γ", Delta: "Δ", Theta: "Θ", Lambda: "Λ", Xi: "Ξ", Pi: "Π", Sigma: "Σ", Phi: "Φ",
  Psi: "Ψ", Omega: "Ω",
}; // prettier-ignore

const DOTS: Readonly<Record<string, string>> = { _dot: "\u0307", _ddot: "\u0308" };

/** What stands in a line, and what below it; `symbol` where it is the name of a quantity, not words. */
export interface Reading {
  readonly base: string;
  readonly index: string;
  readonly symbol: boolean;
}

/** Return how a name is read: "theta_1_dot" as θ with a dot and the index 1; names that are words stay. */
export function readName(name: string): Reading {
  const plain: Reading = { base: name, index: "", symbol: false };
  const parts = /^([A-Za-z]+?)(?:_?(\d+)|_(?!d?dot$)([A-Za-z0-9]+))?(_dot|_ddot)?$/.exec(name);
  if (parts === null) return plain;
  const [, stem = "", digits = "", word = "", dots = ""] = parts;
  const letter = GREEK[stem] ?? stem;
  if (letter.length > 1) return plain;
  return { base: letter + (DOTS[dots] ?? ""), index: withGreek(digits + word), symbol: true };
}

function withGreek(word: string): string {
  return GREEK[word] ?? word;
}

/** Return a name in one line of text, indices without a shift. */
export function plainReading(name: string): string {
  const { base, index } = readName(name);
  return base + index;
}

/** Return the element that shows a name. */
export function nameElement(name: string, attributes: Record<string, string>): HTMLElement {
  const { base, index, symbol } = readName(name);
  const shown = symbol ? create("i", {}, base) : base;
  return create("span", attributes, shown, ...(index === "" ? [] : [create("sub", {}, index)]));
}

/** Return a unit as it is printed: kg·m² for "kg m^2", N·m/rad for "N m/rad". */
export function printedUnit(unit: string): string {
  return unit.replace(/\^(-?\d)/g, (_, power: string) => raised(power)).replace(/(?<=[^\s,]) (?=\S)/g, "·");
}

/** Return the digits of an exponent as they are raised. */
export function raised(digits: string): string {
  return digits.replace(/./g, (each) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".charAt("-0123456789".indexOf(each)));
}

/** Return a number as it is written in print, such as −3·10⁻⁸. */
export function inPrint(value: number, digits = 2): string {
  if (value === 0) return "0";
  const [mantissa = "", power = "0"] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  if (exponent >= -3 && exponent < 4) return String(Number(value.toPrecision(digits))).replace("-", "\u2212");
  return `${Number(mantissa) === 1 ? "" : `${Number(mantissa)}·`}10`.replace("-", "\u2212") + raised(String(exponent));
}
