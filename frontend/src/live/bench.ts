/** The panel beside the picture: buttons, numbers of the motion, sliders, equations. */

import { create, setText } from "../player/dom";
import { icon, type IconName } from "../player/icons";
import { inPrint, printedUnit } from "../player/readable";
import type { Control, Kind } from "./simulation";

const TITLES: Record<Kind, string> = { parameter: "Parameters", input: "Inputs", initial: "Starts from" };
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5] as const;

export interface BenchActions {
  togglePlaying(): void;
  step(): void;
  reset(): void;
  setSpeed(speed: number): void;
  change(control: Control, value: number): void;
}

export interface Readings {
  readonly time: number;
  readonly total: number;
  readonly change: number;
  readonly violation: number;
}

/** One slider with its number; `show` sets both without a change. */
class ControlRow {
  readonly element: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly number = create("span", { class: "sb-number" });

  constructor(readonly control: Control, symbol: Node | string, change: (value: number) => void) {
    const { name, min, max, value } = control;
    this.slider = create("input", { type: "range", min, max, step: (max - min) / 500, "aria-label": name });
    this.slider.addEventListener("input", () => {
      this.showNumber(Number(this.slider.value));
      change(Number(this.slider.value));
    });
    this.element = create("label", { class: "sb-slider" }, create("span", { class: "sb-symbol", title: name }, symbol), this.slider, this.number);
    this.show(value);
  }

  show(value: number): void {
    this.slider.value = String(value);
    this.showNumber(value);
  }

  mark(fails: boolean): void {
    this.element.classList.toggle("sb-fails", fails);
    if (fails) this.slider.setAttribute("aria-invalid", "true");
    else this.slider.removeAttribute("aria-invalid");
  }

  private showNumber(value: number): void {
    const { unit } = this.control;
    const text = `${shortNumber(value)}${unit === "" ? "" : `\u202f${printedUnit(unit)}`}`;
    setText(this.number, text);
    this.slider.setAttribute("aria-valuetext", text);
  }
}

export class Bench {
  readonly element: HTMLElement;
  readonly rows: readonly ControlRow[];
  private readonly play: HTMLButtonElement;
  private readonly readings: Record<keyof Readings, HTMLElement>;
  private readonly message = create("p", { class: "sb-note", role: "alert" });

  constructor(controls: readonly Control[], symbols: readonly Node[], equations: Node | null, hint: string, speed: number, actions: BenchActions) {
    this.play = button("play", "Play", "Space", () => { actions.togglePlaying(); });
    this.readings = { time: reading(), total: reading(), change: reading(), violation: reading() };
    this.rows = controls.map((control, k) => new ControlRow(control, symbols[k] ?? control.name, (value) => { actions.change(control, value); }));
    this.message.hidden = true;
    this.element = create(
      "aside",
      { class: "sb-player sb-bench", "aria-label": "Simulation" },
      create(
        "div",
        { class: "sb-buttons" },
        button("toStart", "Reset", "R", () => { actions.reset(); }),
        this.play,
        button("stepForward", "Step", ".", () => { actions.step(); }),
        speedChoice(speed, (chosen) => { actions.setSpeed(chosen); }),
      ),
      this.readingList(),
      this.message,
      ...this.groups(),
      ...(hint === "" ? [] : [create("p", { class: "sb-hint" }, hint)]),
      ...(equations === null ? [] : [create("details", { open: true }, create("summary", {}, "Equations"), create("div", { class: "sb-formulas", tabindex: 0, role: "region", "aria-label": "Equations" }, equations))]),
    );
  }

  showPlaying(playing: boolean): void {
    const label = playing ? "Pause" : "Play";
    if (this.play.getAttribute("aria-label") === label) return;
    this.play.setAttribute("aria-label", label);
    this.play.title = `${label} (Space)`;
    this.play.replaceChildren(icon(playing ? "pause" : "play"));
  }

  showReadings({ time, total, change, violation }: Readings): void {
    setText(this.readings.time, `${time.toFixed(2)}\u202fs`);
    setText(this.readings.total, `${fixedNumber(total)}\u202fJ`);
    setText(this.readings.change, `${inPrint(change, 1)}\u202fJ`);
    setText(this.readings.violation, inPrint(violation, 1));
  }

  /** Say why something did not work; nothing with an empty text. */
  say(text: string): void {
    setText(this.message, text);
    this.message.hidden = text === "";
  }

  private groups(): HTMLElement[] {
    return (Object.keys(TITLES) as Kind[]).flatMap((kind) => {
      const rows = this.rows.filter((row) => row.control.kind === kind);
      if (rows.length === 0) return [];
      return [create("fieldset", {}, create("legend", {}, TITLES[kind]), ...rows.map((row) => row.element))];
    });
  }

  private readingList(): HTMLElement {
    const names: Record<keyof Readings, readonly [string, string]> = {
      time: ["Time", "Time of the motion"],
      total: ["Energy", "Kinetic and potential energy"],
      change: ["Energy drift", "Energy minus its initial value and the work of inputs, dampers and the pointer: the energy that integration adds or loses"],
      violation: ["Constraint error", "Largest error of the position constraints, relative to the size of the mechanism"],
    };
    const rows = (Object.keys(names) as (keyof Readings)[]).flatMap((key) => [
      create("dt", { title: names[key][1] }, names[key][0]),
      create("dd", {}, this.readings[key]),
    ]);
    return create("dl", { class: "sb-readings" }, ...rows);
  }
}

function reading(): HTMLElement {
  return create("span", { class: "sb-number" });
}

function button(name: IconName, label: string, key: string, act: () => void): HTMLButtonElement {
  const element = create("button", { type: "button", class: "sb-button", "aria-label": label, title: `${label} (${key})` }, icon(name));
  element.addEventListener("click", act);
  return element;
}

function speedChoice(first: number, change: (speed: number) => void): HTMLElement {
  const speeds = [...new Set([...SPEEDS, first])].sort((a, b) => a - b);
  const select = create("select", { "aria-label": "Speed" }, ...speeds.map((speed) => create("option", { value: speed, selected: speed === first }, `${speed}\u00d7`)));
  select.addEventListener("change", () => { change(Number(select.value)); });
  return select;
}

function shortNumber(value: number): string {
  return String(Number(value.toPrecision(4))).replace("-", "\u2212");
}

function fixedNumber(value: number): string {
  const text = Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-3) ? value.toExponential(3) : value.toPrecision(5);
  return text.replace(/^-/, "\u2212");
}
