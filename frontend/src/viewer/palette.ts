/** Colours: of bodies, kinds of elements and themes. */

/** After Okabe and Ito: distinct with any colour vision. */
export const BODY_COLORS = [
  "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8c6bb1", "#b8a100",
] as const; // prettier-ignore

const GROUND = "#8a93a0";

export const CONNECTOR_COLORS = {
  spring: "#7a8594",
  damper: "#6b7787",
  rope: "#b08a57",
  actuator: "#c0504d",
  line: "#7a8594",
} as const;

export const VECTOR_COLORS = { force: "#d1352b", torque: "#8e44ad", reaction: "#0a8f8f" } as const;
export const HIGHLIGHT = "#ffe433";

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
  readonly sky: string;
  readonly floor: string;
  readonly light: number;
  readonly joint: string;
  readonly gravity: string;
}

export const THEMES: Record<ThemeName, Theme> = {
  light: { name: "light", grid: "#51607a", gridOpacity: 0.22, sky: "#ffffff", floor: "#c9d2de", light: 1, joint: "#1d2733", gravity: "#66758a" },
  dark: { name: "dark", grid: "#a9bbd6", gridOpacity: 0.17, sky: "#e8f0ff", floor: "#4a5568", light: 0.95, joint: "#f2f6fc", gravity: "#a9b8cc" },
  contrast: { name: "contrast", grid: "#ffffff", gridOpacity: 0.45, sky: "#ffffff", floor: "#9aa4b2", light: 1.1, joint: "#ffff00", gravity: "#ffffff" },
};
