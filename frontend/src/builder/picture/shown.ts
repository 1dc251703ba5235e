/** The player that is shown now; panels beside the picture reach it here. */

import type { CurvesPanel } from "../../player/curves_panel";
import type { Player } from "../../player/player";
import type { LiveSource, StateSource } from "../../viewer";

export interface Shown {
  readonly player: Player;
  readonly source: LiveSource;
  /** The stored samples under the live state. */
  readonly base: StateSource;
  readonly scene: string;
  readonly size: string;
  /** The model without its initial values: where they alone change the camera stays. */
  readonly mechanism: string;
}

export const pictureNow: { shown: Shown | null; curves: CurvesPanel | null } = { shown: null, curves: null };

declare global {
  interface Window {
    /** What tests look at. */
    symbodyPicture?: typeof pictureNow;
  }
}

export function keepPicture(shown: Shown | null): void {
  pictureNow.shown = shown;
  window.symbodyPicture = pictureNow;
}
