/** Schema, palette and models as the server sends them. */

import { fixtureValue } from "../fixture";
import type { JsonObject, Model, PaletteElement } from "../../src/builder/types";

interface Fixture {
  readonly schema: JsonObject;
  readonly elements: readonly PaletteElement[];
  readonly slider_crank: Model;
  readonly stewart_platform: Model;
}

export const { schema, elements, slider_crank: sliderCrank, stewart_platform: stewart } = fixtureValue("builder") as unknown as Fixture;

export function elementNamed(name: string): PaletteElement {
  return elements.find((each) => each.type === name || (each.type === "" && each.section === name))!;
}
