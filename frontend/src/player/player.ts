/** The player: picture, time and curves in an element of a page. */

import { castOf, Clock, Viewer, WebGLMissing, type Scene, type SceneElement, type StateSource, type ViewName } from "../viewer";
import { ArrowLegend } from "./arrow_legend";
import { runCommand } from "./commands";
import { CurvesPanel } from "./curves_panel";
import type { PlayerData } from "./data";
import { create, download, fileName, setText } from "./dom";
import { helpDialog } from "./help";
import { SelectionCard, Tooltip } from "./info";
import { commandOf, targetOf, type Command } from "./keys";
import { coveredParts, watchLayout } from "./layout";
import { FrameLoop } from "./loop";
import { watchPointer } from "./pointer";
import { applySetting, OF_SCENE } from "./apply_setting";
import { Settings } from "./settings";
import { splitBar } from "./split";
import { followTheme, prefersReducedMotion } from "./theme";
import { createToolbar, type Toolbar } from "./toolbar";
import { Transport } from "./transport";
import { Triad } from "./triad";

export interface PlayerContext {
  /** What key presses are taken from: the document of a page of its own, else the player. */
  readonly keysFrom?: Document;
  /** Whether the player is part of a longer page: the wheel scrolls that page until the picture is chosen. */
  readonly embedded?: boolean;
  /** Whether somebody else moves what is shown: there is no time to choose, whatever the source covers. */
  readonly still?: boolean;
  onTime?(time: number): void;
  onPlaying?(playing: boolean): void;
  onSelect?(element: SceneElement | null): void;
}

export class Player {
  readonly clock: Clock;
  readonly settings: Settings;
  readonly viewer: Viewer | null;
  readonly curves: CurvesPanel | null;
  readonly help = helpDialog();
  readonly toolbar: Toolbar;
  readonly stage = create("div", { class: "sb-stage" });
  private readonly live = create("div", { class: "sb-live", role: "status", "aria-live": "polite" });
  private readonly transport: Transport | null;
  triad: Triad;
  private readonly legend: ArrowLegend | null;
  private readonly tooltip: Tooltip | null;
  private readonly selection: SelectionCard | null;
  private readonly loop = new FrameLoop((seconds, now) => this.draw(seconds, now));
  private readonly ends: (() => void)[] = [];
  private drawnTime = NaN;
  private wasPlaying = false;

  constructor(
    readonly root: HTMLElement,
    public data: PlayerData,
    private readonly context: PlayerContext = {},
  ) {
    const { scene, source, title, settings } = data;
    this.clock = new Clock(source.start, context.still === true ? source.start : source.end);
    this.settings = new Settings(settings);
    root.classList.add("sb-player");
    root.append(this.stage); // before the picture, which takes its size
    this.triad = new Triad(scene);
    this.viewer = this.createViewer();
    this.chooseCamera();
    this.legend = this.viewer === null ? null : new ArrowLegend(this.viewer);
    this.tooltip = this.viewer === null ? null : new Tooltip(this.viewer);
    this.selection = this.viewer === null ? null : new SelectionCard(this.viewer);
    this.curves = source.curves.length === 0 || this.clock.duration <= 0
      ? null
      : new CurvesPanel(source, title, settings.shownCurves, (time) => { this.seek(time); });
    const run = (command: Command): void => { this.run(command); };
    this.transport = this.clock.duration <= 0
      ? null
      : new Transport(this.clock, source.events, run, (time) => { this.seek(time); }, (speed) => { this.settings.set("speed", speed); });
    this.toolbar = createToolbar(this, scene, source, run);
    this.assemble(title);
    this.ends.push(watchLayout(root, this.stage));
    this.listen();
    this.settings.follow((name) => { applySetting(this, name); });
    this.begin();
  }

  get time(): number {
    return this.clock.time;
  }

  /** Set the time and pause nothing; held within the range. */
  seek(time: number): void {
    this.clock.seek(time);
    this.loop.wake();
  }

  /** Set the time and draw at once: for tests and for pictures. */
  setTime(time: number): void {
    this.clock.pause();
    this.clock.seek(time);
    this.loop.stop();
    this.draw(0, performance.now());
  }

  setPlaying(playing: boolean): void {
    if (playing) this.clock.play();
    else this.clock.pause();
    this.loop.wake();
  }

  run(command: Command): void {
    runCommand(this, command);
    this.loop.wake();
  }

  /** Draw the same time again: the state behind it has changed. */
  refresh(): void {
    this.viewer?.setTime(this.clock.time);
    this.loop.wake();
  }

  /** Show another scene of the same mechanism in the same picture; return whether that can be. */
  replaceScene(scene: Scene, source: StateSource): boolean {
    const isStill = this.context.still === true || source.end <= source.start;
    const still = isStill && this.clock.duration <= 0 && source.vectors.length === 0;
    if (this.viewer === null || !still || castOf(scene) !== castOf(this.data.scene)) return false;
    this.data = { ...this.data, scene, source };
    this.viewer.replaceScene(scene, source);
    const triad = new Triad(scene);
    this.triad.element.replaceWith(triad.element);
    this.triad = triad;
    for (const name of OF_SCENE) applySetting(this, name);
    return true;
  }

  view(name: ViewName): void {
    this.viewer?.view(name);
  }

  select(element: SceneElement | string | null): void {
    this.viewer?.select(element);
  }

  /** Say something to screen readers. */
  say(text: string): void {
    setText(this.live, text);
  }

  wake(): void {
    this.loop.wake();
  }

  savePicture(): void {
    this.viewer?.canvas.toBlob((blob) => {
      if (blob !== null) download(fileName(this.data.title, ".png"), blob);
    });
  }

  /** What tests look at. */
  state(): Record<string, unknown> {
    const { viewer } = this;
    return {
      time: this.clock.time,
      playing: this.clock.playing,
      idle: this.loop.idle,
      webgl: viewer !== null,
      selected: viewer?.selected?.name ?? null,
      ...(viewer === null ? {} : viewer.statistics),
      camera: viewer === null ? null : { position: viewer.rig.camera.position.toArray(), target: viewer.rig.controls.target.toArray() },
    };
  }

  dispose(): void {
    this.loop.stop();
    for (const end of this.ends) end();
    this.curves?.dispose();
    this.viewer?.dispose();
    this.root.replaceChildren();
    this.root.classList.remove("sb-player");
  }

  private createViewer(): Viewer | null {
    try {
      return new Viewer(this.stage, this.data.scene, this.data.source, {
        invalidate: () => { this.loop.wake(); },
        animate: () => !prefersReducedMotion(),
        covered: () => coveredParts(this.stage),
        onHover: (element, x, y) => {
          const area = this.stage.getBoundingClientRect();
          this.tooltip?.showAt(element, x - area.left, y - area.top);
        },
        onSelect: (element) => {
          this.selection?.show(element);
          this.say(element === null ? "Nothing selected" : `${element.name}, ${element.type}, selected`);
          this.context.onSelect?.(element);
        },
      });
    } catch (error) {
      if (!(error instanceof WebGLMissing)) throw error;
      this.stage.append(webglMessage(this.data.source.curves.length > 0));
      return null;
    }
  }

  /** Planar mechanisms are seen as they are drawn, without perspective; those that go far are followed. */
  private chooseCamera(): void {
    if (this.data.scene.normal !== null && this.settings.values.view === "auto") this.settings.set("parallel", true);
    if (this.viewer?.roams === true) this.settings.set("follow", true);
  }

  private assemble(title: string): void {
    const { stage, viewer, root } = this;
    const corner = create("div", { class: "sb-corner" }, ...(this.selection === null ? [] : [this.selection.element]));
    if (viewer !== null) {
      const canvas = viewer.canvas;
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      if (this.context.embedded === true) zoomWhenFocused(viewer);
      canvas.setAttribute("aria-label", `${title}: 3-D picture. Press question mark for keys.`);
      corner.append(this.triad.element);
    }
    stage.append(create("h1", { class: "sb-title" }, title), this.toolbar.element, corner);
    for (const part of [this.legend, this.tooltip]) if (part !== null) stage.append(part.element);
    if (this.transport !== null) root.append(this.transport.element);
    if (this.curves !== null) {
      root.append(splitBar(root, (percent) => { root.style.setProperty("--sb-curves", `${percent}%`); }), this.curves.element);
    }
    root.append(this.live, this.help);
  }

  private listen(): void {
    const source: HTMLElement | Document = this.context.keysFrom ?? this.root;
    const key = (event: Event): void => {
      if (event instanceof KeyboardEvent) this.press(event);
    };
    source.addEventListener("keydown", key);
    const press = (event: Event): void => { this.toolbar.closeFor(event.composedPath()); };
    document.addEventListener("pointerdown", press);
    this.ends.push(
      () => { source.removeEventListener("keydown", key); },
      () => { document.removeEventListener("pointerdown", press); },
      followTheme(() => { applySetting(this, "theme"); }),
    );
    if (this.viewer !== null) this.ends.push(watchPointer(this.viewer));
  }

  private press(event: KeyboardEvent): void {
    const command = event.defaultPrevented ? null : commandOf(event, targetOf(event.composedPath()[0] ?? null));
    if (command === null || (this.help.open && command !== "help")) return;
    event.preventDefault();
    event.stopPropagation();
    this.run(command);
  }

  private begin(): void {
    const { settings } = this.data;
    if (settings.time !== null) this.clock.seek(settings.time);
    if (settings.autoplay && !prefersReducedMotion()) this.clock.play();
    this.loop.wake();
  }

  private draw(seconds: number, now: number): boolean {
    this.clock.advance(seconds);
    const { time, playing } = this.clock;
    if (time !== this.drawnTime) this.showTime(time);
    this.transport?.update();
    if (playing !== this.wasPlaying) {
      this.wasPlaying = playing;
      this.context.onPlaying?.(playing);
    }
    const moving = this.viewer !== null && this.drawPicture(this.viewer, now);
    return playing || moving;
  }

  private showTime(time: number): void {
    const first = Number.isNaN(this.drawnTime);
    this.drawnTime = time;
    this.viewer?.setTime(time);
    this.curves?.showTime(time);
    if (!first) this.context.onTime?.(time);
  }

  private drawPicture(viewer: Viewer, now: number): boolean {
    const moving = viewer.render(now);
    this.triad.update(viewer.rig.camera);
    for (const part of [this.legend, this.selection, this.tooltip]) part?.update();
    return moving;
  }
}

function zoomWhenFocused({ canvas, rig }: Viewer): void {
  rig.controls.enableZoom = false;
  canvas.addEventListener("focus", () => { rig.controls.enableZoom = true; });
  canvas.addEventListener("blur", () => { rig.controls.enableZoom = false; });
}

function webglMessage(curves: boolean): HTMLElement {
  return create(
    "div",
    { class: "sb-message", role: "alert" },
    create("h2", {}, "No 3-D picture"),
    create("p", {}, "This browser does not support WebGL. Turn on hardware acceleration in its settings, or open the file in another browser."),
    create("p", {}, curves ? "Curves and time still work." : "Time still works."),
  );
}
