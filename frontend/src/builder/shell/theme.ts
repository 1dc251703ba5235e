/** Light, dark or high contrast. */

import { useEffect, useState } from "react";
import { followTheme, resolveTheme } from "../../player/theme";
import type { ThemeName } from "../../viewer";
import { pictureNow } from "../picture/shown";
import { useStore, type ThemeChoice } from "../store";

const KEY = "symbody-theme";
const ORDER: readonly ThemeChoice[] = ["auto", "light", "dark", "contrast"];

export function resolvedTheme(choice: ThemeChoice): ThemeName {
  return resolveTheme(choice);
}

export function rememberedTheme(): ThemeChoice {
  const kept = localStorage.getItem(KEY);
  return ORDER.find((each) => each === kept) ?? "auto";
}

export function nextTheme(): void {
  const { theme } = useStore.getState();
  const next = ORDER[(ORDER.indexOf(theme) + 1) % ORDER.length]!;
  localStorage.setItem(KEY, next);
  useStore.setState({ theme: next, spoken: `Colours: ${next}` });
}

/** Return the theme that is shown, which follows the choice and, where that is "auto", the system. */
export function useShownTheme(): ThemeName {
  const theme = useStore((state) => state.theme);
  const [, follow] = useState(0);
  useEffect(() => followTheme(() => { follow((count) => count + 1); }), []);
  return resolvedTheme(theme);
}

/** Put the theme on the page and its picture. */
export function useTheme(): void {
  const name = useShownTheme();
  useEffect(() => {
    document.documentElement.dataset["theme"] = name;
    pictureNow.shown?.player.settings.set("theme", name);
  }, [name]);
}
