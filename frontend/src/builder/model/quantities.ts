/** Numbers with units as people type and read them; the model computes in rad and m. */

const FACTORS: Readonly<Record<string, readonly [string, number]>> = {
  rad: ["rad", 1], deg: ["rad", Math.PI / 180], "°": ["rad", Math.PI / 180], m: ["m", 1], mm: ["m", 1e-3], cm: ["m", 1e-2], km: ["m", 1e3], in: ["m", 0.0254],
  ft: ["m", 0.3048], kg: ["kg", 1], g: ["kg", 1e-3], t: ["kg", 1e3], s: ["s", 1], ms: ["s", 1e-3], min: ["s", 60], N: ["N", 1], kN: ["N", 1e3], mN: ["N", 1e-3],
};
const QUANTITY = /^\s*([-+−]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*([a-z°]*)\s*$/i;

/** Return what a text means in a unit's base, `usual` where it names no unit; null where it is no quantity of that kind. */
export function quantityOf(text: string, base: string, usual: string = base): number | null {
  const match = QUANTITY.exec(text);
  if (match === null) return null;
  const number = Number(match[1]!.replace("−", "-"));
  const unit = match[2] === "" ? usual : match[2]!;
  if (unit === "" && base === "") return number;
  const known = FACTORS[unit];
  return known === undefined || known[0] !== base ? null : number * known[1];
}

/** Return a number of a base unit as it is read in another, with six digits. */
export function textIn(value: number, unit: string): string {
  const number = Number((value / (FACTORS[unit]?.[1] ?? 1)).toPrecision(6));
  return String(Math.abs(number) < 1e-12 ? 0 : number);
}

/** A quantity with a unit that formulas do not know, in the unit that they compute in. */
export interface Converted {
  readonly text: string;
  readonly note: string;
}

/** Return what a text such as "40 mm" is in the base unit of a field, or of its own where the field has none; null where nothing is to be done. */
export function converted(text: string, base = ""): Converted | null {
  const unit = QUANTITY.exec(text)?.[2] ?? "";
  const known = FACTORS[unit];
  if (known === undefined || unit === "deg" || (base !== "" && known[0] !== base)) return null; // formulas know degrees
  const value = quantityOf(text, known[0]);
  if (value === null) return null;
  const number = String(Number(value.toPrecision(12)));
  return { text: number, note: `${text.trim()} is ${number} ${known[0]}.` };
}
