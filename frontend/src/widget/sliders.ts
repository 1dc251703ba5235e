/** Sliders over the picture whose values Python gets. */

import { create, setText } from "../player/dom";

export interface SliderRange {
  readonly name: string;
  readonly min: number;
  readonly max: number;
  readonly value: number;
  readonly unit: string;
}

/** Return the sliders of a trait; `values` by name take the place of the first ones. */
export function readSliders(sliders: unknown, values: unknown): SliderRange[] {
  if (!Array.isArray(sliders)) return [];
  const chosen = (typeof values === "object" && values !== null ? values : {}) as Record<string, unknown>;
  return sliders.flatMap((each: unknown) => {
    if (typeof each !== "object" || each === null) return [];
    const { name, min, max, value, unit } = each as Record<string, unknown>;
    if (typeof name !== "string" || typeof min !== "number" || typeof max !== "number" || !(max > min)) return [];
    const first = [chosen[name], value, min].find((one): one is number => typeof one === "number") ?? min;
    return [{ name, min, max, value: first, unit: typeof unit === "string" ? unit : "" }];
  });
}

/** Return a row for each slider; `change` gets what the user chooses. */
export function createSliders(sliders: readonly SliderRange[], change: (name: string, value: number) => void): HTMLElement[] {
  return sliders.map(({ name, min, max, value, unit }) => {
    const input = create("input", { type: "range", min, max, step: (max - min) / 500, "aria-label": name });
    const output = create("span", { class: "sb-number" });
    input.value = String(value);
    const show = (): void => {
      const text = `${Number(Number(input.value).toPrecision(4))}${unit === "" ? "" : `\u202f${unit}`}`;
      setText(output, text);
      input.setAttribute("aria-valuetext", text);
    };
    input.addEventListener("input", () => {
      show();
      change(name, Number(input.value));
    });
    show();
    return create("label", { class: "sb-slider" }, create("span", {}, name), input, output);
  });
}
