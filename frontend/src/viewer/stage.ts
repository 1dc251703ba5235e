/** The canvas with its renderer and lights: a sky, a sun that casts shadows, and a lamp beside the camera. */

import { Color, DirectionalLight, HemisphereLight, PCFShadowMap, Scene as ThreeScene, Vector3, WebGLRenderer, type Box3, type Camera } from "three";
import type { Scene } from "./contract";
import type { Theme } from "./palette";

const SHADOW_PIXELS = 2048;

export class WebGLMissing extends Error {
  constructor() {
    super("this browser does not support WebGL");
    this.name = "WebGLMissing";
  }
}

export class Stage {
  readonly canvas = document.createElement("canvas");
  readonly scene = new ThreeScene();
  readonly renderer: WebGLRenderer;
  width = 1;
  height = 1;
  private readonly sky = new HemisphereLight("#ffffff", "#c9d2de", 1.7);
  private readonly sun = new DirectionalLight("#ffffff", 1.6);
  private readonly lamp = new DirectionalLight("#ffffff", 1.1);
  private readonly sunTarget = new Vector3();
  private readonly sunPosition = new Vector3();

  constructor(up: readonly [number, number, number]) {
    const context = this.canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (context === null) throw new WebGLMissing();
    this.renderer = new WebGLRenderer({
      canvas: this.canvas,
      context,
      antialias: true,
      alpha: true,
      preserveDrawingBuffer: true,
    });
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
    this.sun.shadow.radius = 3;
    this.sky.position.set(...up);
    this.scene.add(this.sky, this.sun, this.sun.target, this.lamp, this.lamp.target);
  }

  /** Put the sun where its shadows fall on the ground, or on the plane behind a planar mechanism, and hold the box. */
  setSun(scene: Scene, box: Box3): void {
    const radius = Math.max(box.getSize(new Vector3()).length() / 2, 1e-9);
    box.getCenter(this.sunTarget);
    this.sunPosition.copy(sunDirection(scene)).multiplyScalar(3 * radius).add(this.sunTarget);
    const { camera } = this.sun.shadow;
    [camera.left, camera.right, camera.bottom, camera.top] = [-radius, radius, -radius, radius];
    [camera.near, camera.far] = [radius, 8 * radius];
    camera.updateProjectionMatrix();
    this.sun.shadow.normalBias = (4 * radius) / SHADOW_PIXELS;
    this.carry(new Vector3());
  }

  /** Go along with a mechanism that goes far. */
  carry(gone: Vector3): void {
    this.sun.position.addVectors(this.sunPosition, gone);
    this.sun.target.position.addVectors(this.sunTarget, gone);
  }

  setTheme(theme: Theme): void {
    this.sky.color = new Color(theme.sky);
    this.sky.groundColor = new Color(theme.floor);
    this.sky.intensity = 1.7 * theme.light;
  }

  resize(width: number, height: number): void {
    this.width = Math.max(width, 1);
    this.height = Math.max(height, 1);
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(this.width, this.height, false);
  }

  /** Draw, the lamp over the viewer's left shoulder, so that no visible side is dark. */
  draw(camera: Camera): void {
    camera.updateMatrixWorld();
    this.lamp.position.set(-0.6, 0.9, 1).applyQuaternion(camera.quaternion);
    this.renderer.render(this.scene, camera);
  }

  dispose(): void {
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }
}

/** Return the direction to the sun: high over the ground, or in front of a plane and above to its left. */
function sunDirection(scene: Scene): Vector3 {
  const up = new Vector3(...scene.up).normalize();
  const side = Math.abs(up.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  const towards = scene.normal === null ? new Vector3().crossVectors(side, up) : new Vector3(...scene.normal);
  towards.normalize();
  const right = new Vector3().crossVectors(up, towards).normalize();
  const [high, near, aside] = scene.normal === null ? [1, 0.3, 0.35] : [0.22, 1, 0.14];
  return up.multiplyScalar(high).addScaledVector(towards, near).addScaledVector(right, -aside).normalize();
}
