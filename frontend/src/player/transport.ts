/** Play, step, time line, speed, loop. */

import type { Clock, MotionEvent } from "../viewer";
import { SPEEDS } from "../viewer";
import { create, setText } from "./dom";
import { icon, iconButton } from "./icons";
import type { Command } from "./keys";

/** Return a time with as many digits as a range needs, without its unit. */
export function formatTime(time: number, duration: number): string {
  const digits = duration >= 100 ? 1 : duration >= 10 ? 2 : duration >= 0.1 ? 3 : 5;
  return time.toFixed(digits);
}

export class Transport {
  readonly element: HTMLElement;
  readonly line: HTMLInputElement;
  private readonly play: HTMLButtonElement;
  private readonly loop: HTMLButtonElement;
  private readonly speed: HTMLSelectElement;
  private readonly readout = create("span", { class: "sb-time" });
  private playing = false;

  constructor(
    private readonly clock: Clock,
    events: readonly MotionEvent[],
    run: (command: Command) => void,
    private readonly seek: (time: number) => void,
    changeSpeed: (speed: number) => void,
  ) {
    this.play = iconButton("play", "Play", "Space", () => { run("playPause"); });
    this.play.classList.add("sb-play");
    this.loop = iconButton("loop", "Loop", "O", () => { run("loop"); });
    this.line = this.createLine();
    this.speed = createSpeeds(changeSpeed);
    const total = create("span", { class: "sb-total" }, `/ ${formatTime(clock.end, clock.duration)} s`);
    this.element = create(
      "div",
      { class: "sb-transport", role: "group", "aria-label": "Time" },
      iconButton("toStart", "To the start", "Home", () => { run("toStart"); }),
      iconButton("stepBack", "A step back", "←", () => { run("stepBack"); }),
      this.play,
      iconButton("stepForward", "A step forward", "→", () => { run("stepForward"); }),
      create("div", { class: "sb-readout" }, this.readout, total),
      create("div", { class: "sb-line" }, this.line, eventMarks(clock, events, this.seek)),
      this.speed,
      this.loop,
    );
  }

  update(): void {
    const { clock } = this;
    const text = formatTime(clock.time, clock.duration);
    setText(this.readout, text);
    this.line.value = String(clock.time);
    const part = clock.duration > 0 ? (clock.time - clock.start) / clock.duration : 0;
    this.line.style.setProperty("--sb-part", `${(100 * part).toFixed(2)}%`);
    // while it plays a screen reader would read every frame
    if (!clock.playing) this.line.setAttribute("aria-valuetext", `${text} of ${formatTime(clock.end, clock.duration)} seconds`);
    if (clock.playing !== this.playing) this.showPlaying(clock.playing);
    this.loop.setAttribute("aria-pressed", String(clock.loop));
    this.speed.value = String(clock.speed);
  }

  private showPlaying(playing: boolean): void {
    this.playing = playing;
    const label = playing ? "Pause" : "Play";
    this.play.replaceChildren(icon(playing ? "pause" : "play"));
    this.play.setAttribute("aria-label", label);
    this.play.title = `${label} (Space)`;
  }

  private createLine(): HTMLInputElement {
    const { start, end } = this.clock;
    const line = create("input", {
      type: "range", class: "sb-timeline", min: start, max: end, step: "any", "aria-label": "Time", "data-timeline": true,
    }); // prettier-ignore
    line.addEventListener("input", () => { this.seek(Number(line.value)); });
    return line;
  }
}

function createSpeeds(change: (speed: number) => void): HTMLSelectElement {
  const options = SPEEDS.map((each) => create("option", { value: each }, `${each}×`));
  const select = create("select", { class: "sb-speed", "aria-label": "Speed", title: "Speed ([ and ])" }, ...options);
  select.addEventListener("change", () => { change(Number(select.value)); });
  return select;
}

function eventMarks(clock: Clock, events: readonly MotionEvent[], seek: (time: number) => void): HTMLElement {
  const marks = events.map((event) => {
    const text = `${event.name} at ${formatTime(event.t, clock.duration)} s`;
    const mark = create("button", { type: "button", class: "sb-event", "aria-label": text, title: text });
    mark.style.left = `${(100 * (event.t - clock.start)) / (clock.duration || 1)}%`;
    mark.addEventListener("click", () => { seek(event.t); });
    return mark;
  });
  return create("div", { class: "sb-events" }, ...marks);
}
