/** The page of a mechanism that it simulates. */

import { DataError } from "../viewer";
import { startPage } from "../player/start";
import "../player/style.css";
import "../../../src/symbody/display/maths.css";
import "./style.css";
import { LivePage, type Formulas } from "./live_page";
import { readLive, type Simulation } from "./simulation";

declare global {
  interface Window {
    symbodySimulation?: () => Simulation;
    symbodyLive?: LivePage;
  }
}

/** Return the children of the template: one for each slider, then the equations. */
function readFormulas(): Formulas {
  const template = document.getElementById("symbody-formulas");
  const children = template instanceof HTMLTemplateElement ? Array.from(template.content.children) : [];
  return { symbols: children.filter((each) => each.localName === "span"), equations: children.find((each) => each.localName === "div") ?? null };
}

startPage((root, data, value) => {
  const live = readLive(value?.["live"]);
  if (window.symbodySimulation === undefined) throw new DataError("page", "its simulation is missing");
  window.symbodyLive = new LivePage(root, data, value?.["scene"], live, window.symbodySimulation, readFormulas());
});
