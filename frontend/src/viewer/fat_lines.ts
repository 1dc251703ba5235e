/** Lines of a width in pixels. */

import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

/** Return a line through points (P, 3), and its array of segments (P - 1, 2, 3) to be changed in place. */
export function createLine(points: ArrayLike<number>, color: string, width: number): LineSegments2 {
  const count = Math.max(points.length / 3 - 1, 1);
  const segments = new Float32Array(6 * count);
  for (let index = 0; index < count; index += 1) {
    for (let part = 0; part < 6; part += 1) segments[6 * index + part] = points[3 * index + part] ?? points[part % 3] ?? 0;
  }
  const geometry = new LineSegmentsGeometry().setPositions(segments);
  const line = new LineSegments2(geometry, new LineMaterial({ color, linewidth: width }));
  line.frustumCulled = false;
  return line;
}

export function disposeLine(line: LineSegments2): void {
  line.geometry.dispose();
  line.material.dispose();
  line.removeFromParent();
}
