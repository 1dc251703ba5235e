/** The page: its data, the player, and what a page says whose data is damaged. */

import { decodeData } from "./data";
import { create } from "./dom";
import { Player } from "./player";
import "./style.css";

declare global {
  interface Window {
    symbodyPlayer?: Player;
  }
}

function start(): void {
  const root = document.getElementById("symbody");
  const holder = document.getElementById("symbody-data");
  if (root === null || holder === null) return;
  try {
    const data = decodeData(JSON.parse(holder.textContent));
    document.title = data.title;
    window.symbodyPlayer = new Player(root, data, { keysFrom: document });
  } catch (error) {
    root.append(damaged(error));
  }
}

function damaged(error: unknown): HTMLElement {
  const reason = error instanceof SyntaxError ? "its data are cut off or changed" : error instanceof Error ? error.message : String(error);
  return create(
    "div",
    { class: "sb-damaged", role: "alert" },
    create("h1", {}, "This page cannot be shown"),
    create("p", {}, `${reason}.`),
    create("p", {}, "Write it again with symbody, and copy the file as a whole."),
  );
}

start();
