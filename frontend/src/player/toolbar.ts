/** The buttons over the picture. */

import type { Scene, StateSource, Viewer } from "../viewer";
import type { CurvesPanel } from "./curves_panel";
import { displayPanel } from "./display_panel";
import { create } from "./dom";
import { iconButton } from "./icons";
import { COMMANDS, keysOf, type Command } from "./keys";
import { Popover } from "./popover";
import type { Settings } from "./settings";

const VIEWS = ["front", "top", "right", "isometric"] as const;

export interface Toolbar {
  readonly element: HTMLElement;
  /** Close what is open; return whether anything was. */
  close(): boolean;
  closeFor(path: readonly EventTarget[]): void;
}

/** What the buttons need of a player. */
interface Parts {
  readonly settings: Settings;
  readonly viewer: Viewer | null;
  readonly curves: CurvesPanel | null;
  savePicture(): void;
}

export function createToolbar(
  player: Parts,
  scene: Scene,
  source: StateSource,
  run: (command: Command) => void,
): Toolbar {
  const { settings } = player;
  const views = new Popover("views", "Views", viewButtons(run), cameraBox(player, "parallel", "Parallel projection"));
  const display = new Popover("display", "Display options", ...displayPanel(settings, scene, source));
  const popovers = player.viewer === null ? [] : [views, display];
  const curves = iconButton("curves", "Curves", "C", () => { run("curves"); });
  settings.follow((name) => {
    if (name === "curves") curves.setAttribute("aria-pressed", String(settings.values.curves));
  });
  const track = iconButton("track", "Track", "W", () => { run("follow"); });
  track.title = "The camera follows the selected body, or the whole mechanism (W)";
  settings.follow((name) => {
    if (name === "follow") track.setAttribute("aria-pressed", String(settings.values.follow));
  });
  const buttons = [
    ...(player.viewer === null ? [] : [iconButton("fit", "Show all", "F", () => { run("fit"); }), track]),
    ...popovers.map((each) => each.button),
    ...(player.curves === null ? [] : [curves]),
    ...(player.viewer === null ? [] : [iconButton("camera", "Save a picture", "", () => { player.savePicture(); })]),
    iconButton("theme", "Light, dark, high contrast", "M", () => { run("theme"); }),
    iconButton("help", "Keys and gestures", "?", () => { run("help"); }),
  ];
  const bar = create("div", { class: "sb-toolbar", role: "toolbar", "aria-label": "Picture" }, ...buttons);
  const element = create("div", { class: "sb-tools" }, bar, ...popovers.map((each) => each.panel));
  return {
    element,
    close: () => {
      const open = popovers.filter((each) => each.open);
      for (const each of open) each.toggle(false);
      return open.length > 0;
    },
    closeFor: (path) => { for (const each of popovers) each.closeFor(path); },
  };
}

function viewButtons(run: (command: Command) => void): HTMLElement {
  const buttons = VIEWS.map((view) => {
    const name = view === "isometric" ? "Isometric" : `${view.charAt(0).toUpperCase()}${view.slice(1)}`;
    const button = create("button", { type: "button", class: "sb-choice-button", title: COMMANDS[view] }, name, create("kbd", { "aria-hidden": "true" }, keysOf(view)[0] ?? ""));
    button.addEventListener("click", () => { run(view); });
    return button;
  });
  return create("div", { class: "sb-views" }, ...buttons);
}

function cameraBox({ settings }: Parts, setting: "parallel", label: string): HTMLElement {
  const box = create("input", { type: "checkbox" });
  box.addEventListener("change", () => { settings.set(setting, box.checked); });
  settings.follow((name) => {
    if (name === setting) box.checked = settings.values[setting];
  });
  return create("label", { class: "sb-check" }, box, create("span", {}, label));
}
