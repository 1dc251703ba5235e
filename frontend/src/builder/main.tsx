/** The page of the builder. */

import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { problemsOf } from "./api";
import { App } from "./app";
import { followChanges, seekServer } from "./checking";
import { takeKey } from "./commands/all";
import { keepDrafts } from "./commands/drafts";
import { openModel, watchFile } from "./commands/files";
import { loadSchema } from "./commands/insert";
import { counts } from "./shell/counts";
import { rememberedTheme } from "./shell/theme";
import { historyLength, isDirty, useStore } from "./store";
import "../../../src/symbody/display/maths.css";
import "./style/page.css";
import "./style/diagram.css";
import "./style/panels.css";

declare global {
  interface Window {
    /** What tests look at. */
    symbodyBuilder?: { state: typeof useStore.getState; steps: typeof historyLength; counts: typeof counts };
  }
}

function start(): void {
  const root = document.getElementById("root");
  if (root === null) return;
  useStore.setState({ theme: rememberedTheme() });
  window.symbodyBuilder = { state: useStore.getState, steps: historyLength, counts };
  followChanges();
  seekServer();
  keepDrafts();
  watchFile();
  window.addEventListener("keydown", takeKey);
  window.addEventListener("beforeunload", (event) => { if (isDirty(useStore.getState())) event.preventDefault(); });
  loadSchema().catch((error: unknown) => { useStore.setState({ notice: problemsOf(error) }); });
  const path = new URLSearchParams(location.hash.slice(1)).get("open");
  if (path !== null && path !== "") void openModel({ path });
  createRoot(root).render(<StrictMode><App /></StrictMode>);
}

start();
