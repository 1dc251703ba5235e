/** Colours: of bodies, kinds of elements and themes. */

/** Soft relatives of the palette of Okabe and Ito, as films have them: distinct with any colour vision. */
export const BODY_COLORS = [
  "#4f8fc4", "#e08a3c", "#4da887", "#c987ad", "#d8b13a", "#79b8dd", "#8f7fc0", "#b9705c",
] as const; // prettier-ignore

const GROUND = "#a9b0b8";

export const CONNECTOR_COLORS = {
  spring: "#9aa6b2",
  damper: "#a4abb4",
  rope: "#8a6d4b",
  actuator: "#c2a14d",
  line: "#6d7a86",
} as const;

export const VECTOR_COLORS = { force: "#c62f3b", torque: "#7a3fa0", reaction: "#0a8f8f", contact: "#d81b7a" } as const;
/** What footprints fade to. */
export const FADED = "#a9b0b8";
/** Edges of solids, and how strongly they are drawn. */
export const EDGE = { color: "#0e1a28", opacity: 0.45 } as const;
export const HIGHLIGHT = "#ffe433";
/** What something comes from, by its name, and how strongly that is shown, from 0 to 1. */
export type Lights = ReadonlyMap<string, number>;
export const LIGHT = "#ff9d1f";
export const NO_LIGHTS: Lights = new Map<string, number>();

/** Return a colour of a body by its place; the ground is grey. */
export function bodyColor(body: number): string {
  return body === 0 ? GROUND : BODY_COLORS[(body - 1) % BODY_COLORS.length]!;
}

export type ThemeName = "light" | "dark" | "contrast";
export type ThemeChoice = "auto" | ThemeName;

export interface Theme {
  readonly name: ThemeName;
  readonly grid: string;
  readonly gridOpacity: number;
  readonly ground: string;
  readonly groundOpacity: number;
  /** How dark shadows are, from 0 to 1. */
  readonly shadow: number;
  readonly sky: string;
  readonly floor: string;
  readonly light: number;
  readonly joint: string;
  readonly gravity: string;
}

export const THEMES: Record<ThemeName, Theme> = {
  light: { name: "light", grid: "#51607a", gridOpacity: 0.22, ground: "#dfe6ee", groundOpacity: 0.75, shadow: 0.26, sky: "#ffffff", floor: "#c9d2de", light: 1, joint: "#1d2733", gravity: "#66758a" },
  dark: { name: "dark", grid: "#a9bbd6", gridOpacity: 0.17, ground: "#273140", groundOpacity: 0.75, shadow: 0.5, sky: "#e8f0ff", floor: "#4a5568", light: 0.95, joint: "#f2f6fc", gravity: "#a9b8cc" },
  contrast: { name: "contrast", grid: "#ffffff", gridOpacity: 0.45, ground: "#000000", groundOpacity: 0, shadow: 0, sky: "#ffffff", floor: "#9aa4b2", light: 1.1, joint: "#ffff00", gravity: "#ffffff" },
};
