/** First values that hold when loops are closed, and those that are guesses. */

import { act, createElement } from "react";
import { createRoot, type Root } from "react-dom/client";
import { afterEach, beforeEach, describe, expect, it } from "vitest";
import { isExact, withInitial, withPriority } from "../../src/builder/model/initial";
import { valueAt } from "../../src/builder/model/pointers";
import { ModelPanel } from "../../src/builder/panels/model_panel";
import { historyLength, showDocument, undo, useStore } from "../../src/builder/store";
import { elements, schema, sliderCrank } from "./models";

const MODEL = { ...sliderCrank, initial: { theta: "60 deg" } };

describe("priorities of initial values", () => {
  it("are written as a table only where a value is exact", () => {
    const exact = withPriority(MODEL, "theta", true);
    expect(exact["initial"]).toEqual({ theta: { value: "60 deg", priority: "hold" } });
    expect(isExact(valueAt(exact, "/initial/theta"))).toBe(true);
    expect(withPriority(exact, "theta", false)).toEqual(MODEL);
    expect(withPriority(exact, "theta", true)).toEqual(exact);
  });

  it("stay where a pose gives another value", () => {
    const moved = withInitial(withPriority(MODEL, "theta", true), { theta: Math.PI / 2 }, { theta: Math.PI / 3 });
    expect(moved["initial"]).toEqual({ theta: { value: "90 deg", priority: "hold" } });
  });
});

describe("the choice beside an initial value", () => {
  let root: Root;
  let place: HTMLElement;

  beforeEach(() => {
    (globalThis as { IS_REACT_ACT_ENVIRONMENT?: boolean }).IS_REACT_ACT_ENVIRONMENT = true;
    useStore.setState({ schema: { schema, elements } });
    showDocument({ document: "d", path: null, name: "crank", data: MODEL, fingerprint: null, problems: [], comments: {}, wires: [] });
    place = document.body.appendChild(document.createElement("div"));
    root = createRoot(place);
    act(() => { root.render(createElement(ModelPanel)); });
  });

  afterEach(() => {
    act(() => { root.unmount(); });
    place.remove();
  });

  it("has a label, changes the file in one step, and leaves the value to its field", () => {
    const choice = (): HTMLSelectElement => place.querySelector<HTMLSelectElement>('select[aria-label="Priority of theta"]')!;
    expect(choice().value).toBe("guess");
    act(() => {
      choice().value = "exact";
      choice().dispatchEvent(new Event("change", { bubbles: true }));
    });
    expect(useStore.getState().data["initial"]).toEqual({ theta: { value: "60 deg", priority: "hold" } });
    expect(choice().value).toBe("exact");
    expect(place.querySelector<HTMLInputElement>('input[aria-label="theta"]')!.value).toBe("60 deg");
    expect(historyLength()).toBe(1);
    act(() => { undo(); });
    expect(useStore.getState().data).toEqual(MODEL);
    expect(choice().value).toBe("guess");
  });

  it("is not beside parameters", () => {
    expect(place.querySelectorAll('[data-testid="initial"] select')).toHaveLength(1);
    expect(place.querySelectorAll('[data-testid="parameters"] select')).toHaveLength(0);
  });
});
