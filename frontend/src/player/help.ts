/** The list of keys. */

import { create } from "./dom";
import { icon } from "./icons";
import { COMMANDS, keysOf, type Command } from "./keys";

const HINTS = [
  ["Drag", "Rotate"],
  ["Right drag, or Shift + drag", "Pan"],
  ["Wheel, or two fingers", "Zoom"],
  ["Click a part", "Select it"],
  ["Drag across a plot", "Zoom in; double-click shows all"],
] as const;

export function helpDialog(): HTMLDialogElement {
  const close = create("button", { type: "button", class: "sb-button sb-small", "aria-label": "Close" }, icon("close"));
  const rows = (Object.keys(COMMANDS) as Command[]).map((command) =>
    create("div", {}, create("dt", {}, ...keysOf(command).flatMap((key, index) => [...(index > 0 ? [" "] : []), create("kbd", {}, key)])), create("dd", {}, COMMANDS[command])),
  );
  const hints = HINTS.map(([how, what]) => create("div", {}, create("dt", {}, how), create("dd", {}, what)));
  const dialog = create(
    "dialog",
    { class: "sb-help", "aria-label": "Keys and gestures" },
    create("div", { class: "sb-help-head" }, create("h2", {}, "Keys and gestures"), close),
    create("div", { class: "sb-help-body", tabindex: 0 }, create("dl", {}, ...hints), create("dl", {}, ...rows)),
  );
  close.addEventListener("click", () => { dialog.close(); });
  return dialog;
}
