/** Lines that are fixed on bodies: curves of cams, surfaces' edges. */

import { Group, Matrix4 } from "three";
import type { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import type { Scene } from "./contract";
import { createLine, disposeLine } from "./fat_lines";
import { placeMatrix, type Instant, type Layer } from "./layer";
import { bodyColor } from "./palette";

interface Entry {
  readonly line: LineSegments2;
  readonly body: number;
  readonly local: Matrix4;
}

export class BodyLines implements Layer {
  readonly object = new Group();
  private readonly entries: Entry[] = [];

  constructor(scene: Scene) {
    scene.bodies.forEach((body, index) => {
      for (const solid of body.solids) {
        if (solid.kind !== "line") continue;
        const color = solid.color === "" ? bodyColor(index) : solid.color;
        const line = createLine(scene.meshes[solid.mesh ?? 0]!.vertices, color, 2.5);
        line.matrixAutoUpdate = false;
        this.entries.push({ line, body: index, local: placeMatrix(solid.at, solid.quaternion) });
        this.object.add(line);
      }
    });
  }

  update(instant: Instant): void {
    for (const { line, body, local } of this.entries) {
      line.matrix.multiplyMatrices(instant.matrices[body]!, local);
      line.matrixWorldNeedsUpdate = true;
    }
  }

  dispose(): void {
    for (const { line } of this.entries) disposeLine(line);
  }
}
