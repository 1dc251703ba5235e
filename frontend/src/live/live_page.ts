/** A mechanism that is simulated by its page: the picture, the panel, and the simulation behind both. */

import { decodeScene, LiveSource, StoredMotion } from "../viewer";
import type { PlayerData } from "../player/data";
import { create } from "../player/dom";
import { Player } from "../player/player";
import { prefersReducedMotion } from "../player/theme";
import { Bench, type Readings } from "./bench";
import { Pulling, Thread } from "./pulling";
import { previewOf, sceneFor, stateOf, type Control, type LiveData, type Simulation } from "./simulation";

const MOST_SECONDS = 0.1; // of a frame: a page that was hidden does not leap
const BUDGET = 24; // milliseconds of computing in a frame
const STEP = 1 / 60; // seconds
const TRIALS = 64;

const CAUSES: Readonly<Record<string, string>> = {
  COLLAPSED: "The steps became too short to continue: something changes too fast.",
  NOT_FINITE: "An acceleration is not finite.",
  SINGULAR: "The accelerations are undetermined: the mass matrix or the constraints are singular here.",
  FINISHED: "The page simulates up to this time only. Reset it to continue.",
};

/** What Python wrote as MathML: the symbols of the sliders, and the equations if they can be read. */
export interface Formulas {
  readonly symbols: readonly Node[];
  readonly equations: Node | null;
}

/** Return a simulation whose inputs have the values at which their sliders stand. */
function withFirstInputs(simulation: Simulation, controls: readonly Control[]): Simulation {
  for (const { kind, name, value } of controls) if (kind === "input" && value !== 0) simulation.setInput(name, value);
  return simulation;
}

export class LivePage {
  readonly simulation: Simulation;
  readonly player: Player;
  readonly bench: Bench;
  private readonly source: LiveSource;
  private readonly bodies: number;
  private readonly pulling: Pulling | null;
  private readonly held: readonly string[];
  private readonly firstParameters: ReadonlyMap<string, number>;
  private playing = false;
  private speed: number;
  private request = 0;
  private before = 0;
  private firstEnergy = 0;

  constructor(
    root: HTMLElement,
    data: PlayerData,
    private readonly sceneJson: unknown,
    private readonly live: LiveData,
    makeSimulation: () => Simulation,
    formulas: Formulas,
  ) {
    this.speed = data.settings.speed;
    const host = create("div", { class: "sb-live-picture" });
    const begin = (): Simulation => withFirstInputs(makeSimulation(), live.controls);
    const simulation = begin();
    this.simulation = simulation;
    this.bodies = data.scene.bodies.length - 1;
    // what the view is fitted to, and whether the camera goes along
    this.source = new LiveSource(new StoredMotion(previewOf(begin(), this.bodies, data.source.vectors), this.bodies + 1), this.bodies + 1);
    this.held = live.controls.filter(({ kind }) => kind === "initial").map(({ name }) => name);
    this.firstParameters = new Map(live.tables.map(({ parameter }) => [parameter, simulation.parameter(parameter)]));
    const hint = simulation.numbers.pull === null ? "" : "Drag a body to pull it; drag the background, or hold Shift, to rotate the view.";
    this.bench = new Bench(live.controls, formulas.symbols, formulas.equations, hint, this.speed, {
      togglePlaying: () => { this.setPlaying(!this.playing); },
      step: () => { this.step(); },
      reset: () => { this.reset(); },
      setSpeed: (speed) => { this.speed = speed; },
      change: (control, value) => { this.change(control, value); },
    });
    root.classList.add("sb-live-page");
    root.append(host, this.bench.element);
    this.player = new Player(host, { ...data, source: this.source }, { keysFrom: document, still: true });
    this.followTheme();
    this.pulling = this.createPulling();
    document.addEventListener("keydown", (event) => { this.press(event); }, true);
    this.noteEnergy();
    this.showAll();
    this.setPlaying(data.settings.autoplay && !prefersReducedMotion());
  }

  get isPlaying(): boolean {
    return this.playing;
  }

  setPlaying(playing: boolean): void {
    this.playing = playing;
    this.bench.showPlaying(playing);
    this.before = 0;
    if (playing) this.wake();
  }

  step(): void {
    this.setPlaying(false);
    this.advance(STEP);
    this.showAll();
  }

  reset(): void {
    this.simulation.reset();
    this.noteEnergy();
    this.clearNotes();
    this.showAll();
  }

  /** Follow a slider; where nothing assembles, say so and keep what there is. */
  change(control: Control, value: number): void {
    const { simulation } = this;
    const fits = this.tryValue(control, value);
    for (const row of this.bench.rows) {
      row.mark(row.control === control && !fits);
      if (row.control.kind === "initial" && (fits || row.control !== control)) row.show(simulation.initial(row.control.name));
    }
    this.bench.say(fits ? "" : this.failure(control, value));
    if (fits && control.kind === "parameter") this.followShapes(control.name);
    if (control.kind !== "input") this.noteEnergy();
    this.showAll();
  }

  private tryValue({ kind, name }: Control, value: number): boolean {
    const { simulation } = this;
    if (kind === "input") simulation.setInput(name, value);
    else if (kind === "parameter") return simulation.setParameter(name, value, this.held);
    else return simulation.setInitial(Object.fromEntries(this.held.map((each) => [each, each === name ? value : simulation.initial(each)])), name);
    return true;
  }

  private failure({ kind, name, unit }: Control, value: number): string {
    const last = kind === "parameter" ? this.simulation.parameter(name) : this.simulation.initial(name);
    const [asked, kept] = [value, last].map((each) => `${Number(each.toPrecision(4))}${unit === "" ? "" : ` ${unit}`}`);
    return `The mechanism cannot be assembled with ${name} = ${asked!}. The last value, ${kept!}, is used.`;
  }

  private followShapes(name: string): void {
    const { tables } = this.live;
    if (!tables.some(({ parameter }) => parameter === name)) return;
    const json = sceneFor(this.sceneJson, tables, (each) => this.simulation.parameter(each), (each) => this.firstParameters.get(each)!);
    this.source.show(null); // the view goes by the preview
    this.player.replaceScene(decodeScene(json), this.source);
  }

  private createPulling(): Pulling | null {
    const { viewer } = this.player;
    if (viewer === null || this.simulation.numbers.pull === null) return null;
    const thread = new Thread();
    this.player.stage.append(thread.element);
    const placeOf = (body: number, point: readonly [number, number, number]): readonly [number, number, number] => {
      this.simulation.computePose();
      return this.simulation.placeOf(body, point) as unknown as readonly [number, number, number];
    };
    return new Pulling(viewer, thread, placeOf, {
      hold: (body, point, target) => {
        this.simulation.hold(body, point, target);
        this.setPlaying(true);
      },
      move: (target) => { this.simulation.moveTarget(target); },
      release: () => { this.simulation.release(); },
    });
  }

  private press(event: KeyboardEvent): void {
    const { key, ctrlKey, metaKey, altKey } = event;
    const inField = event.target instanceof HTMLSelectElement || event.target instanceof HTMLButtonElement;
    if (ctrlKey || metaKey || altKey || this.player.help.open || (inField && key === " ")) return;
    const actions: Readonly<Record<string, () => void>> = {
      " ": () => { this.setPlaying(!this.playing); },
      r: () => { this.reset(); },
      ".": () => { this.step(); },
    };
    const action = actions[key];
    if (action === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  private readonly frame = (now: number): void => {
    this.request = 0;
    const seconds = this.before === 0 ? 0 : Math.min((now - this.before) / 1000, MOST_SECONDS);
    this.before = now;
    if (!this.playing) return;
    this.pulling?.update();
    this.advance(seconds * this.speed);
    this.showAll();
    this.wake();
  };

  private wake(): void {
    if (this.request === 0) this.request = requestAnimationFrame(this.frame);
  }

  /** Compute so many seconds of the motion, or as many as there is time for. */
  private advance(seconds: number): void {
    const { simulation } = this;
    const target = simulation.time + seconds;
    const end = performance.now() + BUDGET;
    while (simulation.time < target && performance.now() < end) {
      if (simulation.advanceTo(target, TRIALS) || this.hasEnded) break;
    }
    if (!this.hasEnded) return;
    this.setPlaying(false);
    this.bench.say(this.cause);
  }

  private get hasEnded(): boolean {
    return this.simulation.code !== this.simulation.numbers.codes["RUNNING"];
  }

  private get cause(): string {
    const name = Object.entries(this.simulation.numbers.codes).find(([, code]) => code === this.simulation.code)?.[0] ?? "";
    return `${CAUSES[name] ?? "The motion cannot go on."} Stopped at ${this.simulation.time.toFixed(3)} s.`;
  }

  private clearNotes(): void {
    this.bench.say("");
    for (const row of this.bench.rows) row.mark(false);
  }

  private noteEnergy(): void {
    const { kinetic, potential, work } = this.simulation.energies();
    this.firstEnergy = kinetic + potential - work;
  }

  private showAll(): void {
    this.showPose();
    this.player.refresh();
    this.bench.showReadings(this.readings());
  }

  private readings(): Readings {
    const { kinetic, potential, work } = this.simulation.energies();
    const total = kinetic + potential;
    return { time: this.simulation.time, total, change: total - work - this.firstEnergy, violation: this.simulation.violation() };
  }

  private showPose(): void {
    this.source.show(stateOf(this.simulation, this.bodies));
  }

  private followTheme(): void {
    const apply = (): void => { this.bench.element.dataset["theme"] = this.player.root.dataset["theme"] ?? "light"; };
    new MutationObserver(apply).observe(this.player.root, { attributes: true, attributeFilter: ["data-theme"] });
    apply();
  }
}
