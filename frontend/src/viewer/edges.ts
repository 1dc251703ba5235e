/** Sharp edges of solids, drawn as thin lines over all instances of a mesh. */

import { EdgesGeometry, LineBasicMaterial, LineSegments, type BufferGeometry, type InstancedBufferAttribute, type InstancedMesh } from "three";
import { EDGE } from "./palette";

const CREASE = 35; // degrees between two faces that meet in an edge
const MOST_TRIANGLES = 4000; // a scanned or modelled part with more has no edges worth drawing

/** Lines drawn once for each instance of a mesh, whose matrices they share. */
class InstancedEdges extends LineSegments<BufferGeometry, LineBasicMaterial> {
  readonly isInstancedMesh = true;
  readonly instanceMatrix: InstancedBufferAttribute;
  readonly instanceColor = null;
  readonly morphTexture = null;

  constructor(
    geometry: BufferGeometry,
    material: LineBasicMaterial,
    private readonly mesh: InstancedMesh,
  ) {
    super(geometry, material);
    this.instanceMatrix = mesh.instanceMatrix;
    this.frustumCulled = false;
    this.raycast = () => undefined;
  }

  override get count(): number {
    return this.mesh.count;
  }
}

/** Return the edges of a geometry, empty where it is round or too fine. */
export function edgesOf(geometry: BufferGeometry): BufferGeometry {
  const corners = geometry.index?.count ?? geometry.getAttribute("position").count;
  return new EdgesGeometry(corners > 3 * MOST_TRIANGLES ? undefined : geometry, CREASE);
}

export function createEdges(mesh: InstancedMesh, edges: BufferGeometry, material: LineBasicMaterial): LineSegments {
  return new InstancedEdges(edges, material, mesh);
}

export function edgeMaterial(): LineBasicMaterial {
  return new LineBasicMaterial({ color: EDGE.color, opacity: EDGE.opacity, transparent: true, depthWrite: false });
}
