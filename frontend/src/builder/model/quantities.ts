/** Numbers with units as people type and read them; the model computes in rad and m. */

const FACTORS: Readonly<Record<string, readonly [string, number]>> = {
  rad: ["rad", 1], deg: ["rad", Math.PI / 180], "°": ["rad", Math.PI / 180], m: ["m", 1], mm: ["m", 1e-3], cm: ["m", 1e-2], km: ["m", 1e3], in: ["m", 0.0254],
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
