import { describe, expect, it, vi } from "vitest";
import { formatValue, groupCurves, toCsv, valueAt } from "../src/player/curve_table";
import { fileName } from "../src/player/dom";
import { commandOf, COMMANDS, KEYS, keysOf, targetOf, type Command, type KeyPress } from "../src/player/keys";
import { DEFAULTS, Settings } from "../src/player/settings";
import { resolveTheme } from "../src/player/theme";
import { formatTime } from "../src/player/transport";
import { createSliders, readSliders } from "../src/widget/sliders";

function press(key: string, change: Partial<KeyPress> = {}): KeyPress {
  return { key, shiftKey: false, ctrlKey: false, metaKey: false, altKey: false, ...change };
}

describe("keys", () => {
  it("reach every command, and every command has a text", () => {
    const reached = new Set(Object.values(KEYS));
    expect([...reached].sort()).toEqual(Object.keys(COMMANDS).sort());
  });

  it.each<[KeyPress, Command | null]>([
    [press(" "), "playPause"],
    [press("ArrowRight"), "stepForward"],
    [press("ArrowRight", { shiftKey: true }), "orbitRight"],
    [press("ArrowRight", { ctrlKey: true }), "panRight"],
    [press("ArrowRight", { metaKey: true }), "panRight"],
    [press("F"), "fit"],
    [press("?", { shiftKey: true }), "help"],
    [press("f", { ctrlKey: true }), null],
    [press("ArrowLeft", { altKey: true }), null],
    [press("q"), null],
  ])("%j means %s", (key, command) => {
    expect(commandOf(key, "page")).toBe(command);
  });

  it("leave to a control what it uses itself", () => {
    expect(commandOf(press(" "), "button")).toBeNull();
    expect(commandOf(press("ArrowRight"), "button")).toBe("stepForward");
    expect(commandOf(press("ArrowRight"), "field")).toBeNull();
    expect(commandOf(press("ArrowRight"), "timeline")).toBe("stepForward");
    expect(commandOf(press("f"), "text")).toBeNull();
    expect(commandOf(press("Escape"), "text")).toBe("escape");
  });

  it("know their target", () => {
    document.body.innerHTML = '<input type="search"><input type="range" data-timeline><select></select><button></button><p></p>';
    const targets = [...document.body.children].map((each) => targetOf(each));
    expect(targets).toEqual(["text", "timeline", "field", "button", "page"]);
  });

  it("are written for people", () => {
    expect(keysOf("playPause")).toEqual(["Space", "K"]);
    expect(keysOf("orbitLeft")).toEqual(["Shift+←"]);
    expect(keysOf("zoomIn")).toEqual(["+", "="]);
  });
});

describe("curves", () => {
  const times = new Float64Array([0, 1, 2]);
  const curve = (name: string, unit: string): { name: string; unit: string; values: Float32Array } => ({ name, unit, values: new Float32Array([0, 2, -1]) });

  it("stand in one panel for each unit", () => {
    const groups = groupCurves([curve("a", "m"), curve("b", "rad"), curve("c", "m")], { degrees: false, wrap: false });
    expect(groups.map((each) => [each.unit, each.curves.map((one) => one.name)])).toEqual([["m", ["a", "c"]], ["rad", ["b"]]]);
  });

  it("have values between samples", () => {
    expect(valueAt(times, curve("a", "").values, 1.5, 0)).toBe(0.5);
    expect(valueAt(times, curve("a", "").values, 9, 0)).toBe(-1);
  });

  it("are written as CSV", () => {
    const lines = toCsv(times, [curve("x, the first", "m"), curve('say "v"', "")]).split("\r\n");
    expect(lines[0]).toBe('t [s],"x, the first [m]","say ""v"""');
    expect(lines[2]).toBe("1,2,2");
    expect(lines).toHaveLength(5);
  });

  it.each([[0, "0.0000"], [-1.5, "−1.5000"], [123.456, "123.46"], [1e-5, "1.00e−5"], [2.5e7, "2.50e+7"]])("write %d as %s", (value, text) => {
    expect(formatValue(value)).toBe(text);
  });

  it("have as many digits of time as the range needs", () => {
    expect([formatTime(1.23456, 5), formatTime(1.23456, 50), formatTime(1.23456, 500)]).toEqual(["1.235", "1.23", "1.2"]);
  });
});

describe("settings", () => {
  it("are heard of once for each change", () => {
    const settings = new Settings({ ...DEFAULTS });
    const heard = vi.fn();
    settings.follow(heard);
    heard.mockClear();
    settings.set("ghosts", 3);
    settings.set("ghosts", 3);
    expect(heard.mock.calls).toEqual([["ghosts"]]);
  });

  it("follow the system where the theme is auto", () => {
    expect(resolveTheme("auto", () => false)).toBe("light");
    expect(resolveTheme("auto", (query) => query.includes("dark"))).toBe("dark");
    expect(resolveTheme("auto", (query) => query.includes("more"))).toBe("contrast");
    expect(resolveTheme("light", () => true)).toBe("light");
  });
});

describe("file names", () => {
  it("hold what every system takes", () => {
    expect(fileName("Top: a/b", ".csv")).toBe("Top_a_b.csv");
    expect(fileName("///", ".png")).toBe("symbody.png");
    expect(fileName("Kurbel größer", ".csv")).toBe("Kurbel_größer.csv");
  });
});

describe("sliders", () => {
  it("send what is chosen", () => {
    const change = vi.fn();
    const [row] = createSliders(readSliders([{ name: "m", min: 0, max: 10, value: 2, unit: "kg" }], { m: 4 }), change);
    const input = row!.querySelector("input")!;
    expect([input.value, row!.textContent]).toEqual(["4", "m4\u202fkg"]);
    input.value = "5";
    input.dispatchEvent(new Event("input"));
    expect(change).toHaveBeenCalledWith("m", 5);
  });

  it("leave out what is no range", () => {
    expect(readSliders([{ name: "m", min: 3, max: 3 }, null, { min: 0, max: 1 }], null)).toEqual([]);
  });
});
