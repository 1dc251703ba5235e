/** Scenes and motions from their JSON form, checked. */

import {
  CONNECTOR_KINDS,
  SOLID_KINDS,
  VECTOR_KINDS,
  type Anchor,
  type Connector,
  type Motion,
  type MotionCurve,
  type MotionVector,
  type Point,
  type Quaternion,
  type Scene,
  type SceneBody,
  type SceneFrame,
  type SceneJoint,
  type SceneMesh,
  type Solid,
  type SolidKind,
} from "./contract";
import { DataError, Reader } from "./reader";

const VERSION = 1;
const SIZES: Record<SolidKind, number> = { box: 3, cylinder: 2, cone: 2, sphere: 1, capsule: 2, mesh: 3, line: 0 };

/** Return the scene of a JSON value, or throw a `DataError` that names the damaged place. */
export function decodeScene(value: unknown): Scene {
  const data = new Reader(value, "scene");
  data.version(VERSION);
  const meshes = data.field("meshes").items().map(readMesh);
  const bodies = data.field("bodies").items().map((each) => readBody(each, meshes.length));
  if (bodies.length === 0) throw new DataError("scene.bodies", "is empty; the first body is the ground");
  const size = data.field("size").number();
  if (size <= 0) throw new DataError("scene.size", "is not positive");
  return {
    name: data.field("name").text(),
    size,
    up: point(data.field("up")),
    normal: optionalPoint(data.field("normal")),
    gravity: optionalPoint(data.field("gravity")),
    bodies,
    connectors: data.field("connectors").items().map((each) => readConnector(each, bodies.length)),
    joints: data.field("joints").items().map((each) => readJoint(each, bodies.length)),
    meshes,
  };
}

/** Return the motion of a JSON value for a scene of so many bodies, ground counted. */
export function decodeMotion(value: unknown, bodies: number): Motion {
  const data = new Reader(value, "motion");
  data.version(VERSION);
  const times = data.field("times").doubles();
  const count = times.length;
  if (count === 0) throw new DataError("motion.times", "is empty");
  for (let index = 1; index < count; index += 1) {
    if (times[index]! < times[index - 1]!) throw new DataError("motion.times", "does not ascend");
  }
  return {
    times,
    positions: data.field("positions").floats(count * (bodies - 1) * 3),
    quaternions: data.field("quaternions").floats(count * (bodies - 1) * 4),
    curves: data.field("curves").items().map((each) => readCurve(each, count)),
    vectors: data.field("vectors").items().map((each) => readVector(each, count, bodies)),
    events: data
      .field("events")
      .items()
      .map((each) => ({ name: each.field("name").text(), t: each.field("t").number() })),
  };
}

function point(data: Reader): Point {
  return data.numbers(3) as unknown as Point;
}

function optionalPoint(data: Reader): Point | null {
  return data.isNull ? null : point(data);
}

function quaternion(data: Reader): Quaternion {
  return data.numbers(4) as unknown as Quaternion;
}

function readMesh(data: Reader): SceneMesh {
  const vertices = data.field("vertices").floats();
  if (vertices.length % 3 !== 0) throw new DataError(`${data.where}.vertices`, "is truncated");
  const triangles = data.field("triangles").integers();
  const count = vertices.length / 3;
  if (triangles.length % 3 !== 0 || triangles.some((index) => index >= count)) {
    throw new DataError(`${data.where}.triangles`, "refers to vertices that are missing");
  }
  return { vertices, triangles };
}

function readBody(data: Reader, meshes: number): SceneBody {
  return {
    name: data.field("name").text(),
    frames: data.field("frames").items().map(readFrame),
    solids: data.field("solids").items().map((each) => readSolid(each, meshes)),
    mass: data.field("mass").number(),
  };
}

function readFrame(data: Reader): SceneFrame {
  return {
    name: data.field("name").text(),
    at: point(data.field("at")),
    quaternion: quaternion(data.field("quaternion")),
  };
}

function readSolid(data: Reader, meshes: number): Solid {
  const kind = data.field("kind").choice(SOLID_KINDS);
  const refers = kind === "mesh" || kind === "line";
  return {
    element: data.field("element").text(),
    kind,
    size: data.field("size").numbers(SIZES[kind]),
    at: point(data.field("at")),
    quaternion: quaternion(data.field("quaternion")),
    mesh: refers ? data.field("mesh").index(meshes) : null,
    color: color(data.field("color")),
    opacity: data.field("opacity").number(),
  };
}

function color(data: Reader): string {
  const text = data.text();
  if (text !== "" && !/^#[0-9a-f]{6}$/i.test(text)) throw new DataError(data.where, 'is not "#rrggbb"');
  return text;
}

function readAnchor(data: Reader, bodies: number): Anchor {
  return { body: data.field("body").index(bodies), at: point(data.field("at")) };
}

function readConnector(data: Reader, bodies: number): Connector {
  return {
    element: data.field("element").text(),
    kind: data.field("kind").choice(CONNECTOR_KINDS),
    start: readAnchor(data.field("start"), bodies),
    end: readAnchor(data.field("end"), bodies),
    radius: data.field("radius").number(),
    length: data.field("length").number(),
    coils: data.field("coils").number(),
    color: color(data.field("color")),
  };
}

function readJoint(data: Reader, bodies: number): SceneJoint {
  return {
    name: data.field("name").text(),
    type: data.field("type").text(),
    start: readAnchor(data.field("start"), bodies),
    end: readAnchor(data.field("end"), bodies),
  };
}

function readCurve(data: Reader, count: number): MotionCurve {
  return {
    name: data.field("name").text(),
    unit: data.field("unit").text(),
    values: data.field("values").floats(count),
  };
}

function readVector(data: Reader, count: number, bodies: number): MotionVector {
  const places = data.field("places");
  return {
    name: data.field("name").text(),
    kind: data.field("kind").choice(VECTOR_KINDS),
    anchor: readAnchor(data.field("anchor"), bodies),
    values: data.field("values").floats(count * 3),
    places: places.isNull ? null : places.floats(count * 3),
    prints: !data.field("prints").isNull,
  };
}
