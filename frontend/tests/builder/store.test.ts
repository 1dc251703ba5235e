import { beforeEach, describe, expect, it } from "vitest";
import { copySelection, paste, removeSelection, selectAll } from "../../src/builder/commands/editing";
import { nudge } from "../../src/builder/diagram/gestures";
import { entriesOf, entryNamed } from "../../src/builder/model/entries";
import { valueAt, withKey, withValue } from "../../src/builder/model/pointers";
import { renameCoordinate, renameInitial, renameParameter } from "../../src/builder/model/rename";
import { sentence } from "../../src/builder/panels/field_frame";
import { acceptFrameName, acceptKey, acceptName, acceptSymbol } from "../../src/builder/rename_command";
import { edit, endGesture, historyLength, isDirty, redo, select, showDocument, undo, useStore } from "../../src/builder/store";
import { elements, schema, sliderCrank } from "./models";

const data = (): typeof sliderCrank => useStore.getState().data;

beforeEach(() => {
  useStore.setState({ schema: { schema, elements } });
  showDocument({ document: "d", path: null, name: "crank", data: sliderCrank, fingerprint: null, problems: [], comments: {}, wires: [] });
});

describe("the history", () => {
  it("has one step for typing in one field", () => {
    for (const text of ["2", "2.", "2.5"]) edit((before) => withValue(before, "/body/0/mass", text), "field /body/0/mass");
    edit((before) => withValue(before, "/body/1/mass", "3"), "field /body/1/mass");
    expect(historyLength()).toBe(2);
    undo();
    expect(valueAt(data(), "/body/0/mass")).toBe("2.5");
    undo();
    expect(data()).toBe(sliderCrank);
    expect(isDirty(useStore.getState())).toBe(false);
    redo();
    expect(valueAt(data(), "/body/0/mass")).toBe("2.5");
  });

  it("begins a step anew when a field is left", () => {
    edit((before) => withValue(before, "/body/0/mass", "2"), "field /body/0/mass");
    endGesture();
    edit((before) => withValue(before, "/body/0/mass", "3"), "field /body/0/mass");
    expect(historyLength()).toBe(2);
  });

  it("removes a body with its joints in one step, and does not count selecting", () => {
    select(["body/1"]);
    removeSelection();
    expect(historyLength()).toBe(1);
    expect(entriesOf(data())).toHaveLength(4);
    undo();
    expect(data()).toBe(sliderCrank);
    selectAll();
    expect(historyLength()).toBe(0);
  });

  it("has one step for arrow keys in a row", () => {
    select(["body/0"]);
    nudge(10, 0);
    nudge(10, 0);
    expect(historyLength()).toBe(1);
  });

  it("removes with a joint the initial values of its coordinate, and brings both back", () => {
    select([entryNamed(data(), "D")!.id]);
    removeSelection();
    expect(Object.keys(data()["initial"] as object)).toEqual(["theta", "beta", "theta_dot"]);
    undo();
    expect(data()).toBe(sliderCrank);
    select([entryNamed(data(), "A")!.id]);
    removeSelection();
    expect(Object.keys(data()["initial"] as object)).toEqual(["beta", "s"]);
  });

  it("leaves nothing selected that is gone", () => {
    select(["body/0", "body/1"]);
    copySelection();
    paste();
    const pasted = useStore.getState().selection;
    expect(pasted).toHaveLength(3);
    undo();
    expect(useStore.getState().selection).toEqual([]);
  });
});

describe("names", () => {
  it("are refused where another element has them", () => {
    for (const name of ["Rod", "a.b", "", "ground", "12"]) expect(acceptName("body/0", name)).not.toBe("");
    expect(data()).toBe(sliderCrank);
    expect(acceptName("body/0", "Arm")).toBe("");
    expect(historyLength()).toBe(1);
  });

  it("of parameters and coordinates are refused where a formula would read something else in them", () => {
    const refused = ["0.4", "", "L2", "theta", "F", "pi", "t", "if", "2*L", "G G", "-1", "x".repeat(129)];
    for (const name of refused) {
      expect(acceptSymbol("G", name, renameParameter), name).not.toBe("");
      expect(acceptSymbol("theta", name === "theta" ? "G" : name, renameCoordinate), name).not.toBe("");
    }
    expect(data()).toBe(sliderCrank);
    for (const name of ["g", "sin", "γ", "αγ", "m_2", "e"]) {
      expect(acceptSymbol("G", name, renameParameter), name).toBe("");
      expect(valueAt(data(), "/gravity/1")).toBe(`-${name}`);
      expect(acceptSymbol(name, "G", renameParameter)).toBe("");
      expect(data()).toEqual(sliderCrank);
    }
  });

  it("of frames and keys never take another's place", () => {
    expect(acceptFrameName("body/0", "A", "B")).not.toBe("");
    expect(acceptKey(data()["initial"], "theta", "s", renameInitial)).not.toBe("");
    expect(data()).toBe(sliderCrank);
    expect(acceptFrameName("body/0", "A", "C")).toBe("");
    expect(Object.keys(valueAt(data(), "/body/0/frames") as object)).toEqual(["C", "B"]);
  });

  it("that are none in a damaged file change no number when they are mended", () => {
    const damaged = withValue(withKey(sliderCrank, "/parameters", "G", "0.4"), "/gravity/1", "-0.4");
    const mended = renameParameter(schema, damaged, "0.4", "G");
    expect(valueAt(mended, "/parameters/L1")).toBe(valueAt(sliderCrank, "/parameters/L1"));
    expect(valueAt(mended, "/gravity/1")).toBe("-0.4");
    expect(renameParameter(schema, withValue(sliderCrank, "/body/0/mass", "sin(1)*sin"), "sin", "k")).toMatchObject({ body: [{ mass: "sin(1)*k" }, {}, {}] });
  });
});

describe("sentences", () => {
  it("begin with a capital, unless a name of the model stands there", () => {
    expect(sentence("m1 has no value")).toBe("m1 has no value.");
    expect(sentence("theta turns")).toBe("theta turns.");
    expect(sentence("there is no symbol 'x'")).toBe("There is no symbol 'x'.");
    expect(sentence("'x' is no name")).toBe("'x' is no name.");
  });
});
