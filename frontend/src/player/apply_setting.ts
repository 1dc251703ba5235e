/** What a changed setting does to the picture and the page. */

import type { Clock, Viewer } from "../viewer";
import type { CurvesPanel } from "./curves_panel";
import type { Settings, SettingValues } from "./settings";
import { resolveTheme } from "./theme";
import type { Triad } from "./triad";

/** The parts of a player that settings change. */
interface Parts {
  readonly root: HTMLElement;
  readonly clock: Clock;
  readonly settings: Settings;
  readonly viewer: Viewer | null;
  readonly curves: CurvesPanel | null;
  readonly triad: Triad;
  wake(): void;
}

type Name = keyof SettingValues;

const SHOWN = ["frames", "joints", "labels", "grid", "force", "torque", "contact", "reaction", "footprints"] as const;

const IN_PICTURE: Partial<Record<Name, (viewer: Viewer, values: SettingValues) => void>> = {
  view: (viewer, { view }) => {
    if (view !== "auto") viewer.view(view, true);
  },
  parallel: (viewer, { parallel }) => {
    if (viewer.rig.parallel !== parallel) viewer.rig.setParallel(parallel);
  },
  follow: (viewer, { follow }) => { viewer.setFollow(follow); },
  look: (viewer, { look }) => { viewer.setLook(look); },
  arrowFactor: (viewer, { arrowFactor }) => { viewer.setArrowFactor(arrowFactor); },
  ghosts: (viewer, { ghosts }) => { viewer.setGhosts(ghosts); },
  traces: (viewer, { traces, traceMode }) => { viewer.setTraces(traces, traceMode); },
  traceMode: (viewer, { traces, traceMode }) => { viewer.setTraces(traces, traceMode); },
  ...Object.fromEntries(
    SHOWN.map((name) => [name, (viewer: Viewer, values: SettingValues) => { viewer.show(name, values[name]); }]),
  ),
};

const IN_PAGE: Partial<Record<Name, (player: Parts, values: SettingValues) => void>> = {
  theme: (player, values) => {
    const theme = resolveTheme(values.theme);
    player.root.dataset["theme"] = theme;
    player.viewer?.setTheme(theme);
    player.curves?.repaint();
  },
  speed: ({ clock }, { speed }) => { clock.speed = speed > 0 ? speed : 1; },
  loop: ({ clock }, { loop }) => { clock.loop = loop; },
  gravity: ({ triad }, { gravity }) => { triad.showGravity(gravity); },
  curves: ({ root, curves }, values) => { root.classList.toggle("sb-no-curves", !values.curves || curves === null); },
};

/** Settings that a new scene does not have by itself. */
export const OF_SCENE: readonly Name[] = ["theme", "gravity", "look", ...SHOWN, "arrowFactor", "ghosts", "traces"];

export function applySetting(player: Parts, name: Name): void {
  const { values } = player.settings;
  IN_PAGE[name]?.(player, values);
  if (player.viewer !== null) IN_PICTURE[name]?.(player.viewer, values);
  player.wake();
}
