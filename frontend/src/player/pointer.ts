/** The pointer over the picture: what it is on, and what a click selects. */

import type { Viewer } from "../viewer";

const STILL = 5; // pixels that a press may move and yet be a click

/** Follow the pointer; return what ends it. */
export function watchPointer(viewer: Viewer): () => void {
  const { canvas } = viewer;
  let pending = 0;
  let down: { x: number; y: number } | null = null;
  const move = (event: PointerEvent): void => {
    if (event.pointerType === "touch" || event.buttons !== 0) return;
    const { clientX, clientY } = event;
    cancelAnimationFrame(pending);
    pending = requestAnimationFrame(() => { canvas.style.cursor = viewer.pointAt(clientX, clientY) === null ? "" : "pointer"; });
  };
  const press = (event: PointerEvent): void => {
    down = event.button === 0 ? { x: event.clientX, y: event.clientY } : null;
    viewer.clearPointer();
  };
  const release = (event: PointerEvent): void => {
    if (down === null || Math.hypot(event.clientX - down.x, event.clientY - down.y) > STILL) return;
    viewer.select(viewer.elementAt(event.clientX, event.clientY));
  };
  const leave = (): void => {
    cancelAnimationFrame(pending);
    viewer.clearPointer();
  };
  canvas.addEventListener("pointermove", move);
  canvas.addEventListener("pointerdown", press);
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointerleave", leave);
  return () => {
    leave();
    canvas.removeEventListener("pointermove", move);
    canvas.removeEventListener("pointerdown", press);
    canvas.removeEventListener("pointerup", release);
    canvas.removeEventListener("pointerleave", leave);
  };
}
