/** Which key does what. */

export const COMMANDS = {
  playPause: "Play or pause",
  stepBack: "A step back",
  stepForward: "A step forward",
  leapBack: "Ten steps back",
  leapForward: "Ten steps forward",
  toStart: "To the start",
  toEnd: "To the end",
  slower: "Slower",
  faster: "Faster",
  loop: "Loop",
  fit: "Show all",
  front: "View from the front",
  top: "View from the top",
  right: "View from the right",
  isometric: "Isometric view",
  orbitLeft: "Rotate left",
  orbitRight: "Rotate right",
  orbitUp: "Rotate up",
  orbitDown: "Rotate down",
  panLeft: "Pan left",
  panRight: "Pan right",
  panUp: "Pan up",
  panDown: "Pan down",
  zoomIn: "Nearer",
  zoomOut: "Farther",
  follow: "Follow the selected body or the mechanism",
  frames: "Frames on or off",
  joints: "Joints on or off",
  labels: "Names on or off",
  grid: "Ground on or off",
  vectors: "Forces and torques on or off",
  traces: "Traces on or off",
  ghosts: "Ghosts on or off",
  look: "Solid, transparent, wire",
  theme: "Light, dark, high contrast",
  curves: "Curves on or off",
  help: "This list",
  escape: "Close, or clear the selection",
} as const;

export type Command = keyof typeof COMMANDS;

/** Keys as `KeyboardEvent.key` has them; "Shift+" and "Ctrl+" only before arrows. */
export const KEYS: Readonly<Record<string, Command>> = {
  " ": "playPause",
  k: "playPause",
  ArrowLeft: "stepBack",
  ArrowRight: "stepForward",
  PageUp: "leapBack",
  PageDown: "leapForward",
  Home: "toStart",
  End: "toEnd",
  "[": "slower",
  "]": "faster",
  o: "loop",
  f: "fit",
  "1": "front",
  "2": "top",
  "3": "right",
  "4": "isometric",
  "Shift+ArrowLeft": "orbitLeft",
  "Shift+ArrowRight": "orbitRight",
  "Shift+ArrowUp": "orbitUp",
  "Shift+ArrowDown": "orbitDown",
  "Ctrl+ArrowLeft": "panLeft",
  "Ctrl+ArrowRight": "panRight",
  "Ctrl+ArrowUp": "panUp",
  "Ctrl+ArrowDown": "panDown",
  "+": "zoomIn",
  "=": "zoomIn",
  "-": "zoomOut",
  w: "follow",
  a: "frames",
  j: "joints",
  n: "labels",
  d: "grid",
  v: "vectors",
  t: "traces",
  g: "ghosts",
  x: "look",
  m: "theme",
  c: "curves",
  "?": "help",
  Escape: "escape",
};

export interface KeyPress {
  readonly key: string;
  readonly shiftKey: boolean;
  readonly ctrlKey: boolean;
  readonly metaKey: boolean;
  readonly altKey: boolean;
}

/** What the key is pressed on: keys that it uses itself are left to it. */
export type KeyTarget = "page" | "button" | "timeline" | "field" | "text";

const ITS_OWN: Record<KeyTarget, RegExp> = {
  page: /^$/,
  button: /^( |Enter)$/,
  timeline: /^$/,
  field: /^( |Arrow.*|Home|End|Page.*)$/,
  text: /^(?!Escape$)/,
};

/** Return what a key press means, or null. */
export function commandOf(press: KeyPress, target: KeyTarget): Command | null {
  if (press.altKey || ITS_OWN[target].test(press.key)) return null;
  const key = press.key.length === 1 ? press.key.toLowerCase() : press.key;
  const prefix = prefixOf(press);
  return prefix === null ? null : (KEYS[prefix + key] ?? null);
}

/** Return what stands before a key in `KEYS`, or null for what the browser does itself. */
function prefixOf({ key, ctrlKey, metaKey, shiftKey }: KeyPress): string | null {
  const arrow = key.startsWith("Arrow");
  if (ctrlKey || metaKey) return arrow ? "Ctrl+" : null;
  return arrow && shiftKey ? "Shift+" : "";
}

/** Return what kind of target an element is. */
export function targetOf(element: EventTarget | null): KeyTarget {
  if (!(element instanceof HTMLElement)) return "page";
  if (element.dataset["timeline"] !== undefined) return "timeline";
  if (element instanceof HTMLInputElement) return /^(text|search|number)$/.test(element.type) ? "text" : "field";
  if (element instanceof HTMLSelectElement || element.getAttribute("role") === "separator") return "field";
  return element instanceof HTMLButtonElement || element.tagName === "SUMMARY" ? "button" : "page";
}

/** Return how a command's keys are written in lists and tips. */
export function keysOf(command: Command): string[] {
  const names: Record<string, string> = {
    " ": "Space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc",
  }; // prettier-ignore
  return Object.entries(KEYS)
    .filter(([, each]) => each === command)
    .map(([key]) => {
      const parts = key === "+" ? ["+"] : key.split("+");
      return parts.map((part) => names[part] ?? (part.length === 1 ? part.toUpperCase() : part)).join("+");
    });
}
