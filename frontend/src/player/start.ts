/** How a page begins: its data, what it makes of them, and what it says where they are damaged. */

import { decodeData, type PlayerData } from "./data";
import { create } from "./dom";

/** Show the data of the page; `value` is all that stands with them. */
export function startPage(show: (root: HTMLElement, data: PlayerData, value: Record<string, unknown> | null) => void): void {
  const root = document.getElementById("symbody");
  const holder = document.getElementById("symbody-data");
  if (root === null || holder === null) return;
  try {
    const value = JSON.parse(holder.textContent) as Record<string, unknown> | null;
    const data = decodeData(value);
    document.title = data.title;
    show(root, data, value);
  } catch (error) {
    root.append(damaged(error));
  }
}

function damaged(error: unknown): HTMLElement {
  const reason = error instanceof SyntaxError ? "its data are truncated or changed" : error instanceof Error ? error.message : String(error);
  return create(
    "div",
    { class: "sb-damaged", role: "alert" },
    create("h1", {}, "This page cannot be shown"),
    create("p", {}, `${reason}.`),
    create("p", {}, "Create it again with symbody, and copy the complete file."),
  );
}
