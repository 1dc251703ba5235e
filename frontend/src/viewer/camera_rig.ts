/** The camera: orbit, pan, zoom, standard views, and a view that holds the whole motion. */

import { MathUtils, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Scene } from "./contract";
import type { Extent } from "./paths";

export const VIEW_NAMES = ["front", "top", "right", "isometric"] as const;
export type ViewName = (typeof VIEW_NAMES)[number];

const ANGLE = 30; // of the perspective, degrees
const PARALLEL_ANGLE = 1; // so small that parallels look parallel
const MARGIN = 1.16;
const TURN_SECONDS = 0.28;
const LARGE = 0.6; // of the size at which a motion fills the picture: it is left as it is
const CUT = 1.1; // of the picture: a pin that its edge cuts is no reason to jump
const GAP = 12; // pixels that stay free beside what is shifted out of a corner

/** What of the picture is not to be used, in pixels: the top, and a corner below on the left. */
export interface Covered {
  readonly top: number;
  readonly corner: readonly [width: number, height: number];
}

export const NOTHING_COVERED: Covered = { top: 0, corner: [0, 0] };

export interface Placement {
  readonly position: Vector3;
  readonly target: Vector3;
}

interface Reach {
  readonly right: Vector3;
  readonly above: Vector3;
  readonly wide: number;
  readonly high: number;
  readonly across: readonly [right: number, left: number];
  readonly along: readonly [up: number, down: number];
}

interface Turn {
  readonly fromOffset: Vector3;
  readonly toOffset: Vector3;
  readonly fromTarget: Vector3;
  readonly toTarget: Vector3;
  started: number;
}

/** Return the direction from the mechanism to the camera of a standard view. */
export function viewDirection(scene: Scene, view: ViewName): Vector3 {
  const up = new Vector3(...scene.up).normalize();
  const front = frontDirection(scene, up);
  const right = new Vector3().crossVectors(up, front).normalize();
  switch (view) {
    case "front":
      return front;
    case "right":
      return right;
    case "top":
      return up.addScaledVector(front, 1e-4).normalize();
    case "isometric":
      return front.add(right).add(up).normalize();
  }
}

/** Of a planar mechanism its normal; else level, such that x runs to the right if it can. */
function frontDirection(scene: Scene, up: Vector3): Vector3 {
  if (scene.normal !== null) {
    const normal = new Vector3(...scene.normal).normalize();
    if (Math.abs(normal.dot(up)) < 0.99) return normal;
  }
  const side = Math.abs(up.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  return new Vector3().crossVectors(side, up).normalize();
}

export class CameraRig {
  readonly camera = new PerspectiveCamera(ANGLE, 1, 0.01, 1000);
  readonly controls: OrbitControls;
  private turn: Turn | null = null;
  private fits = true; // until the user moves the camera
  private radius: number;
  private readonly up: Vector3;
  private height = 1;
  private covered = NOTHING_COVERED;
  private readonly gone = new Vector3(); // how far the camera has gone along with the mechanism

  constructor(
    canvas: HTMLElement,
    private scene: Scene,
    private extent: Extent,
    private readonly animate: () => boolean,
    invalidate: () => void,
  ) {
    this.up = new Vector3(...scene.up).normalize();
    this.camera.up.copy(this.up); // before the controls, which read it once
    this.radius = extent.box.getSize(new Vector3()).length() / 2;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = animate();
    this.controls.dampingFactor = 0.18;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", invalidate);
    this.controls.addEventListener("start", () => {
      this.turn = null;
      this.fits = false;
    });
  }

  /** Take a scene of other sizes or another start: the camera stays while it holds the motion, or where the user moved it. */
  takeScene(scene: Scene, extent: Extent): void {
    this.scene = scene;
    this.extent = extent;
    this.radius = extent.box.getSize(new Vector3()).length() / 2;
    if (this.fits && !this.holds()) this.fit(true);
  }

  get distance(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  /** Pixels of a metre at the target. */
  get pixelsPerMetre(): number {
    return this.height / (2 * this.distance * Math.tan(MathUtils.degToRad(this.camera.fov) / 2));
  }

  get parallel(): boolean {
    return this.camera.fov === PARALLEL_ANGLE;
  }

  resize(width: number, height: number, covered: Covered): void {
    this.height = height;
    this.covered = covered;
    this.camera.setViewOffset(width, height, 0, -covered.top / 2, width, height);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    if (this.fits && this.turn === null) this.fit(true);
  }

  /** Look from a standard direction at the whole motion. */
  view(view: ViewName, now: boolean): void {
    this.moveTo(viewDirection(this.scene, view), now);
  }

  /** Hold the whole motion in the picture, from the present direction. */
  fit(now = false): void {
    this.moveTo(this.offset().normalize(), now);
  }

  setParallel(parallel: boolean): void {
    const before = Math.tan(MathUtils.degToRad(this.camera.fov) / 2);
    this.camera.fov = parallel ? PARALLEL_ANGLE : ANGLE;
    const after = Math.tan(MathUtils.degToRad(this.camera.fov) / 2);
    const offset = this.offset().multiplyScalar(before / after);
    this.camera.position.copy(this.controls.target).add(offset);
    this.camera.updateProjectionMatrix();
    if (this.fits) this.fit(true);
    else this.finish();
  }

  /** Turn by angles [rad] to the left and up. */
  orbit(left: number, up: number): void {
    const offset = this.offset().applyAxisAngle(this.up, left);
    const height = offset.angleTo(this.up);
    const pitch = MathUtils.clamp(height - up, 0.01, Math.PI - 0.01) - height;
    const right = new Vector3().crossVectors(this.up, offset).normalize();
    offset.applyAxisAngle(right, pitch);
    this.camera.position.copy(this.controls.target).add(offset);
    this.finish();
  }

  /** Shift the picture by parts of its height. */
  pan(right: number, up: number): void {
    const metres = this.height / this.pixelsPerMetre;
    const shift = new Vector3(right * metres, up * metres, 0).applyQuaternion(this.camera.quaternion);
    this.camera.position.sub(shift);
    this.controls.target.sub(shift);
    this.finish();
  }

  /** Go along with something that moves. */
  shift(by: Vector3): void {
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.turn = null;
    this.fits = false;
  }

  /** Go along with a mechanism that goes far, by so much since the start of the motion. */
  carry(gone: Vector3): void {
    const by = gone.clone().sub(this.gone);
    if (by.lengthSq() === 0) return;
    this.gone.copy(gone);
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.turn?.fromTarget.add(by);
    this.turn?.toTarget.add(by);
  }

  /** Where the camera is, to be taken back by `place`. */
  get placement(): Placement {
    return { position: this.camera.position.clone(), target: this.controls.target.clone() };
  }

  place({ position, target }: Placement): void {
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.finish();
  }

  /** Take the view of another camera; one that the user has not moved goes on holding the whole motion. */
  take(other: CameraRig): void {
    this.camera.position.copy(other.camera.position);
    this.camera.quaternion.copy(other.camera.quaternion);
    this.controls.target.copy(other.controls.target);
    this.controls.update();
    this.fits = other.fits;
  }

  zoom(factor: number): void {
    const offset = this.offset().divideScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
    this.finish();
  }

  /** Go on with a turn or with damping; return whether more is to come. */
  step(now: number): boolean {
    const turning = this.turn !== null && this.stepTurn(this.turn, now);
    const moved = this.controls.update();
    const distance = this.distance;
    this.camera.near = Math.max(distance - 6 * this.radius, 0.005 * distance);
    this.camera.far = distance + 12 * this.radius;
    this.camera.updateProjectionMatrix();
    return turning || moved;
  }

  dispose(): void {
    this.controls.dispose();
  }

  private offset(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target);
  }

  private finish(fits = false): void {
    this.turn = null;
    this.fits = fits;
    this.controls.update();
    this.controls.dispatchEvent({ type: "change" });
  }

  private moveTo(direction: Vector3, now: boolean): void {
    const { target, distance } = this.fitted(direction);
    const offset = direction.clone().multiplyScalar(distance);
    if (now || !this.animate()) {
      this.controls.target.copy(target);
      this.camera.position.copy(target).add(offset);
      this.finish(true);
      return;
    }
    this.fits = true;
    this.turn = {
      fromOffset: this.offset(),
      toOffset: offset,
      fromTarget: this.controls.target.clone(),
      toTarget: target,
      started: NaN,
    };
    this.controls.dispatchEvent({ type: "change" });
  }

  private stepTurn(turn: Turn, now: number): boolean {
    if (Number.isNaN(turn.started)) turn.started = now;
    const part = MathUtils.clamp((now - turn.started) / (1000 * TURN_SECONDS), 0, 1);
    const eased = part * part * (3 - 2 * part);
    const length = MathUtils.lerp(turn.fromOffset.length(), turn.toOffset.length(), eased);
    const offset = turn.fromOffset.clone().normalize().lerp(turn.toOffset.clone().normalize(), eased);
    if (offset.lengthSq() < 1e-6) offset.copy(turn.toOffset); // opposite directions
    offset.setLength(length);
    this.controls.target.lerpVectors(turn.fromTarget, turn.toTarget, eased);
    this.camera.position.copy(this.controls.target).add(offset);
    if (part >= 1) this.turn = null;
    return part < 1;
  }

  /** Whether every point of the motion is in the free part of the picture, and fills enough of it. */
  private holds(): boolean {
    const direction = this.offset().normalize();
    const reached = this.reach(direction, this.controls.target.clone().sub(this.gone));
    return Math.max(...reached.across, ...reached.along) <= CUT * this.distance && this.fitted(direction).distance >= LARGE * this.distance;
  }

  /** How far a motion reaches from a place towards the four sides: a point at (x, y, z) is inside if |x| / tan + z <= distance. */
  private reach(direction: Vector3, place: Vector3): Reach {
    const right = new Vector3().crossVectors(this.up, direction);
    if (right.lengthSq() < 1e-8) right.set(1, 0, 0);
    right.normalize();
    const above = new Vector3().crossVectors(direction, right);
    const tan = Math.tan(MathUtils.degToRad(this.camera.fov) / 2);
    const [wide, high] = [tan * this.camera.aspect, tan * (1 - this.covered.top / this.height)];
    return { right, above, wide, high, across: this.sides(right, direction, wide, place), along: this.sides(above, direction, high, place) };
  }

  /** The target and the distance at which every point of the motion, or of a mechanism that is followed, is in the middle of the picture. */
  private fitted(direction: Vector3): { target: Vector3; distance: number } {
    const middle = this.extent.box.getCenter(new Vector3());
    const { right, above, wide, high, across, along } = this.reach(direction, middle);
    const [width, height] = [(across[0] + across[1]) / 2, (along[0] + along[1]) / 2];
    const distance = Math.max(MARGIN * Math.max(width, height), 0.05 * this.scene.size);
    const [left, down] = this.offCorner(width / distance, height / distance);
    const target = middle
      .addScaledVector(right, ((across[0] - across[1]) / 2 - left * distance) * wide)
      .addScaledVector(above, ((along[0] - along[1]) / 2 - down * distance) * high)
      .add(this.gone);
    return { target, distance };
  }

  /** How far the target goes to the left or down, by halves of the free picture, for the motion to leave the corner, where there is room. */
  private offCorner(width: number, height: number): [left: number, down: number] {
    const half = [(this.height * this.camera.aspect) / 2, (this.height - this.covered.top) / 2] as const;
    const beside = [(1 - width) * half[0], (1 - height) * half[1]] as const;
    const needed = [this.covered.corner[0] - beside[0], this.covered.corner[1] - beside[1]] as const;
    if (needed[0] <= 0 || needed[1] <= 0) return [0, 0];
    if (needed[1] <= beside[1] - GAP) return [0, needed[1] / half[1]];
    return needed[0] <= beside[0] - GAP ? [needed[0] / half[0], 0] : [0, 0];
  }

  /** The largest of z + x / tan and of z - x / tan over all points. */
  private sides(axis: Vector3, direction: Vector3, tan: number, middle: Vector3): [number, number] {
    const { points } = this.extent;
    const point = new Vector3();
    let [more, less] = [-Infinity, -Infinity];
    for (let at = 0; at < points.length; at += 3) {
      point.fromArray(points, at).sub(middle);
      const across = point.dot(axis) / tan;
      const towards = point.dot(direction);
      more = Math.max(more, towards + across);
      less = Math.max(less, towards - across);
    }
    return [more, less];
  }
}
