/** Icons as inline drawings: no font has to have them. */

import { create, createSvg } from "./dom";

const PATHS = {
  play: "M8 5.5v13l11-6.5z",
  pause: "M8 5.5v13M16 5.5v13",
  stepBack: "M17 6l-8 6 8 6zM6.5 6v12",
  stepForward: "M7 6l8 6-8 6zM17.5 6v12",
  toStart: "M18.5 6l-6.5 6 6.5 6M11.5 6L5 12l6.5 6",
  loop: "M17 3.5l3 3-3 3M20 6.5H8a4 4 0 0 0-4 4v1M7 20.5l-3-3 3-3M4 17.5h12a4 4 0 0 0 4-4v-1",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5M9.5 9.5h5v5h-5z",
  track: "M12 8.5a3.5 3.5 0 1 0 0 7a3.5 3.5 0 1 0 0-7M12 3v3.5M12 17.5V21M3 12h3.5M17.5 12H21",
  views: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM12 12l8-4.5M12 12v9M12 12L4 7.5",
  display: "M4 7h9M17 7h3M4 17h3M11 17h9M15 4.8v4.4M9 14.8v4.4",
  curves: "M4 4v16h16M7 15c2-8 4-8 6-3s4 3 6-4",
  theme: "M12 4v2M12 18v2M4 12h2M18 12h2M6.3 6.3l1.4 1.4M16.3 16.3l1.4 1.4M6.3 17.7l1.4-1.4M16.3 7.7l1.4-1.4M12 8.5a3.5 3.5 0 1 0 0 7a3.5 3.5 0 1 0 0-7",
  camera: "M4 8h3.5L9 5.5h6L16.5 8H20v11H4zM12 10a3.2 3.2 0 1 0 0 6.4a3.2 3.2 0 1 0 0-6.4",
  help: "M9 9.2a3 3 0 1 1 4.3 2.7c-.9.5-1.3 1-1.3 2.1M12 17.2v.3",
  fullscreen: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  close: "M6 6l12 12M18 6L6 18",
  table: "M4 5h16v14H4zM4 10h16M4 14.5h16M10 5v14",
  zoomOut: "M10.5 4.5a6 6 0 1 0 0 12a6 6 0 1 0 0-12M15 15l5 5M7.5 10.5h6",
} as const;

export type IconName = keyof typeof PATHS;

/** Return the drawing of an icon; it has no name for screen readers, its button has. */
export function icon(name: IconName): SVGElement {
  const filled = name === "play";
  return createSvg(
    "svg",
    { viewBox: "0 0 24 24", width: 20, height: 20, "aria-hidden": "true", focusable: "false", class: filled ? "sb-icon sb-filled" : "sb-icon" },
    createSvg("path", { d: PATHS[name] }),
  );
}

/** Return a button with an icon and a name that screen readers say and pointers see. */
export function iconButton(name: IconName, label: string, key: string, act: () => void): HTMLButtonElement {
  const title = key === "" ? label : `${label} (${key})`;
  const button = create("button", { type: "button", class: "sb-button", "aria-label": label, title }, icon(name));
  button.addEventListener("click", act);
  return button;
}
