/**
 * What a scene and its motion consist of, as `symbody.visual.scene` writes them.
 *
 * Lengths are in metres. Quaternions have their scalar first and take components in the axes of the part to
 * components in the axes of what carries it.
 */

export type Point = readonly [number, number, number];
export type Quaternion = readonly [number, number, number, number];

export const SOLID_KINDS = ["box", "cylinder", "cone", "sphere", "capsule", "mesh", "line"] as const;
export const CONNECTOR_KINDS = ["spring", "damper", "rope", "actuator", "line"] as const;
export const VECTOR_KINDS = ["force", "torque"] as const;
export type SolidKind = (typeof SOLID_KINDS)[number];
export type ConnectorKind = (typeof CONNECTOR_KINDS)[number];
export type VectorKind = (typeof VECTOR_KINDS)[number];

export interface SceneFrame {
  readonly name: string;
  readonly at: Point;
  readonly quaternion: Quaternion;
}

export interface Solid {
  readonly element: string;
  readonly kind: SolidKind;
  readonly size: readonly number[];
  readonly at: Point;
  readonly quaternion: Quaternion;
  readonly mesh: number | null;
  readonly color: string;
  readonly opacity: number;
}

export interface SceneBody {
  readonly name: string;
  readonly frames: readonly SceneFrame[];
  readonly solids: readonly Solid[];
  readonly mass: number;
}

export interface Anchor {
  readonly body: number;
  readonly at: Point;
}

export interface Connector {
  readonly element: string;
  readonly kind: ConnectorKind;
  readonly start: Anchor;
  readonly end: Anchor;
  readonly radius: number;
  readonly length: number;
  readonly coils: number;
  readonly color: string;
}

export interface SceneJoint {
  readonly name: string;
  readonly type: string;
  readonly start: Anchor;
  readonly end: Anchor;
}

export interface SceneMesh {
  readonly vertices: Float32Array;
  readonly triangles: Uint32Array;
}

/** A mechanism as shapes; the first body is the ground. */
export interface Scene {
  readonly name: string;
  readonly size: number;
  readonly up: Point;
  readonly normal: Point | null;
  readonly gravity: Point | null;
  readonly bodies: readonly SceneBody[];
  readonly connectors: readonly Connector[];
  readonly joints: readonly SceneJoint[];
  readonly meshes: readonly SceneMesh[];
}

export interface MotionCurve {
  readonly name: string;
  readonly unit: string;
  readonly values: Float32Array;
}

export interface MotionVector {
  readonly name: string;
  readonly kind: VectorKind;
  readonly anchor: Anchor;
  readonly values: Float32Array;
  /** Where it acts in ground's axes, if that moves on its body, as points of contact do. */
  readonly places: Float32Array | null;
  /** Whether it leaves footprints there: of a contact with the ground. */
  readonly prints: boolean;
}

export interface MotionEvent {
  readonly name: string;
  readonly t: number;
}

/** Positions (N, B, 3) and quaternions (N, B, 4) of all bodies but the ground at N times. */
export interface Motion {
  readonly times: Float64Array;
  readonly positions: Float32Array;
  readonly quaternions: Float32Array;
  readonly curves: readonly MotionCurve[];
  readonly vectors: readonly MotionVector[];
  readonly events: readonly MotionEvent[];
}
