/** Where contacts have touched: dots along their points, which fade with their age. */

import { Color, InstancedMesh, Matrix4, MeshBasicMaterial, SphereGeometry } from "three";
import type { Instant, Layer } from "./layer";
import { FADED, VECTOR_COLORS } from "./palette";
import type { GeometryStore } from "./solids";
import { TOUCH_SIZE, type StateSource } from "./source";

const MOST = 2000; // dots at once
const RADIUS = 0.008; // of the size of what is seen
const SPACING = 0.025; // of it: points that are nearer to the last dot make no other
const FADES = 0.4; // of the motion's length, until a dot has gone

/** The dots of one contact, and how much of its history they were made of. */
interface Trail {
  readonly index: number;
  history: readonly number[];
  read: number;
  touched: boolean;
  /** A time and a place (t, x, y, z) each. */
  dots: number[];
}

export class Footprints implements Layer {
  readonly object: InstancedMesh;
  private readonly trails: Trail[];
  private readonly matrix = new Matrix4();
  private readonly color = new Color();
  private readonly fresh = new Color(VECTOR_COLORS.contact);
  private readonly faded = new Color(FADED);

  constructor(
    private readonly source: StateSource,
    store: GeometryStore,
    private readonly size: number,
  ) {
    const touching = source.vectors.flatMap((each, index) => (each.places !== null && each.prints ? [index] : []));
    this.trails = touching.map((index) => ({ index, history: [], read: 0, touched: false, dots: [] }));
    this.object = new InstancedMesh(store.made("print", () => new SphereGeometry(1, 12, 8)), new MeshBasicMaterial(), this.trails.length === 0 ? 0 : MOST);
    this.object.frustumCulled = false;
    this.object.raycast = () => undefined;
    this.object.count = 0;
  }

  update(instant: Instant): void {
    const now = this.source.timeShown(instant.time);
    const lasts = FADES * (this.source.end - this.source.start);
    let count = 0;
    for (const trail of this.trails) {
      this.read(trail);
      for (let at = 0; at < trail.dots.length && count < MOST; at += 4) {
        const age = lasts > 0 ? (now - trail.dots[at]!) / lasts : 0;
        if (age >= 0 && age < 1) this.put(count++, trail.dots, at, age);
      }
    }
    this.object.count = count;
    this.object.instanceMatrix.needsUpdate = true;
    if (this.object.instanceColor !== null) this.object.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    (this.object.material as MeshBasicMaterial).dispose();
    this.object.dispose();
  }

  /** Make dots of what has been added to the history of a contact, or of another one. */
  private read(trail: Trail): void {
    const history = this.source.touches(trail.index);
    if (history !== trail.history) Object.assign(trail, { history, read: 0, touched: false, dots: [] });
    const near = SPACING * this.size;
    for (; trail.read < history.length; trail.read += TOUCH_SIZE) {
      const [t, acts, x, y, z] = history.slice(trail.read, trail.read + TOUCH_SIZE) as [number, number, number, number, number];
      const [lastX, lastY, lastZ] = trail.dots.slice(-3) as [number, number, number];
      const isFar = !trail.touched || Math.hypot(x - lastX, y - lastY, z - lastZ) > near;
      if (acts > 0 && isFar) trail.dots.push(t, x, y, z);
      trail.touched = acts > 0;
    }
  }

  private put(index: number, dots: readonly number[], at: number, age: number): void {
    const radius = RADIUS * this.size * (1 - 0.6 * age);
    this.matrix.makeScale(radius, radius, radius).setPosition(dots[at + 1]!, dots[at + 2]!, dots[at + 3]!);
    this.object.setMatrixAt(index, this.matrix);
    this.object.setColorAt(index, this.color.lerpColors(this.fresh, this.faded, age));
  }
}
