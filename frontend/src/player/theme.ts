/** The theme that a choice and the system's preferences result in. */

import type { ThemeChoice, ThemeName } from "../viewer";

const QUERIES = ["(prefers-color-scheme: dark)", "(prefers-contrast: more)", "(forced-colors: active)"] as const;

/** Return the theme of a choice now. */
export function resolveTheme(choice: ThemeChoice, matches: (query: string) => boolean = matchesMedia): ThemeName {
  if (choice !== "auto") return choice;
  const dark = matches("(prefers-color-scheme: dark)");
  // With forced colours the canvas is the system's: a palette for a black one cannot be read on white.
  if (matches("(forced-colors: active)") ? dark : matches("(prefers-contrast: more)")) return "contrast";
  return dark ? "dark" : "light";
}

/** Call back when the system's preferences change; return what ends it. */
export function followTheme(change: () => void): () => void {
  const lists = QUERIES.map((query) => window.matchMedia(query));
  for (const list of lists) list.addEventListener("change", change);
  return () => { for (const list of lists) list.removeEventListener("change", change); };
}

export function prefersReducedMotion(): boolean {
  return matchesMedia("(prefers-reduced-motion: reduce)");
}

function matchesMedia(query: string): boolean {
  return typeof window.matchMedia === "function" && window.matchMedia(query).matches;
}
