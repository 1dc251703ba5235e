import { beforeEach, describe, expect, it } from "vitest";
import { copySelection, paste, removeSelection, selectAll } from "../../src/builder/commands/editing";
import { nudge } from "../../src/builder/diagram/gestures";
import { entriesOf } from "../../src/builder/model/entries";
import { valueAt, withValue } from "../../src/builder/model/pointers";
import { acceptName } from "../../src/builder/rename_command";
import { edit, endGesture, historyLength, isDirty, redo, select, showDocument, undo, useStore } from "../../src/builder/store";
import { sliderCrank } from "./models";

const data = (): typeof sliderCrank => useStore.getState().data;

beforeEach(() => {
  showDocument({ document: "d", path: null, name: "crank", data: sliderCrank, fingerprint: null, problems: [], wires: [] });
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
    expect(acceptName("body/0", "Rod")).toBe(false);
    expect(acceptName("body/0", "a.b")).toBe(false);
    expect(acceptName("body/0", "")).toBe(false);
    expect(data()).toBe(sliderCrank);
    expect(acceptName("body/0", "Arm")).toBe(true);
    expect(historyLength()).toBe(1);
  });
});
