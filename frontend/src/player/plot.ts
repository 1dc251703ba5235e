/** One panel of curves with a legend whose ticks choose what is drawn. */

import uPlot from "uplot";
import type { MotionEvent } from "../viewer";
import { valueAt, formatValue, type CurveGroup } from "./curve_table";
import { create, setText } from "./dom";
import { nameElement, printedUnit } from "./readable";

const DASHES: readonly (readonly number[])[] = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
// Distances of marks that divide a turn well, and those of all other numbers below and above.
const DEGREES = [-9, -8, -7, -6, -5, -4, -3, -2, -1].flatMap((power) => [1, 2, 5].map((each) => Number(`${each}e${power}`)))
  .concat([1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720, 1800, 3600, 7200, 18000, 36000], [5, 6, 7, 8, 9].flatMap((power) => [1, 2, 5].map((each) => each * 10 ** power)));
const COLORS = 8; // that the style has for curves
export const MOST_SHOWN = 6; // curves that a panel shows at first

interface Row {
  readonly box: HTMLInputElement;
  readonly value: HTMLElement;
}

export interface PlotHooks {
  seek(time: number): void;
  /** The time under the pointer, or null. */
  hover(time: number | null): void;
  choose(): void;
}

export class Plot {
  readonly element = create("div", { class: "sb-plot" });
  readonly chart: uPlot;
  private readonly rows: Row[];
  private readonly cursor = create("div", { class: "sb-time-cursor", "aria-hidden": "true" });
  private time = 0;

  constructor(
    readonly group: CurveGroup,
    private readonly times: Float64Array,
    events: readonly MotionEvent[],
    shown: readonly string[] | null,
    private readonly hooks: PlotHooks,
    readonly last: boolean,
  ) {
    const visible = (index: number): boolean =>
      shown === null ? index < MOST_SHOWN : shown.includes(group.curves[index]!.name);
    const area = create("div", { class: "sb-plot-area" });
    this.rows = group.curves.map((_, index) => this.createRow(index, visible(index)));
    this.element.append(area, this.createLegend());
    const series = group.curves.map((curve, index) => ({
      label: curve.name,
      stroke: (chart: uPlot) => variable(chart, curveColor(index)),
      dash: [...curveDash(index)],
      width: 2,
      pxAlign: 0,
      ...(group.turn > 0 ? { paths: wrappedPath(group.turn) } : {}),
      show: visible(index),
      points: { show: false },
    }));
    const options: uPlot.Options = {
      width: 300,
      height: 120,
      pxAlign: 0, // points stay where they are: lines without steps
      legend: { show: false },
      scales: { x: { time: false }, y: { range: (_, low, high) => valueRange(low, high) } },
      series: [{}, ...series],
      axes: [timeAxis(last), valueAxis(group.unit)],
      cursor: {
        sync: { key: "symbody" },
        drag: { x: true, y: false, setScale: true },
        points: { size: 7 },
        // the first of two clicks puts the time's line under the pointer: the second may come from there
        bind: { dblclick: (_chart, _target, handle) => handle },
      },
      hooks: {
        draw: [(chart) => { drawEvents(chart, events); }],
        setSize: [() => { this.showTime(this.time); }],
        setScale: [() => { this.showTime(this.time); }],
        setCursor: [(chart) => { this.hover(chart); }],
      },
    };
    this.chart = new uPlot(options, [times, ...group.curves.map((each) => each.values)] as uPlot.AlignedData, area);
    this.chart.over.append(this.cursor);
    this.followPointer();
  }

  /** The curves that are drawn. */
  get drawn(): readonly number[] {
    return this.rows.flatMap((row, index) => (row.box.checked ? [index] : []));
  }

  resize(height: number): void {
    const area = this.chart.root.parentElement;
    const width = area?.clientWidth ?? 0;
    if (width <= 40 || height <= 40) return;
    this.chart.setSize({ width, height });
    this.element.style.setProperty("--sb-height", `${height}px`);
  }

  showTime(time: number): void {
    this.time = time;
    const { min, max } = this.chart.scales["x"] ?? {};
    const inside = typeof min === "number" && typeof max === "number" && time >= min && time <= max;
    this.cursor.hidden = !inside;
    if (inside) this.cursor.style.transform = `translateX(${this.chart.valToPos(time, "x").toFixed(1)}px)`;
  }

  showValues(time: number): void {
    this.rows.forEach((row, index) => {
      setText(row.value, formatValue(valueAt(this.times, this.group.curves[index]!.values, time, this.group.turn)));
    });
  }

  resetZoom(): void {
    this.zoomTo([this.times[0]!, this.times[this.times.length - 1]!]);
  }

  /** The part of the time that is seen. */
  get zoom(): readonly [number, number] | undefined {
    const { min, max } = this.chart.scales["x"] ?? {};
    return min == null || max == null ? undefined : [min, max];
  }

  zoomTo(part: readonly [number, number] | undefined): void {
    if (part !== undefined) this.chart.setScale("x", { min: part[0], max: part[1] });
  }

  dispose(): void {
    this.chart.destroy();
  }

  private createRow(index: number, checked: boolean): Row {
    const box = create("input", { type: "checkbox", "aria-label": this.group.curves[index]!.name });
    box.checked = checked;
    box.addEventListener("change", () => {
      this.chart.setSeries(index + 1, { show: box.checked });
      this.hooks.choose();
    });
    return { box, value: create("span", { class: "sb-number" }) };
  }

  private createLegend(): HTMLElement {
    const unit = this.group.unit === "" ? "" : ` ${printedUnit(this.group.unit)}`;
    const rows = this.rows.map((row, index) => {
      const name = this.group.curves[index]!.name;
      return create("label", { class: "sb-curve", title: name + unit }, row.box, swatch(index), nameElement(name, { class: "sb-curve-name" }), row.value);
    });
    const title = this.group.unit === "" ? "no unit" : printedUnit(this.group.unit);
    return create("div", { class: "sb-legend", role: "group", "aria-label": `Curves, ${title}`, tabindex: 0 }, ...rows);
  }

  private hover(chart: uPlot): void {
    const { left } = chart.cursor;
    const inside = left !== undefined && left >= 0;
    this.hooks.hover(inside ? chart.posToVal(left, "x") : null);
  }

  /** A press without a drag sets the time; a drag that begins on the time's line moves it. */
  private followPointer(): void {
    const { over } = this.chart;
    let pressed = 0;
    over.addEventListener("pointerdown", (event) => { pressed = event.clientX; });
    over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - pressed) < 4) this.seekAt(event);
    });
    this.cursor.addEventListener("pointerdown", (event) => {
      this.cursor.setPointerCapture(event.pointerId);
      event.stopPropagation();
    });
    this.cursor.addEventListener("mousedown", (event) => { event.stopPropagation(); });
    this.cursor.addEventListener("pointermove", (event) => {
      if (this.cursor.hasPointerCapture(event.pointerId)) this.seekAt(event);
    });
  }

  private seekAt(event: MouseEvent): void {
    const { left } = this.chart.over.getBoundingClientRect();
    this.hooks.seek(this.chart.posToVal(event.clientX - left, "x"));
  }
}

/** Return the style's variable with the colour of a curve. */
export function curveColor(index: number): string {
  return `--sb-curve-${index % COLORS}`;
}

function curveDash(index: number): readonly number[] {
  return DASHES[Math.floor(index / COLORS) % DASHES.length]!;
}

function swatch(index: number): HTMLElement {
  const element = create("span", { class: "sb-swatch" });
  element.style.setProperty("--sb-swatch", `var(${curveColor(index)})`);
  element.classList.toggle("sb-dashed", curveDash(index).length > 0);
  return element;
}

function variable(chart: uPlot, name: string): string {
  return getComputedStyle(chart.root).getPropertyValue(name);
}

const FONT = '12px system-ui, "Segoe UI", sans-serif';

/** Axes take their colours from the page's style, at each drawing. */
function plainAxis(): uPlot.Axis {
  const rule = (chart: uPlot): string => variable(chart, "--sb-rule");
  return {
    stroke: (chart) => variable(chart, "--sb-soft"),
    font: FONT,
    grid: { stroke: rule, width: 1 },
    ticks: { stroke: rule, width: 1, size: 4 },
  };
}

/** The axis of time; its numbers stand under the last panel only. */
function timeAxis(last: boolean): uPlot.Axis {
  if (!last) return { ...plainAxis(), size: 6, values: (_, splits) => splits.map(() => ""), ticks: { show: false } };
  return { ...plainAxis(), size: 24, gap: 2, values: (_, splits) => splits.map((each, index) => (index === splits.length - 1 ? `${formatTick(each)} s` : formatTick(each))) };
}

/** Return what draws a wrapped angle: where it passes half a turn the line ends, and begins anew on the other side. */
function wrappedPath(turn: number): uPlot.Series.PathBuilder {
  return (chart, index, first, last) => {
    const [times, values] = [chart.data[0], chart.data[index]!];
    const stroke = new Path2D();
    const put = (draw: "moveTo" | "lineTo", time: number, value: number): void => { stroke[draw](chart.valToPos(time, "x", true), chart.valToPos(value, "y", true)); };
    put("moveTo", times[first]!, values[first]!);
    for (let k = first + 1; k <= last; k += 1) {
      const [start, end] = [values[k - 1]!, values[k]!];
      const laps = Math.round((end - start) / turn); // 1: from below on to above
      if (laps !== 0) {
        const edge = (-laps * turn) / 2;
        const part = (edge - start) / (end - laps * turn - start);
        const time = times[k - 1]! + part * (times[k]! - times[k - 1]!);
        put("lineTo", time, edge);
        put("moveTo", time, -edge);
      }
      put("lineTo", times[k]!, end);
    }
    return { stroke };
  };
}

/** Return the ends of an axis; what differs by rounding alone is a level line. */
function valueRange(low: number | null, high: number | null): uPlot.Range.MinMax {
  if (low === null || high === null) return [0, 1];
  const middle = (low + high) / 2;
  if (high - low > Math.max(1e-12, 1e-9 * Math.abs(middle))) return uPlot.rangeNum(low, high, 0.1, true);
  const reach = Math.abs(middle) > 1e-12 ? 0.5 * Math.abs(middle) : 1;
  return [middle - reach, middle + reach];
}

function valueAxis(unit: string): uPlot.Axis {
  // without a unit too: the axes of all panels begin at one place
  const named = { label: unit === "" ? " " : printedUnit(unit), labelFont: FONT, labelSize: 18, labelGap: 0 };
  return { ...plainAxis(), ...named, size: 54, space: 22, ...(unit === "deg" ? { incrs: DEGREES } : {}), values: (_, splits) => splits.map(formatTick) };
}

function formatTick(value: number): string {
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(0) : String(Number(value.toPrecision(5)));
  return text.replace("-", "−");
}

function drawEvents(chart: uPlot, events: readonly MotionEvent[]): void {
  const { ctx, bbox } = chart;
  ctx.save();
  ctx.strokeStyle = variable(chart, "--sb-event");
  ctx.setLineDash([4, 4]);
  for (const { t } of events) {
    const x = Math.round(chart.valToPos(t, "x", true)) + 0.5;
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
}
