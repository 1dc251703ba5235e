/** Names of coordinates as they are read. */

import { describe, expect, it } from "vitest";
import { nameElement, plainReading, printedUnit, readName } from "../src/player/readable";

describe("names", () => {
  it.each([
    ["theta_1_ddot", "θ\u0308", "1"],
    ["beta2", "β", "2"],
    ["x_dot", "x\u0307", ""],
    ["omega_x", "ω", "x"],
    ["v_theta", "v", "θ"],
  ])("reads %s as a symbol", (name, base, index) => {
    expect(readName(name)).toEqual({ base, index, symbol: true });
  });

  it.each(["shoulder_pan_joint", "frame r P x", "lean", "2*x", "reaction pin Fx", "steer_dot"])("leaves %s as it is", (name) => {
    expect(plainReading(name)).toBe(name);
    expect(nameElement(name, {}).textContent).toBe(name);
  });

  it("sets indices below the line", () => {
    expect(nameElement("theta_1", {}).innerHTML).toBe("<i>θ</i><sub>1</sub>");
  });
});

describe("units", () => {
  it.each([["kg m^2", "kg·m²"], ["N m/rad", "N·m/rad"], ["N m s/rad", "N·m·s/rad"], ["N, N m", "N, N·m"], ["s^-1", "s⁻¹"], ["m", "m"], ["", ""]])("prints %s as %s", (unit, printed) => {
    expect(printedUnit(unit)).toBe(printed);
  });
});
