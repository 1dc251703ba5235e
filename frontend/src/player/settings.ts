/** What the user chooses, and who hears of a change. */

import { VIEW_NAMES, type Look, type ThemeChoice, type TraceMode, type ViewName } from "../viewer";

export interface SettingValues {
  theme: ThemeChoice;
  /** "auto": against the normal of a planar mechanism, else isometric. */
  view: "auto" | ViewName;
  parallel: boolean;
  /** Whether the camera goes with the selected body or, with none selected, with the centre of mass. */
  follow: boolean;
  look: Look;
  frames: boolean;
  joints: boolean;
  labels: boolean;
  grid: boolean;
  gravity: boolean;
  force: boolean;
  torque: boolean;
  contact: boolean;
  reaction: boolean;
  footprints: boolean;
  arrowFactor: number;
  ghosts: number;
  /** Traced points as "body.frame". */
  traces: readonly string[];
  traceMode: TraceMode;
  speed: number;
  loop: boolean;
  autoplay: boolean;
  time: number | null;
  curves: boolean;
  /** Names of the curves that are drawn; null leaves the choice to the page. */
  shownCurves: readonly string[] | null;
}

export const DEFAULTS: SettingValues = {
  theme: "auto",
  view: "auto",
  parallel: false,
  follow: false,
  look: "solid",
  frames: false,
  joints: false,
  labels: false,
  grid: true,
  gravity: true,
  force: true,
  torque: true,
  contact: true,
  reaction: true,
  footprints: true,
  arrowFactor: 1,
  ghosts: 0,
  traces: [],
  traceMode: "past",
  speed: 1,
  loop: true,
  autoplay: true,
  time: null,
  curves: true,
  shownCurves: null,
};

export const MOST_GHOSTS = 12;

const CHOICES: Partial<Record<keyof SettingValues, readonly unknown[]>> = {
  theme: ["auto", "light", "dark", "contrast"],
  view: ["auto", ...VIEW_NAMES],
  look: ["solid", "transparent", "wire"],
  traceMode: ["past", "whole"],
};

const MOST_NAMED = 6;

/** Return the settings of a picture of so many bodies: names stand beside a few, and would hide many. */
export function defaultsFor(bodies: number): SettingValues {
  return { ...DEFAULTS, labels: bodies <= MOST_NAMED };
}

/** Return settings from the data's options; what has another type or is unknown is left out. */
export function settingsFrom(options: unknown, bodies: number): SettingValues {
  const values = defaultsFor(bodies);
  if (typeof options !== "object" || options === null) return values;
  for (const [name, value] of Object.entries(options as Record<string, unknown>)) {
    if (isSetting(name) && fits(name, value)) Object.assign(values, { [name]: value });
  }
  values.ghosts = Math.min(Math.max(Math.round(values.ghosts), 0), MOST_GHOSTS);
  return values;
}

function isSetting(name: string): name is keyof SettingValues {
  return name in DEFAULTS;
}

function fits(name: keyof SettingValues, value: unknown): boolean {
  const choices = CHOICES[name];
  if (choices !== undefined) return choices.includes(value);
  if (name === "traces" || name === "shownCurves") {
    return Array.isArray(value) && value.every((each: unknown) => typeof each === "string");
  }
  if (name === "time") return typeof value === "number" && Number.isFinite(value);
  return typeof value === typeof DEFAULTS[name];
}

type Listener = (name: keyof SettingValues) => void;

export class Settings {
  private readonly listeners: Listener[] = [];

  constructor(readonly values: SettingValues) {}

  set<K extends keyof SettingValues>(name: K, value: SettingValues[K]): void {
    if (this.values[name] === value) return;
    this.values[name] = value;
    for (const listener of this.listeners) listener(name);
  }

  /** Call back on each change, and for each setting now. */
  follow(listener: Listener): void {
    this.listeners.push(listener);
    for (const name of Object.keys(this.values)) if (isSetting(name)) listener(name);
  }
}
