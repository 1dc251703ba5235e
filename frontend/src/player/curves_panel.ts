/** All panels of curves, in step with the time and with each other. */

import type { StateSource } from "../viewer";
import { isAngular, rememberAngles, rememberedAngles, type AngleView } from "./angles";
import { groupCurves, toCsv } from "./curve_table";
import { create, download, fileName, setText } from "./dom";
import { iconButton } from "./icons";
import { curveColor, Plot } from "./plot";
import { plainReading } from "./readable";
import { formatTime } from "./transport";

const LEAST_HEIGHT = 90; // [px]; what does not fit is scrolled to
const TIME_AXIS = 20; // the height that the numbers of the time take under the last panel
const GAP = 4;

export class CurvesPanel {
  readonly element: HTMLElement;
  plots: readonly Plot[];
  private readonly list = create("div", { class: "sb-plots" });
  private readonly readout = create("span", { class: "sb-number sb-hover" });
  private readonly angles = { degrees: this.createSwitch("degrees"), wrap: this.createSwitch("wrap") };
  private readonly watcher: ResizeObserver;
  private view = rememberedAngles();
  private time = 0;
  private hovered: number | null = null;

  constructor(
    private readonly source: StateSource,
    private readonly title: string,
    shown: readonly string[] | null,
    private readonly seek: (time: number) => void,
  ) {
    this.plots = this.createPlots(shown);
    this.element = create("section", { class: "sb-curves", "aria-label": "Curves" }, this.createHeader(), this.list);
    this.watcher = new ResizeObserver(() => { this.resize(); });
    this.watcher.observe(this.list);
  }

  showTime(time: number): void {
    this.time = time;
    for (const plot of this.plots) {
      plot.showTime(time);
      if (this.hovered === null) plot.showValues(time);
    }
  }

  /** Draw anew in the colours of another theme. */
  repaint(): void {
    for (const plot of this.plots) plot.chart.redraw(false); // the paths stay
  }

  resize(): void {
    const room = (this.list.clientHeight - TIME_AXIS) / this.plots.length - GAP;
    this.plots.forEach((plot) => {
      const height = Math.max(LEAST_HEIGHT, Math.floor(room)); // its legend scrolls
      plot.resize(plot.last ? height + TIME_AXIS : height);
    });
    this.showTime(this.time);
  }

  saveCsv(): void {
    const curves = this.plots.flatMap((plot) => plot.drawn.map((index) => plot.group.curves[index]!));
    download(fileName(this.title, ".csv"), new Blob([toCsv(this.source.times, curves)], { type: "text/csv" }));
  }

  savePng(): void {
    picture(this.plots, this.element).toBlob((blob) => {
      if (blob !== null) download(fileName(this.title, "_curves.png"), blob);
    });
  }

  dispose(): void {
    this.watcher.disconnect();
    for (const plot of this.plots) plot.dispose();
  }

  /** Make the plots of the curves as they are shown now, and put them in. */
  private createPlots(shown: readonly string[] | null): Plot[] {
    const { source, seek } = this;
    const hooks = { seek, hover: (time: number | null) => { this.hover(time); }, choose: () => undefined };
    const groups = groupCurves(source.curves, this.view);
    const plots = groups.map((group, index) => new Plot(group, source.times, source.events, shown, hooks, index === groups.length - 1));
    this.list.replaceChildren(...plots.map((plot) => plot.element));
    this.showSwitches();
    return plots;
  }

  /** Show angles in another way; what is ticked and the part of the time stay. */
  private showAngles(view: AngleView): void {
    const drawn = this.plots.flatMap((plot) => plot.drawn.map((index) => plot.group.curves[index]!.name));
    const zoom = this.plots[0]?.zoom;
    for (const plot of this.plots) plot.dispose();
    this.view = view;
    rememberAngles(view);
    this.plots = this.createPlots(drawn);
    this.resize();
    for (const plot of this.plots) plot.zoomTo(zoom);
  }

  private createSwitch(name: keyof AngleView): HTMLButtonElement {
    const button = create("button", { type: "button", class: "sb-button sb-switch" });
    button.addEventListener("click", () => { this.showAngles({ ...this.view, [name]: !this.view[name] }); });
    return button;
  }

  private showSwitches(): void {
    const { degrees, wrap } = this.angles;
    const half = this.view.degrees ? "180°" : "π";
    const words = [[degrees, "deg", "Angles in degrees", this.view.degrees], [wrap, `±${half}`, `Wrap angles to −${half} … ${half}`, this.view.wrap]] as const;
    for (const [button, text, label, pressed] of words) {
      setText(button, text);
      button.hidden = !this.source.curves.some((each) => isAngular(each.unit));
      button.title = label;
      button.setAttribute("aria-label", label);
      button.setAttribute("aria-pressed", String(pressed));
    }
  }

  private createHeader(): HTMLElement {
    return create(
      "div",
      { class: "sb-curves-head" },
      this.readout,
      this.angles.degrees,
      this.angles.wrap,
      iconButton("zoomOut", "Show the whole time (double-click a plot)", "", () => { for (const plot of this.plots) plot.resetZoom(); }),
      iconButton("table", "Save the curves as CSV", "", () => { this.saveCsv(); }),
      iconButton("camera", "Save the curves as a picture", "", () => { this.savePng(); }),
    );
  }

  private hover(time: number | null): void {
    if (time === null && this.hovered === null) return;
    this.hovered = time;
    const { start, end } = this.source;
    setText(this.readout, time === null ? "" : `t ${formatTime(time, end - start)} s`);
    for (const plot of this.plots) plot.showValues(time ?? this.time);
  }
}

/** Return the plots, each with the names of its curves over it, on one canvas. */
function picture(plots: readonly Plot[], styled: HTMLElement): HTMLCanvasElement {
  const style = getComputedStyle(styled);
  const ratio = window.devicePixelRatio || 1;
  const head = 26 * ratio;
  const sources = plots.map((plot) => plot.chart.ctx.canvas);
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(...sources.map((each) => each.width));
  canvas.height = sources.reduce((sum, each) => sum + each.height + head, 0);
  const context = canvas.getContext("2d");
  if (context === null) return canvas;
  context.fillStyle = style.getPropertyValue("--sb-surface");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  let top = 0;
  plots.forEach((plot, index) => {
    let left = 12 * ratio;
    for (const curve of plot.drawn) {
      context.fillStyle = style.getPropertyValue(curveColor(curve));
      context.fillRect(left, top + head / 2 - ratio, 18 * ratio, 2 * ratio);
      context.fillStyle = style.getPropertyValue("--sb-text");
      const { name } = plot.group.curves[curve]!;
      const text = plainReading(name);
      context.fillText(text, left + 24 * ratio, top + head / 2);
      left += context.measureText(text).width + 44 * ratio;
    }
    context.drawImage(sources[index]!, 0, top + head);
    top += head + sources[index]!.height;
  });
  return canvas;
}
