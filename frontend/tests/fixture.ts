import { readFileSync } from "node:fs";
import { decodeData, type PlayerData } from "../src/player/data";

/** Return the JSON value of a fixture, fresh each time. */
export function fixtureValue(name: string): Record<string, unknown> {
  const address = new URL(`../fixtures/${name}.json`, `file://${import.meta.filename}`);
  return JSON.parse(readFileSync(address, "utf8")) as Record<string, unknown>;
}

export function fixture(name: string): PlayerData {
  return decodeData(fixtureValue(name));
}
