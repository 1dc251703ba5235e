/** The page of a motion: the player. */

import { Player } from "./player";
import { startPage } from "./start";
import "./style.css";

declare global {
  interface Window {
    symbodyPlayer?: Player;
  }
}

startPage((root, data) => {
  window.symbodyPlayer = new Player(root, data, { keysFrom: document, embedded: window.self !== window.top });
});
