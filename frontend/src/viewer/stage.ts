/** The canvas with its renderer and lights. */

import { Color, DirectionalLight, HemisphereLight, Scene as ThreeScene, WebGLRenderer, type Camera } from "three";
import type { Theme } from "./palette";

export class WebGLMissing extends Error {
  constructor() {
    super("this browser offers no WebGL");
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
  private readonly key = new DirectionalLight("#ffffff", 2.1);
  private readonly rim = new DirectionalLight("#ffffff", 0.7);

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
    this.sky.position.set(...up);
    this.scene.add(this.sky, this.key, this.key.target, this.rim, this.rim.target);
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

  /** Draw, the light from over the viewer's left shoulder. */
  draw(camera: Camera): void {
    camera.updateMatrixWorld();
    this.key.position.set(-0.6, 0.9, 1).applyQuaternion(camera.quaternion);
    this.rim.position.set(0.9, -0.2, -0.6).applyQuaternion(camera.quaternion);
    this.renderer.render(this.scene, camera);
  }

  dispose(): void {
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }
}
