/** What a changed setting does to the picture and the page. */

import type { Player } from "./player";
import type { SettingValues } from "./settings";
import { resolveTheme } from "./theme";

const SHOWN = ["frames", "joints", "labels", "grid", "gravity", "force", "torque", "reaction"] as const;

export function applySetting(player: Player, name: keyof SettingValues): void {
  const { viewer, clock, settings, root } = player;
  const { values } = settings;
  const shown = SHOWN.find((each) => each === name);
  if (shown !== undefined) viewer?.show(shown, values[shown]);
  switch (name) {
    case "theme": {
      const theme = resolveTheme(values.theme);
      root.dataset["theme"] = theme;
      viewer?.setTheme(theme);
      player.curves?.repaint();
      break;
    }
    case "speed":
      clock.speed = values.speed > 0 ? values.speed : 1;
      break;
    case "loop":
      clock.loop = values.loop;
      break;
    case "curves":
      root.classList.toggle("sb-no-curves", !values.curves || player.curves === null);
      break;
    default:
      if (viewer !== null) applyToPicture(player, name);
  }
  player.wake();
}

function applyToPicture({ viewer, settings: { values } }: Player, name: keyof SettingValues): void {
  switch (name) {
    case "view":
      if (values.view !== "auto") viewer?.view(values.view, true);
      break;
    case "parallel":
      if (viewer !== null && viewer.rig.parallel !== values.parallel) viewer.rig.setParallel(values.parallel);
      break;
    case "look":
      viewer?.setLook(values.look);
      break;
    case "arrowFactor":
      viewer?.setArrowFactor(values.arrowFactor);
      break;
    case "ghosts":
      viewer?.setGhosts(values.ghosts);
      break;
    case "traces":
    case "traceMode":
      viewer?.setTraces(values.traces, values.traceMode);
      break;
    default:
  }
}
