/** The picture of a mechanism in an element of a page; free of any framework. */

import { Vector3 } from "three";
import { VECTOR_GROUPS, type VectorArrows } from "./arrows";
import { CameraRig, NOTHING_COVERED, type Covered, type ViewName } from "./camera_rig";
import type { Connectors } from "./connectors";
import { Contents } from "./contents";
import type { Scene, VectorKind } from "./contract";
import { Labels } from "./labels";
import { labelItems } from "./label_items";
import { anchorPoint, writeMatrices, type Counts, type Instant, type SceneElement } from "./layer";
import type { JointMarks } from "./marks";
import { NO_LIGHTS, THEMES, type Lights, type ThemeName } from "./palette";
import { centreOf, chosenTimes, visitStates } from "./paths";
import { elementNamed, Picker } from "./picker";
import { Solids, type Look } from "./solids";
import type { StateSource } from "./source";
import { Stage } from "./stage";
import { tracePoints, type TraceMode } from "./traces";

/** A point of a body, in its axes [m], by which it is held. */
export interface Grab {
  readonly body: number;
  readonly point: readonly [number, number, number];
}

/** A line of sight in ground's axes [m]. */
export interface Sight {
  readonly origin: readonly [number, number, number];
  readonly direction: readonly [number, number, number];
}

const GHOST_OPACITY = 0.16;

/** What of the picture is shown. */
export interface Shown {
  frames: boolean;
  joints: boolean;
  labels: boolean;
  grid: boolean;
  force: boolean;
  torque: boolean;
  contact: boolean;
  reaction: boolean;
  footprints: boolean;
}

export interface ViewerHooks {
  /** Called when something changed that the next `render` will draw. */
  invalidate: () => void;
  onSelect?: (element: SceneElement | null) => void;
  onHover?: (element: SceneElement | null, x: number, y: number) => void;
  /** Whether the camera may glide; not where reduced motion is preferred. */
  animate: () => boolean;
  /** What something covers: the mechanism is shown beside it. */
  covered?: () => Covered;
}

export class Viewer {
  readonly counts: Counts = { rebuilt: 0, frames: 0 };
  readonly rig: CameraRig;
  readonly shown: Shown = {
    frames: false, joints: false, labels: false, grid: true, force: true, torque: true, contact: true, reaction: true, footprints: true,
  };
  selected: SceneElement | null = null;
  private readonly stage: Stage;
  private contents: Contents;
  /** Those of before, whose programs the new ones take over when they are drawn. */
  private former: Contents | null = null;
  private labels: Labels;
  private picker: Picker;
  private readonly watcher: ResizeObserver;
  private readonly firstRebuilt: number;
  private ghosts: Solids | null = null;
  private look: Look = "solid";
  private hovered = "";
  private lights = NO_LIGHTS;
  private followed = false;
  private readonly followedTo = new Vector3();
  private readonly here = new Vector3();
  private stale = true;

  /** Throws `WebGLMissing` where the browser has none. */
  constructor(
    readonly host: HTMLElement,
    scene: Scene,
    source: StateSource,
    private readonly hooks: ViewerHooks,
  ) {
    this.stage = new Stage(scene.up);
    this.contents = new Contents(scene, source, this.counts);
    this.addContents();
    this.picker = new Picker(scene, this);
    this.firstRebuilt = this.counts.rebuilt;
    host.append(this.stage.canvas);
    this.rig = new CameraRig(this.stage.canvas, scene, this.contents.extent, hooks.animate, hooks.invalidate);
    this.labels = new Labels(labelItems(scene, source, this));
    host.append(this.labels.element);
    this.watcher = new ResizeObserver(() => { this.resize(); });
    this.watcher.observe(host);
    // a driver may take the context away; three.js makes it anew, and the picture is drawn again
    this.stage.canvas.addEventListener("webglcontextrestored", () => { this.setTime(this.instant.time); });
    this.resize();
    this.rig.view(scene.normal === null ? "isometric" : "front", true);
  }

  get scene(): Scene {
    return this.contents.scene;
  }

  get source(): StateSource {
    return this.contents.source;
  }

  get solids(): Solids {
    return this.contents.solids;
  }

  get connectors(): Connectors {
    return this.contents.connectors;
  }

  get arrows(): VectorArrows {
    return this.contents.arrows;
  }

  get joints(): JointMarks {
    return this.contents.joints;
  }

  /** Whether the mechanism goes far, so that the camera may go along with it. */
  get roams(): boolean {
    return this.contents.extent.roams;
  }

  private get instant(): Instant & { time: number } {
    return this.contents.instant;
  }

  /** Draw a scene of the same mechanism, of other sizes, from now on; what is shown of it is to be set again. */
  replaceScene(scene: Scene, source: StateSource): void {
    this.setGhosts(0);
    this.former?.dispose();
    this.former = this.contents;
    for (const layer of this.former.layers) layer.object.removeFromParent();
    this.contents = new Contents(scene, source, this.counts, this.former);
    this.addContents();
    this.picker = new Picker(scene, this);
    const labels = new Labels(labelItems(scene, source, this));
    this.labels.element.replaceWith(labels.element);
    this.labels = labels;
    this.rig.takeScene(scene, this.contents.extent);
    this.paint();
    this.setTime(source.start);
  }

  get canvas(): HTMLCanvasElement {
    return this.stage.canvas;
  }

  /** What tests and the next tools need to see of the picture. */
  get statistics(): { frames: number; rebuilt: number; calls: number; solids: number; triangles: number } {
    const { calls, triangles } = this.stage.renderer.info.render;
    const rebuilt = this.counts.rebuilt - this.firstRebuilt;
    return { frames: this.counts.frames, rebuilt, calls, solids: this.solids.count, triangles };
  }

  setTime(time: number): void {
    this.instant.time = time;
    this.stale = true;
    this.hooks.invalidate();
  }

  setTheme(name: ThemeName): void {
    const theme = THEMES[name];
    this.stage.setTheme(theme);
    for (const layer of this.contents.layers) layer.setTheme?.(theme);
    this.hooks.invalidate();
  }

  show(what: keyof Shown, on: boolean): void {
    this.shown[what] = on;
    this.contents.axes.object.visible = this.shown.frames;
    this.joints.object.visible = this.shown.joints;
    this.contents.ground.object.visible = this.shown.grid;
    this.contents.footprints.object.visible = this.shown.footprints;
    for (const group of VECTOR_GROUPS) this.arrows.shown[group] = this.shown[group];
    this.setTime(this.instant.time);
  }

  setLook(look: Look): void {
    this.look = look;
    this.solids.setLook(look);
    this.connectors.setWire(look === "wire");
    this.ghosts?.setLook(look === "wire" ? "wire" : "solid");
    this.hooks.invalidate();
  }

  setArrowFactor(factor: number): void {
    this.arrows.factor = factor;
    this.setTime(this.instant.time);
  }

  metresPer(kind: VectorKind): number {
    return this.arrows.metresPer(kind);
  }

  /** Draw so many translucent copies along the motion. */
  setGhosts(count: number): void {
    this.ghosts?.dispose();
    this.ghosts = null;
    if (count > 0) {
      const ghosts = new Solids(this.scene, this.contents.store, count, GHOST_OPACITY, 1);
      visitStates(this.scene, this.source, chosenTimes(this.source, count), (instant, copy) => {
        ghosts.writeCopy(copy, instant.matrices);
      });
      ghosts.object.traverse((each) => { each.raycast = () => undefined; });
      this.ghosts = ghosts;
      this.stage.scene.add(ghosts.object);
      this.setLook(this.look);
    }
    this.hooks.invalidate();
  }

  /** Trace these points ("body.frame") and no others. */
  setTraces(names: readonly string[], mode: TraceMode): void {
    this.contents.traces.mode = mode;
    this.contents.traces.choose(tracePoints(this.scene).filter((point) => names.includes(point.name)));
    this.setTime(this.instant.time);
  }

  view(name: ViewName, now = false): void {
    this.rig.view(name, now);
  }

  /** Mark an element, or none; the callback hears of it. */
  select(element: SceneElement | string | null): void {
    this.selected = typeof element === "string" ? elementNamed(this.scene, element) : element;
    this.setFollow(this.followed);
    this.paint();
    this.hooks.onSelect?.(this.selected);
  }

  /** Light up elements by their names, each as strongly as is said. */
  light(lights: Lights): void {
    if (lights.size === 0 && this.lights.size === 0) return;
    this.lights = lights;
    this.paint();
  }

  /** Mark what is under the pointer; coordinates in the page. */
  pointAt(pageX: number, pageY: number): SceneElement | null {
    const element = this.elementAt(pageX, pageY);
    const name = element?.name ?? "";
    if (name !== this.hovered) {
      this.hovered = name;
      this.paint();
    }
    this.hooks.onHover?.(element, pageX, pageY);
    return element;
  }

  clearPointer(): void {
    if (this.hovered !== "") {
      this.hovered = "";
      this.paint();
    }
    this.hooks.onHover?.(null, 0, 0);
  }

  elementAt(pageX: number, pageY: number): SceneElement | null {
    return this.picker.pick(...this.across(pageX, pageY), this.rig.camera);
  }

  /** Return the moving body at a place of the page, and the point of it that is seen there; or null. */
  grabAt(pageX: number, pageY: number): Grab | null {
    const hit = this.picker.hit(...this.across(pageX, pageY), this.rig.camera);
    if (hit === null || !["body", "part", "joint"].includes(hit.element.kind)) return null;
    const { body } = hit.element;
    const matrix = this.instant.matrices[body];
    if (body === 0 || matrix === undefined) return null;
    const [x, y, z] = hit.point.applyMatrix4(matrix.clone().invert()).toArray();
    return { body, point: [x, y, z] };
  }

  /** Return the line of sight at a place of the page. */
  sightAt(pageX: number, pageY: number): Sight {
    const { origin, direction } = this.picker.sight(...this.across(pageX, pageY), this.rig.camera);
    return { origin: [origin.x, origin.y, origin.z], direction: [direction.x, direction.y, direction.z] };
  }

  /** Return where in the page a point in ground's axes is seen. */
  pagePlace(point: readonly [number, number, number]): [number, number] {
    const area = this.stage.canvas.getBoundingClientRect();
    const { x, y } = new Vector3(...point).project(this.rig.camera);
    return [area.left + ((x + 1) / 2) * area.width, area.top + ((1 - y) / 2) * area.height];
  }

  /** Write where an element is now, in ground's axes [m]; return whether it has a place. */
  positionOf(element: SceneElement, into: Vector3): boolean {
    const joint = this.scene.joints.find((each) => each.name === element.name);
    if (element.kind === "joint" && joint !== undefined) {
      anchorPoint(joint.start, this.instant, into);
      return true;
    }
    const matrix = this.instant.matrices[element.body];
    if (matrix === undefined) return false;
    into.setFromMatrixPosition(matrix);
    return true;
  }

  bodyPosition(body: number, into: Vector3): Vector3 {
    return into.setFromMatrixPosition(this.instant.matrices[body]!);
  }

  /** Where a vector's arrow ends, or null where it isn't drawn. */
  vectorTip(index: number): Vector3 | null {
    return this.arrows.tip(index);
  }

  /** Draw; return whether the camera still moves. */
  render(now: number): boolean {
    const moving = this.rig.step(now);
    if (this.stale) {
      this.source.poseAt(this.instant.time, this.contents.pose);
      writeMatrices(this.contents.pose, this.instant.matrices);
      for (const layer of this.contents.layers) layer.update(this.instant);
      this.stale = false;
      this.goOn();
    }
    this.stage.draw(this.rig.camera);
    this.former?.dispose();
    this.former = null;
    this.labels.update(this.rig.camera, this.stage.width, this.stage.height);
    this.counts.frames += 1;
    return moving;
  }

  dispose(): void {
    this.watcher.disconnect();
    this.rig.dispose();
    this.ghosts?.dispose();
    this.former?.dispose();
    this.contents.dispose();
    this.labels.element.remove();
    this.stage.dispose();
  }

  /** Let the camera go with a mechanism that goes far; else look at the selected body or the centre of mass, and go with it. */
  setFollow(follow: boolean): void {
    this.followed = follow;
    if (!follow || this.roams) return;
    this.followedTo.copy(this.rig.controls.target);
    this.goWith();
  }

  private addContents(): void {
    for (const layer of this.contents.layers) this.stage.scene.add(layer.object);
    this.stage.setSun(this.scene, this.contents.extent.box);
  }

  private goOn(): void {
    if (!this.followed) return;
    if (this.roams) {
      this.contents.travel(this.here);
      this.rig.carry(this.here);
      this.contents.ground.carry(this.here);
      this.stage.carry(this.here);
    } else {
      this.goWith();
    }
  }

  private goWith(): void {
    if (this.selected === null) centreOf(this.scene, this.instant.matrices, this.here);
    else this.bodyPosition(this.selected.body, this.here);
    this.rig.shift(this.followedTo.subVectors(this.here, this.followedTo));
    this.followedTo.copy(this.here);
  }

  /** Return a place of the page as parts of the picture, from -1 to 1 across it and upwards. */
  private across(pageX: number, pageY: number): [number, number] {
    const area = this.stage.canvas.getBoundingClientRect();
    return [(2 * (pageX - area.left)) / area.width - 1, 1 - (2 * (pageY - area.top)) / area.height];
  }

  private paint(): void {
    const selected = this.selected?.name ?? "";
    for (const layer of [this.solids, this.connectors, this.joints, this.arrows]) layer.paint(selected, this.hovered, this.lights);
    this.hooks.invalidate();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.stage.resize(clientWidth, clientHeight);
    this.rig.resize(clientWidth, clientHeight, this.hooks.covered?.() ?? NOTHING_COVERED);
    this.hooks.invalidate();
  }
}
