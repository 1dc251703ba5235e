import { describe, expect, it } from "vitest";
import { curveTree, firstTicks, shortName } from "../../src/builder/model/curve_tree";
import { inPrint } from "../../src/player/readable";
import { converted, quantityOf, textIn } from "../../src/builder/model/quantities";
import { quaternionOf, turnsOf, type Turns } from "../../src/builder/model/turns";

describe("quantities", () => {
  it("are read with their units, or with the one that is shown", () => {
    expect(quantityOf("30 deg", "rad")).toBeCloseTo(Math.PI / 6, 15);
    expect(quantityOf("30", "rad", "deg")).toBeCloseTo(Math.PI / 6, 15);
    expect(quantityOf("0.5 rad", "rad", "deg")).toBe(0.5);
    expect(quantityOf("−40mm", "m")).toBeCloseTo(-0.04, 15);
    expect(quantityOf(".5", "m")).toBe(0.5);
    for (const wrong of ["", "a", "3 kg", "3 deg deg", "1e", "--1"]) expect(quantityOf(wrong, "m"), wrong).toBeNull();
    expect(quantityOf("1 m", "rad")).toBeNull();
  });

  it("are written with six digits, and read back", () => {
    expect(textIn(Math.PI / 6, "deg")).toBe("30");
    expect(textIn(-1e-15, "m")).toBe("0");
    expect(quantityOf(textIn(1.234567, "deg"), "rad", "deg")).toBeCloseTo(1.234567, 5);
  });

  it("in units that formulas do not know are converted, where the field can hold them", () => {
    expect(converted("40 mm", "m")).toEqual({ text: "0.04", note: "40 mm is 0.04 m." });
    expect(converted(" 300 g")).toMatchObject({ text: "0.3" });
    expect(converted("2.5in", "m")?.text).toBe("0.0635");
    for (const text of ["40", "L + 40 mm", "30 deg", "m", "2*m", "1 banana", ""]) expect(converted(text), text).toBeNull();
    expect(converted("40 mm", "kg")).toBeNull(); // the check says what is wrong
  });

  it("are printed with powers of ten", () => {
    expect([3e-8, -2e-9, 1e-10, 0, 12.34, 1.5e7].map((each) => inPrint(each))).toEqual(["3·10⁻⁸", "−2·10⁻⁹", "10⁻¹⁰", "0", "12", "1.5·10⁷"]);
  });
});

describe("turns", () => {
  /** The rotation about an axis, as a matrix, and their product: an independent way. */
  const about = (axis: number, angle: number): number[][] => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    const matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    matrix[i]![i] = c; matrix[j]![j] = c; matrix[i]![j] = -s; matrix[j]![i] = s;
    return matrix;
  };
  const times = (a: number[][], b: number[][]): number[][] => a.map((row) => [0, 1, 2].map((k) => row.reduce((sum, each, index) => sum + each * b[index]![k]!, 0)));
  const matrixOf = ([w, x, y, z]: readonly number[]): number[][] => {
    const [a, b, c, d] = [w!, x!, y!, z!];
    return [[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)], [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)], [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]];
  };

  it("are about x, the new y and the new z, there and back, also where the middle one is a quarter", () => {
    const cases: Turns[] = [[0, 0, 0], [0.3, -0.4, 1.2], [-2, 1, 3], [0.7, Math.PI / 2, 0], [0.7, -Math.PI / 2, 0]];
    for (const turns of cases) {
      const quaternion = quaternionOf(turns);
      const expected = times(times(about(0, turns[0]), about(1, turns[1])), about(2, turns[2]));
      matrixOf(quaternion).flat().forEach((each, index) => { expect(each).toBeCloseTo(expected.flat()[index]!, 12); });
      turnsOf(quaternion).forEach((each, index) => { expect(each).toBeCloseTo(turns[index]!, 7); });
    }
  });
});

describe("the tree of curves", () => {
  it("has headings in the order of the server, below them elements, and begins with positions and speeds", () => {
    const offered = [
      ["Positions", "", "theta", "s"], ["Speeds", "", "theta_dot", "s_dot"], ["Energies", "", "energy"], ["Reactions", "A", "reaction A Fx"],
      ["Reactions", "B pin", 'reaction "B pin" Mz', "reaction B pin Fx"],
    ].flatMap(([title = "", group = "", ...names]) => names.map((name) => ({ name, unit: "", title, group })));
    const tree = curveTree([...offered, { name: "sin(theta)", unit: "" }]);
    expect(tree.map(({ title, curves, branches }) => [title, ...curves.map((each) => each.name), ...branches.map((each) => each.title)])).toEqual([
      ["Positions", "theta", "s"], ["Speeds", "theta_dot", "s_dot"], ["Energies", "energy"], ["Reactions", "A", "B pin"], ["Others", "sin(theta)"],
    ]);
    expect(tree[3]?.branches[1]?.curves.map(shortName)).toEqual(["Mz", "Fx"]);
    expect(shortName({ name: "effort A", unit: "" })).toBe("effort A");
    expect(firstTicks(tree)).toEqual(["theta", "s", "theta_dot", "s_dot"]);
  });
});
