/** The viewer: what pages, the widget and the editor import. */

export { VECTOR_GROUPS, vectorGroup, type VectorGroup } from "./arrows";
export { formatQuantity, roundDown } from "./arrow_scale";
export { VIEW_NAMES, type Covered, type ViewName } from "./camera_rig";
export { Clock, SPEEDS } from "./clock";
export { castOf } from "./contents";
export type * from "./contract";
export { decodeMotion, decodeScene } from "./decode";
export type { SceneElement } from "./layer";
export { bodyColor, BODY_COLORS, VECTOR_COLORS, type ThemeChoice, type ThemeName } from "./palette";
export { DataError, Reader } from "./reader";
export type { Look } from "./solids";
export { LiveSource, restPose, sampleBefore, sourceOf, StoredMotion, type LiveState, type Pose, type StateSource } from "./source";
export { WebGLMissing } from "./stage";
export { tracePoints, type TraceMode, type TracePoint } from "./traces";
export { Viewer, type Shown, type ViewerHooks } from "./viewer";
