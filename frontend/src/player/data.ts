/** What a page gets: a scene, its motion, a title and options. */

import { DataError, decodeMotion, decodeScene, sourceOf, type Scene, type StateSource } from "../viewer";
import { settingsFrom, type SettingValues } from "./settings";

export interface PlayerData {
  readonly scene: Scene;
  readonly source: StateSource;
  readonly title: string;
  readonly settings: SettingValues;
}

/** Return checked data of a JSON value, or throw a `DataError`. */
export function decodeData(value: unknown): PlayerData {
  if (typeof value !== "object" || value === null) throw new DataError("data", "this page has no mechanism");
  const { scene: sceneValue, motion, title, options } = value as Record<string, unknown>;
  const scene = decodeScene(sceneValue);
  const moved = motion === null || motion === undefined ? null : decodeMotion(motion, scene.bodies.length);
  return {
    scene,
    source: sourceOf(scene, moved),
    title: typeof title === "string" && title !== "" ? title : scene.name,
    settings: settingsFrom(options, scene.bodies.length - 1),
  };
}
