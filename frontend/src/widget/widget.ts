/**
 * The notebook widget: the player in a shadow root, its time, state and sliders shared with Python.
 *
 * Traits: `data` (what a page carries, as an object or as text), `time`, `playing`, `pose` (positions,
 * quaternions and perhaps vectors of one instant, or null), `sliders` and `slider_values`,
 * `message` (why sliders could not be followed), `height` [px].
 */

import { DataError, LiveSource, type LiveState } from "../viewer";
import { decodeData } from "../player/data";
import { create } from "../player/dom";
import { Player } from "../player/player";
import style from "../player/style.css?inline";
import { createSliders, readSliders } from "./sliders";

/** What a widget gets of its model in Python. */
export interface WidgetModel {
  get(name: string): unknown;
  set(name: string, value: unknown): void;
  save_changes(): void;
  on(event: string, call: () => void): void;
  off(event: string, call: () => void): void;
}

const USUAL_HEIGHT = 520;
const SEND_EVERY = 80; // milliseconds between times that are sent while it plays

interface Shown {
  readonly player: Player;
  readonly live: LiveSource;
}

/** One view of a widget's model in an output of the notebook. */
class WidgetView {
  private readonly host = create("div", { "data-lm-suppress-shortcuts": "true" });
  private readonly sliders = create("div", { class: "sb-player sb-sliders" });
  private readonly message = create("p", { class: "sb-slider-message", role: "alert" });
  private readonly frame = create("div", { class: "sb-framed" });
  private readonly sender: TimeSender;
  private readonly followed: readonly (readonly [string, () => void])[];
  private shown: Shown | null = null;
  private request = 0;

  constructor(
    private readonly model: WidgetModel,
    el: HTMLElement,
  ) {
    this.sender = new TimeSender(model);
    const height = Number(model.get("height"));
    this.frame.style.height = `${height > 0 ? height : USUAL_HEIGHT}px`;
    const shadow = this.host.attachShadow({ mode: "open" });
    shadow.append(create("style", {}, style), this.sliders, this.message, this.frame);
    el.append(this.host);
    this.followed = [
      ["change:data", () => { this.requestData(); }],
      ["change:time", () => { this.showTime(); }],
      ["change:playing", () => { this.showPlaying(); }],
      ["change:pose", () => { this.showPose(); }],
      ["change:sliders", () => { this.showSliders(); }],
      ["change:message", () => { this.showMessage(); }],
    ];
    this.showSliders();
    this.showMessage();
    this.showData();
    for (const [event, call] of this.followed) model.on(event, call);
  }

  end(): void {
    for (const [event, call] of this.followed) this.model.off(event, call);
    cancelAnimationFrame(this.request);
    this.sender.stop();
    this.shown?.player.dispose();
    this.host.remove();
  }

  /** Sliders change the data often: they are shown once before the next frame. */
  private requestData(): void {
    cancelAnimationFrame(this.request);
    this.request = requestAnimationFrame(() => { this.showData(); });
  }

  private showData(): void {
    const before = this.shown?.player.viewer?.rig.placement;
    this.shown?.player.dispose();
    this.frame.replaceChildren();
    this.shown = open(this.model, this.frame, this.sender);
    if (before !== undefined) this.shown?.player.viewer?.rig.place(before);
    this.sliders.dataset["theme"] = this.shown?.player.root.dataset["theme"] ?? "light";
    this.showPose();
  }

  private showTime(): void {
    const time = Number(this.model.get("time"));
    if (Number.isFinite(time) && time !== this.sender.sent) this.shown?.player.seek(time);
  }

  private showPlaying(): void {
    const playing = this.model.get("playing") === true;
    if (this.shown !== null && this.shown.player.clock.playing !== playing) this.shown.player.setPlaying(playing);
  }

  private showPose(): void {
    this.shown?.live.show(readPose(this.model.get("pose")));
    this.shown?.player.refresh();
  }

  private showMessage(): void {
    const text = this.model.get("message");
    this.message.textContent = typeof text === "string" ? text : "";
    this.message.hidden = this.message.textContent === "";
  }

  private showSliders(): void {
    const { model } = this;
    const ranges = readSliders(model.get("sliders"), model.get("slider_values"));
    const rows = createSliders(ranges, (name, value) => {
      model.set("slider_values", { ...(model.get("slider_values") as object | null), [name]: value });
      model.save_changes();
    });
    this.sliders.replaceChildren(...rows);
    this.sliders.hidden = rows.length === 0;
  }
}

function render({ model, el }: { model: WidgetModel; el: HTMLElement }): () => void {
  const view = new WidgetView(model, el);
  return () => { view.end(); };
}

/** Show what the model has, or say why it can't be shown. */
function open(model: WidgetModel, frame: HTMLElement, sender: TimeSender): Shown | null {
  try {
    const value = model.get("data");
    const data = decodeData(typeof value === "string" ? JSON.parse(value) : value);
    const live = new LiveSource(data.source, data.scene.bodies.length);
    const root = create("div");
    frame.append(root);
    // a notebook has many outputs: none of them moves by itself, unless Python says so
    const time = model.get("time");
    const first = typeof time === "number" ? time : data.settings.time;
    const settings = { ...data.settings, time: first, autoplay: model.get("playing") === true };
    const player = new Player(root, { ...data, source: live, settings }, {
      embedded: true,
      onTime: (time) => {
        live.show(null); // a chosen time takes the place of a live state
        sender.send(time);
      },
      onPlaying: (playing) => {
        model.set("playing", playing);
        model.save_changes();
      },
    });
    return { player, live };
  } catch (error) {
    if (!(error instanceof DataError || error instanceof SyntaxError)) throw error;
    frame.append(create("p", { role: "alert" }, `This mechanism cannot be shown: ${error.message}.`));
    return null;
  }
}

function readPose(value: unknown): LiveState | null {
  if (typeof value !== "object" || value === null) return null;
  const { positions, quaternions } = value as Partial<LiveState>;
  return Array.isArray(positions) && Array.isArray(quaternions) ? (value as LiveState) : null;
}

/** Sends the time to Python, not more often than a kernel can follow. */
class TimeSender {
  sent = NaN;
  private timer = 0;
  private pending = NaN;

  constructor(private readonly model: WidgetModel) {}

  send(time: number): void {
    this.pending = time;
    if (this.timer !== 0) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      this.sent = this.pending;
      this.model.set("time", this.pending);
      this.model.save_changes();
    }, SEND_EVERY);
  }

  stop(): void {
    window.clearTimeout(this.timer);
    this.timer = 0;
  }
}

export default { render };
