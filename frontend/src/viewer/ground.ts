/** The ground: a floor with a grid that fades into the distance, under the mechanism or behind a planar one, and its shadows. */

import { Color, DoubleSide, Group, Mesh, PlaneGeometry, Quaternion, ShaderMaterial, ShadowMaterial, Vector3 } from "three";
import { roundDown } from "./arrow_scale";
import type { Scene } from "./contract";
import type { Layer } from "./layer";
import type { Theme } from "./palette";
import { floorNormal, type Extent } from "./paths";

const VERTEX = `
varying vec2 place;
void main() {
  place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
uniform vec3 color;
uniform vec3 floor_;
uniform float opacity;
uniform float cover;
uniform float step_;
uniform float reach;
uniform vec2 offset;
varying vec2 place;
float lines(vec2 at, float width) {
  vec2 slope = max(fwidth(at), vec2(1e-6));
  vec2 near = abs(fract(at - 0.5) - 0.5) / slope;
  float crowd = clamp(1.6 - 2.5 * max(slope.x, slope.y), 0.0, 1.0);
  return crowd * (1.0 - clamp(min(near.x, near.y) / width, 0.0, 1.0));
}
void main() {
  vec2 at = (place + offset) / step_;
  float strength = max(0.45 * lines(at, 1.1), lines(at / 5.0, 1.4));
  float fade = 1.0 - smoothstep(0.25, 1.0, length(place) / reach);
  float line = opacity * strength;
  float alpha = line + cover * (1.0 - line);
  gl_FragColor = vec4((color * line + floor_ * cover * (1.0 - line)) / max(alpha, 1e-4), alpha * fade);
  if (gl_FragColor.a < 0.004) discard;
  #include <colorspace_fragment>
}`;

export class Ground implements Layer {
  readonly object = new Group();
  /** The distance between lines of the grid [m]. */
  readonly spacing: number;
  private readonly floor: Mesh<PlaneGeometry, ShaderMaterial>;
  private readonly shade: Mesh<PlaneGeometry, ShadowMaterial>;
  private readonly home = new Vector3();
  private readonly homeInPlane = new Vector3();
  private readonly toPlane: Quaternion;
  private readonly level: Vector3;

  constructor(scene: Scene, { box, level }: Extent) {
    const center = box.getCenter(new Vector3());
    const extent = box.getSize(new Vector3()).length();
    this.spacing = roundDown(extent / 10);
    const reach = 2 * extent;
    const normal = floorNormal(scene);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal);
    const below = level - 0.004 * scene.size;
    const place = center.clone().addScaledVector(normal, below - center.dot(normal));
    const inPlane = place.clone().applyQuaternion(turn.clone().invert());
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: {
        color: { value: new Color() },
        floor_: { value: new Color() },
        opacity: { value: 0.3 },
        cover: { value: 0 },
        step_: { value: this.spacing },
        reach: { value: reach },
        offset: { value: [inPlane.x, inPlane.y] },
      },
      transparent: true,
      depthWrite: false,
      side: DoubleSide,
    });
    const plane = new PlaneGeometry(2 * reach, 2 * reach);
    this.floor = new Mesh(plane, material);
    this.floor.renderOrder = -2;
    this.shade = new Mesh(plane, new ShadowMaterial({ transparent: true, depthWrite: false, side: DoubleSide }));
    this.shade.receiveShadow = true;
    this.shade.renderOrder = -1;
    for (const each of [this.floor, this.shade]) each.raycast = () => undefined;
    this.object.add(this.floor, this.shade);
    this.object.position.copy(place);
    this.object.quaternion.copy(turn);
    this.home.copy(place);
    this.homeInPlane.copy(inPlane);
    this.toPlane = turn.clone().invert();
    this.level = normal;
  }

  /** Go along with the camera; the lines stay where they are. */
  carry(gone: Vector3): void {
    const along = gone.clone().addScaledVector(this.level, -gone.dot(this.level));
    this.object.position.addVectors(this.home, along);
    along.applyQuaternion(this.toPlane).add(this.homeInPlane);
    this.floor.material.uniforms["offset"]!.value = [along.x, along.y];
  }

  update(): void {
    // fixed on the ground
  }

  setTheme(theme: Theme): void {
    const { uniforms } = this.floor.material;
    (uniforms["color"]!.value as Color).set(theme.grid);
    (uniforms["floor_"]!.value as Color).set(theme.ground);
    uniforms["opacity"]!.value = theme.gridOpacity;
    uniforms["cover"]!.value = theme.groundOpacity;
    this.shade.material.opacity = theme.shadow;
  }

  dispose(): void {
    this.floor.geometry.dispose();
    this.floor.material.dispose();
    this.shade.material.dispose();
  }
}
