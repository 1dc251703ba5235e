/** Angles of curves: radians or degrees, counted on or wrapped to one turn. */

import { describe, expect, it } from "vitest";
import { inView, rememberAngles, rememberedAngles, wrapped } from "../src/player/angles";
import { groupCurves, toCsv, valueAt } from "../src/player/curve_table";

const times = new Float64Array([0, 1]);
const curve = (unit: string, ...values: number[]): { name: string; unit: string; values: Float32Array } => ({ name: "a", unit, values: new Float32Array(values) });

describe("angles", () => {
  it("are within half a turn of zero where they are wrapped", () => {
    const degrees = [-540, -181, -180, -179, 0, 180, 181, 360, 3610];
    expect(degrees.map((each) => wrapped(each, 360))).toEqual([180, 179, 180, -179, 0, 180, -179, 0, 10]);
  });

  it("and their rates are shown in degrees, all else as it is", () => {
    const shown = [curve("rad", 8), curve("rad/s", 8), curve("rad/s^2", 8), curve("deg", 400), curve("N m/rad", 8), curve("m", 8)].map((each) => inView(each, { degrees: true, wrap: true }));
    expect(shown.map((each) => each.unit)).toEqual(["deg", "deg/s", "deg/s^2", "deg", "N m/rad", "m"]);
    const full = (8 * 180) / Math.PI;
    [full - 360, full, full, 40, 8, 8].forEach((value, k) => { expect(shown[k]!.values[0]).toBeCloseTo(value, 4); }); // single precision
  });

  it("are untouched at first", () => {
    const raw = curve("rad", 80, -7);
    const [group] = groupCurves([raw], rememberedAngles());
    expect(group!.turn).toBe(0);
    expect(group!.curves[0]!.values).toEqual(raw.values);
  });

  it("have values on the shorter way between samples, where the line ends and begins anew", () => {
    const [group] = groupCurves([curve("deg", 170, 210)], { degrees: true, wrap: true });
    const at = (time: number): number => valueAt(times, group!.curves[0]!.values, time, group!.turn);
    expect([at(0), at(0.25), at(0.5), at(1)]).toEqual([170, 180, -170, -150]);
  });

  it("are written to CSV as they are shown", () => {
    const [group] = groupCurves([curve("rad", Math.PI / 2, Math.PI)], { degrees: true, wrap: false });
    expect(toCsv(times, group!.curves).split("\r\n").slice(0, 3)).toEqual(["t [s],a [deg]", "0,90", "1,180"]);
  });

  it("are remembered", () => {
    rememberAngles({ degrees: true, wrap: false });
    expect(rememberedAngles()).toEqual({ degrees: true, wrap: false });
    localStorage.setItem("symbody-angles", "{ broken");
    expect(rememberedAngles()).toEqual({ degrees: false, wrap: false });
    localStorage.clear();
  });
});
