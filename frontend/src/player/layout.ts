/** Classes that say how much room a player has; it may be a part of a page, so the window's size is no guide. */

import type { Covered } from "../viewer";

const NARROW = 680; // pixels
const LOW = 480;
const BESIDE = 560; // the least width in which curves fit beside a low picture
const TIGHT = 520; // of the picture: its toolbar takes the whole width
const CORNER = [184, 86] as const; // of the axes and gravity, which low players do not show

/** Return what of a picture lies under its toolbar and title, and in the corner of its axes and of gravity. */
export function coveredParts(stage: HTMLElement): Covered {
  const top = Math.min(stage.clientWidth <= TIGHT ? 86 : 40, 0.3 * stage.clientHeight);
  return { top, corner: stage.closest(".sb-low") === null ? CORNER : [0, 0] };
}

/** Keep the classes in step with the sizes; return what ends it. */
export function watchLayout(root: HTMLElement, stage: HTMLElement): () => void {
  const apply = (): void => {
    const { clientWidth: width, clientHeight: height } = root;
    if (width === 0) return;
    const low = height <= LOW && width >= BESIDE;
    root.classList.toggle("sb-low", low);
    root.classList.toggle("sb-narrow", width <= NARROW && !low);
    root.classList.toggle("sb-tight", stage.clientWidth <= TIGHT);
  };
  const watcher = new ResizeObserver(apply);
  watcher.observe(root);
  watcher.observe(stage);
  apply();
  return () => { watcher.disconnect(); };
}
