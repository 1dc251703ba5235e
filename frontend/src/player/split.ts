/** The bar between the picture and the curves: dragged or moved by keys, remembered. */

import { create } from "./dom";

const KEY = "symbody.curves";
const LEAST = 12; // percent of the height
const MOST = 75;

/** Return the bar; `apply` gets the percentage of the height that the curves take. */
export function splitBar(root: HTMLElement, apply: (percent: number) => void): HTMLElement {
  const bar = create("div", {
    class: "sb-split", role: "separator", tabindex: 0, "aria-orientation": "horizontal", "aria-label": "Height of the curves",
    "aria-valuemin": LEAST, "aria-valuemax": MOST,
  }); // prettier-ignore
  let percent = 0;
  const set = (value: number): void => {
    percent = Math.min(MOST, Math.max(LEAST, value));
    bar.setAttribute("aria-valuenow", percent.toFixed(0));
    apply(percent);
  };
  bar.addEventListener("pointerdown", (event) => { bar.setPointerCapture(event.pointerId); });
  bar.addEventListener("pointermove", (event) => {
    if (!bar.hasPointerCapture(event.pointerId)) return;
    const area = root.getBoundingClientRect();
    set((100 * (area.bottom - event.clientY)) / area.height);
  });
  bar.addEventListener("pointerup", () => { remember(percent); });
  bar.addEventListener("keydown", (event) => {
    const direction = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (direction === 0 || event.shiftKey || event.ctrlKey) return;
    event.preventDefault();
    set(percent + 3 * direction);
    remember(percent);
  });
  set(remembered());
  return bar;
}

function remember(percent: number): void {
  try {
    localStorage.setItem(KEY, percent.toFixed(1));
  } catch {
    // a page in a sandbox has no storage; the height is not remembered
  }
}

function remembered(): number {
  try {
    return Number(localStorage.getItem(KEY) ?? "34") || 34;
  } catch {
    return 34;
  }
}
