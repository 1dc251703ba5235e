/** The panel that chooses what the picture shows. */

import type { Scene, StateSource } from "../viewer";
import { tracePoints, vectorGroup } from "../viewer";
import { create, setText } from "./dom";
import { keysOf, type Command } from "./keys";
import { MOST_GHOSTS, type Settings, type SettingValues } from "./settings";

type Flag = {
  [K in keyof SettingValues]: SettingValues[K] extends boolean ? K : never;
}[keyof SettingValues];

const MANY_POINTS = 12;

/** Return the groups of the panel for a scene. */
export function displayPanel(settings: Settings, scene: Scene, source: StateSource): HTMLElement[] {
  const groups = new Set(source.vectors.map(vectorGroup));
  const parts = [
    check(settings, "labels", "Names", "labels"),
    check(settings, "frames", "Frames", "frames"),
    check(settings, "joints", "Joints", "joints"),
    check(settings, "grid", "Ground", "grid"),
    ...(scene.gravity === null ? [] : [check(settings, "gravity", "Gravity")]),
  ];
  const arrows = [
    ...(groups.has("force") ? [check(settings, "force", "Forces")] : []),
    ...(groups.has("torque") ? [check(settings, "torque", "Torques")] : []),
    ...(groups.has("contact") ? [check(settings, "contact", "Contacts")] : []),
    ...(source.vectors.some((each) => each.prints) ? [check(settings, "footprints", "Footprints")] : []),
    ...(groups.has("reaction") ? [check(settings, "reaction", "Reactions")] : []),
  ];
  const moving = source.end > source.start;
  return [
    section("Show", create("div", { class: "sb-checks" }, ...parts)),
    section("Bodies", radios(settings, "look", [["solid", "Solid"], ["transparent", "Clear"], ["wire", "Wire"]])),
    ...(arrows.length === 0 ? [] : [section("Arrows", create("div", { class: "sb-checks" }, ...arrows), arrowLength(settings))]),
    ...(moving ? [section("Ghosts", ghosts(settings))] : []),
    ...(moving ? [section("Traces", traces(settings, scene))] : []),
    section("Colours", radios(settings, "theme", [["auto", "Auto"], ["light", "Light"], ["dark", "Dark"], ["contrast", "Contrast"]])),
  ]; // prettier-ignore
}

function section(title: string, ...content: HTMLElement[]): HTMLElement {
  return create("fieldset", {}, create("legend", {}, title), ...content);
}

function check(settings: Settings, name: Flag, label: string, command?: Command): HTMLElement {
  const box = create("input", { type: "checkbox" });
  box.addEventListener("change", () => { settings.set(name, box.checked); });
  settings.follow((changed) => {
    if (changed === name) box.checked = settings.values[name];
  });
  const key = command === undefined ? [] : [create("kbd", { "aria-hidden": "true" }, keysOf(command)[0] ?? "")];
  return create("label", { class: "sb-check" }, box, create("span", {}, label), ...key);
}

let made = 0;

function radios<K extends "look" | "theme" | "traceMode">(
  settings: Settings,
  name: K,
  choices: readonly (readonly [SettingValues[K], string])[],
): HTMLElement {
  made += 1;
  const group = `sb-${name}-${made}`;
  const buttons = choices.map(([value, label]) => {
    const button = create("input", { type: "radio", name: group, value });
    button.addEventListener("change", () => { if (button.checked) settings.set(name, value); });
    settings.follow((changed) => {
      if (changed === name) button.checked = settings.values[name] === value;
    });
    return create("label", {}, button, create("span", {}, label));
  });
  return create("div", { class: "sb-choice" }, ...buttons);
}

function range(
  label: string,
  limits: { min: number; max: number; step: number },
  change: (value: number) => void,
): { row: HTMLElement; show: (value: number, text: string) => void } {
  const input = create("input", { type: "range", "aria-label": label, ...limits });
  const output = create("span", { class: "sb-number" });
  input.addEventListener("input", () => { change(Number(input.value)); });
  return {
    row: create("div", { class: "sb-range" }, input, output),
    show(value, text): void {
      input.value = String(value);
      input.setAttribute("aria-valuetext", text);
      setText(output, text);
    },
  };
}

function arrowLength(settings: Settings): HTMLElement {
  // the slider is logarithmic: from a tenth to ten times
  const { row, show } = range("Length of arrows", { min: -1, max: 1, step: 0.05 }, (value) => {
    settings.set("arrowFactor", 10 ** value);
  });
  settings.follow((changed) => {
    const factor = settings.values.arrowFactor;
    if (changed === "arrowFactor") show(Math.log10(factor), `${Number(factor.toPrecision(2))}×`);
  });
  return row;
}

function ghosts(settings: Settings): HTMLElement {
  const { row, show } = range("Number of ghosts", { min: 0, max: MOST_GHOSTS, step: 1 }, (value) => {
    settings.set("ghosts", value);
  });
  settings.follow((changed) => {
    if (changed === "ghosts") show(settings.values.ghosts, settings.values.ghosts === 0 ? "none" : String(settings.values.ghosts));
  });
  return row;
}

function traces(settings: Settings, scene: Scene): HTMLElement {
  const points = tracePoints(scene);
  const list = create("div", { class: "sb-checks sb-scroll" });
  for (const { name } of points) {
    const box = create("input", { type: "checkbox" });
    box.addEventListener("change", () => {
      const others = settings.values.traces.filter((each) => each !== name);
      settings.set("traces", box.checked ? [...others, name] : others);
    });
    settings.follow((changed) => {
      if (changed === "traces") box.checked = settings.values.traces.includes(name);
    });
    list.append(create("label", { class: "sb-check" }, box, create("span", {}, name)));
  }
  const mode = radios(settings, "traceMode", [["past", "Up to now"], ["whole", "Whole"]]);
  const search = points.length > MANY_POINTS ? [filter(list)] : [];
  return create("div", {}, mode, ...search, list);
}

function filter(list: HTMLElement): HTMLElement {
  const input = create("input", { type: "search", class: "sb-search", placeholder: "Find a point", "aria-label": "Find a point" });
  input.addEventListener("input", () => {
    const text = input.value.toLowerCase();
    for (const row of list.children) {
      if (row instanceof HTMLElement) row.hidden = !row.textContent.toLowerCase().includes(text);
    }
  });
  return input;
}
