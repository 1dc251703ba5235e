/** What commands do to a player. */

import { Vector3 } from "three";
import { type Clock, roundDown, type ThemeChoice, tracePoints, VECTOR_GROUPS, type Viewer, type ViewName } from "../viewer";
import type { PlayerData } from "./data";
import { COMMANDS, type Command } from "./keys";
import type { Settings } from "./settings";
import type { Toolbar } from "./toolbar";
import { formatTime } from "./transport";

const TURN = Math.PI / 18;
const THEME_ORDER: readonly ThemeChoice[] = ["auto", "light", "dark", "contrast"];
const LOOK_ORDER = ["solid", "transparent", "wire"] as const;
const USUAL_GHOSTS = 5;

/** What commands need of a player. */
interface Commanded {
  readonly clock: Clock;
  readonly time: number;
  readonly data: PlayerData;
  readonly settings: Settings;
  readonly viewer: Viewer | null;
  readonly help: HTMLDialogElement;
  readonly toolbar: Toolbar;
  seek(time: number): void;
  setPlaying(playing: boolean): void;
  view(name: ViewName): void;
  select(element: null): void;
  say(text: string): void;
}

type Action = (player: Commanded) => string;

function step(count: number): Action {
  return (player) => {
    player.clock.pause();
    player.seek(player.time + count * roundDown(Math.max(player.clock.duration / 100, 1e-9)));
    return timeText(player);
  };
}

function timeText(player: Commanded): string {
  return `${formatTime(player.time, player.clock.duration)} seconds`;
}

function toggle(name: "frames" | "joints" | "labels" | "grid" | "curves" | "loop"): Action {
  return ({ settings }) => {
    settings.set(name, !settings.values[name]);
    return `${COMMANDS[name].replace(/ on or off$/, "")} ${settings.values[name] ? "on" : "off"}`;
  };
}

function look(name: "front" | "top" | "right" | "isometric"): Action {
  return (player) => {
    player.view(name);
    return COMMANDS[name];
  };
}

function camera(move: (rig: Viewer["rig"]) => void): Action {
  return ({ viewer }) => {
    if (viewer !== null) move(viewer.rig);
    return "";
  };
}

function next<T>(order: readonly T[], value: T): T {
  return order[(order.indexOf(value) + 1) % order.length]!;
}

const ACTIONS: Record<Command, Action> = {
  playPause: (player) => {
    player.setPlaying(!player.clock.playing);
    return player.clock.playing ? "Playing" : `Paused at ${timeText(player)}`;
  },
  stepBack: step(-1),
  stepForward: step(1),
  leapBack: step(-10),
  leapForward: step(10),
  toStart: (player) => { player.seek(player.clock.start); return timeText(player); },
  toEnd: (player) => { player.clock.pause(); player.seek(player.clock.end); return timeText(player); },
  slower: (player) => changeSpeed(player, -1),
  faster: (player) => changeSpeed(player, 1),
  loop: toggle("loop"),
  fit: ({ viewer }) => { viewer?.rig.fit(); return COMMANDS.fit; },
  front: look("front"),
  top: look("top"),
  right: look("right"),
  isometric: look("isometric"),
  orbitLeft: camera((rig) => { rig.orbit(TURN, 0); }),
  orbitRight: camera((rig) => { rig.orbit(-TURN, 0); }),
  orbitUp: camera((rig) => { rig.orbit(0, TURN); }),
  orbitDown: camera((rig) => { rig.orbit(0, -TURN); }),
  panLeft: camera((rig) => { rig.pan(-0.06, 0); }),
  panRight: camera((rig) => { rig.pan(0.06, 0); }),
  panUp: camera((rig) => { rig.pan(0, 0.06); }),
  panDown: camera((rig) => { rig.pan(0, -0.06); }),
  zoomIn: camera((rig) => { rig.zoom(1.15); }),
  zoomOut: camera((rig) => { rig.zoom(1 / 1.15); }),
  follow: ({ settings }) => {
    settings.set("follow", !settings.values.follow);
    return settings.values.follow ? "The camera follows" : "The camera stands still";
  },
  frames: toggle("frames"),
  joints: toggle("joints"),
  labels: toggle("labels"),
  grid: toggle("grid"),
  curves: toggle("curves"),
  vectors: ({ settings }) => {
    const on = !(VECTOR_GROUPS.some((group) => settings.values[group]));
    for (const group of VECTOR_GROUPS) settings.set(group, on);
    return `Forces and torques ${on ? "on" : "off"}`;
  },
  traces: (player) => toggleTraces(player),
  ghosts: ({ settings }) => {
    settings.set("ghosts", settings.values.ghosts > 0 ? 0 : USUAL_GHOSTS);
    return settings.values.ghosts > 0 ? `${settings.values.ghosts} ghosts` : "No ghosts";
  },
  look: ({ settings }) => { settings.set("look", next(LOOK_ORDER, settings.values.look)); return `Bodies ${settings.values.look}`; },
  theme: ({ settings }) => { settings.set("theme", next(THEME_ORDER, settings.values.theme)); return `Colours ${settings.values.theme}`; },
  help: ({ help }) => {
    if (help.open) help.close();
    else help.showModal();
    return "";
  },
  escape: (player) => {
    if (!player.toolbar.close()) player.select(null);
    return "";
  },
};

export function runCommand(player: Commanded, command: Command): void {
  const text = ACTIONS[command](player);
  if (text !== "") player.say(text);
}

function changeSpeed(player: Commanded, direction: 1 | -1): string {
  player.clock.changeSpeed(direction);
  player.settings.set("speed", player.clock.speed);
  return `Speed ${player.clock.speed}`;
}

/** With nothing chosen, the frame of each body that is farthest from its centre of mass, up to eight. */
function toggleTraces({ settings, data }: Commanded): string {
  if (settings.values.traces.length > 0) {
    settings.set("traces", []);
    return "No traces";
  }
  const farthest = new Map<number, { name: string; far: number }>();
  for (const { name, anchor } of tracePoints(data.scene)) {
    const far = new Vector3(...anchor.at).length();
    const before = farthest.get(anchor.body);
    if (before === undefined || far > before.far) farthest.set(anchor.body, { name, far });
  }
  const names = [...farthest.values()].slice(0, 8).map((each) => each.name);
  settings.set("traces", names);
  return `${names.length} traces`;
}
