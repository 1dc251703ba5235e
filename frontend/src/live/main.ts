/** The page of a mechanism that it simulates: its data, and what it says where these are damaged. */

import { DataError } from "../viewer";
import { decodeData } from "../player/data";
import { create } from "../player/dom";
import "../player/style.css";
import "./style.css";
import { LivePage, type Formulas } from "./live_page";
import { readLive, type Simulation } from "./simulation";

declare global {
  interface Window {
    symbodySimulation?: () => Simulation;
    symbodyLive?: LivePage;
  }
}

function start(): void {
  const root = document.getElementById("symbody");
  const holder = document.getElementById("symbody-data");
  if (root === null || holder === null) return;
  try {
    const value = JSON.parse(holder.textContent) as Record<string, unknown> | null;
    const data = decodeData(value);
    const live = readLive(value?.["live"]);
    if (window.symbodySimulation === undefined) throw new DataError("page", "its simulation is missing");
    document.title = data.title;
    window.symbodyLive = new LivePage(root, data, value?.["scene"], live, window.symbodySimulation, readFormulas());
  } catch (error) {
    root.append(damaged(error));
  }
}

/** Return the children of the template: one for each slider, then the equations. */
function readFormulas(): Formulas {
  const template = document.getElementById("symbody-formulas");
  const children = template instanceof HTMLTemplateElement ? Array.from(template.content.children) : [];
  return { symbols: children.filter((each) => each.localName === "span"), equations: children.find((each) => each.localName === "div") ?? null };
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
