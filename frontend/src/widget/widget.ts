/**
 * The notebook widget: the player in a shadow root, its time, state and sliders shared with Python.
 *
 * Traits: `data` (what a page carries, as an object or as text), `time`, `playing`, `pose` (positions,
 * quaternions and perhaps vectors of one instant, or null), `sliders` and `slider_values`, `height` [px].
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

function render({ model, el }: { model: WidgetModel; el: HTMLElement }): () => void {
  const host = create("div", { "data-lm-suppress-shortcuts": "true" });
  const shadow = host.attachShadow({ mode: "open" });
  const sliders = create("div", { class: "sb-player sb-sliders" });
  const frame = create("div");
  const height = Number(model.get("height"));
  frame.style.height = `${height > 0 ? height : USUAL_HEIGHT}px`;
  shadow.append(create("style", {}, style), sliders, frame);
  el.append(host);
  let shown: Shown | null = null;
  const sender = new TimeSender(model);

  const showData = (): void => {
    shown?.player.dispose();
    frame.replaceChildren();
    shown = open(model, frame, sender);
    showPose();
    sliders.dataset["theme"] = frame.querySelector<HTMLElement>(".sb-player")?.dataset["theme"] ?? "light";
  };
  const showTime = (): void => {
    const time = Number(model.get("time"));
    if (shown !== null && Number.isFinite(time) && time !== sender.sent) shown.player.seek(time);
  };
  const showPlaying = (): void => {
    const playing = model.get("playing") === true;
    if (shown !== null && shown.player.clock.playing !== playing) shown.player.setPlaying(playing);
  };
  const showPose = (): void => {
    if (shown === null) return;
    shown.live.show(readPose(model.get("pose")));
    shown.player.refresh();
  };
  const showSliders = (): void => {
    const values = model.get("slider_values");
    sliders.replaceChildren(...createSliders(readSliders(model.get("sliders"), values), (name, value) => {
      model.set("slider_values", { ...(model.get("slider_values") as object | null), [name]: value });
      model.save_changes();
    }));
    sliders.hidden = sliders.childElementCount === 0;
  };
  const followed: [string, () => void][] = [
    ["change:data", showData], ["change:time", showTime], ["change:playing", showPlaying],
    ["change:pose", showPose], ["change:sliders", showSliders],
  ]; // prettier-ignore
  showSliders();
  showData();
  for (const [event, call] of followed) model.on(event, call);
  return () => {
    for (const [event, call] of followed) model.off(event, call);
    sender.stop();
    shown?.player.dispose();
    host.remove();
  };
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
