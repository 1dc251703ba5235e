/** What a new contact begins with: shapes of the bodies that it joins, and a force law. */

import { symbolOf } from "./coordinates";
import { entriesOf, GROUND, referenceOf, textOf } from "./entries";
import { isArray, isObject } from "./pointers";
import type { Json, JsonObject, Model } from "../types";

/** Stiff enough for bodies of some kilograms; half the speed is left after an impact with 1 m/s. */
export const USUAL_LAW: JsonObject = { stiffness: "1e5", restitution: "0.5", speed: "1" };
const BALL: JsonObject = { sphere: "0.1" };

/** The sizes of shapes that are drawn, in the order of shapes that touch. */
const SIZES: Readonly<Record<string, readonly string[]>> = {
  sphere: ["radius"], cylinder: ["radius", "length"], capsule: ["radius", "length"],
};

/** Return a shape that touches like the one that a body is drawn with; a ball for what has none. */
function drawnShape(data: Model, body: string): JsonObject {
  const own = entriesOf(data).find((each) => each.section === "body" && each.name === body)?.value["shape"];
  const first = isArray(own) ? own[0] : undefined;
  if (!isObject(first)) return BALL;
  const type = textOf(first["type"]);
  if (type === "box" && isArray(first["size"])) return { box: first["size"] };
  const sizes = (SIZES[type] ?? []).map((name) => first[name] ?? "0.1");
  return sizes.length === 0 ? BALL : { [type]: sizes.length === 1 ? sizes[0]! : sizes };
}

function shapeAt(data: Model, reference: string): Json {
  const { body } = referenceOf(reference);
  return body === GROUND ? "plane" : drawnShape(data, body);
}

/** Return a shape that touches any of the others: there are formulas for all of them with a ball, but for a cylinder. */
function round(shape: Json): Json {
  return isObject(shape) && (shape["cylinder"] !== undefined || shape["box"] !== undefined) ? BALL : shape;
}

/** Return what a new contact between two frames begins with: the ground is a plane. */
export function contactFields(data: Model, ends: readonly [string, string] | null): JsonObject {
  const [start, end] = ends === null ? ["plane", BALL] : ends.map((each) => shapeAt(data, each));
  const flat = start === "plane" || end === "plane";
  return { shapes: flat ? [start!, end!] : [round(start!), round(end!)], normal: USUAL_LAW };
}

/** Turns of a frame that bring z upwards, by the place and the sign of the only component of gravity. */
const UPWARDS: Readonly<Record<string, readonly [string, string] | null>> = {
  "0-": ["y", "90 deg"], "0+": ["y", "-90 deg"], "1-": ["x", "-90 deg"], "1+": ["x", "90 deg"], "2-": null, "2+": ["x", "180 deg"],
};
const FLOOR = "floor";
const DROP = "1"; // from so high a free body falls [m]

/** Return which way is up, as a key of `UPWARDS`; "" where gravity is none, or oblique. */
function upOf(data: Model): string {
  const gravity = isArray(data["gravity"]) ? data["gravity"].map((each) => Number(textOf(each))) : [];
  const along = gravity.flatMap((each, index) => (each === 0 ? [] : [index]));
  return along.length === 1 && Number.isFinite(gravity[along[0]!]) ? `${along[0]!}${gravity[along[0]!]! < 0 ? "-" : "+"}` : "";
}

/** Return data whose ground has a level frame, and its name: that is where a body falls on, and no frame of its own is named. */
export function withFloor(data: Model): readonly [Model, string] {
  const turn = UPWARDS[upOf(data)];
  if (turn === undefined || turn === null) return [data, GROUND];
  const ground = isObject(data["ground"]) ? data["ground"] : {};
  const frames = isObject(ground["frames"]) ? ground["frames"] : {};
  const floor = frames[FLOOR] ?? { rotate: [turn] };
  return [{ ...data, ground: { ...ground, frames: { ...frames, [FLOOR]: floor } } }, `${GROUND}.${FLOOR}`];
}

/** Return data in which a body that nothing joins starts above the ground, where the user has not put it elsewhere. */
export function dropped(data: Model, body: string): Model {
  const up = upOf(data);
  const initial = isObject(data["initial"]) ? data["initial"] : {};
  const key = `${symbolOf(body)}_${"xyz".charAt(Number(up.charAt(0)))}`;
  if (up === "" || initial[key] !== undefined) return data;
  return { ...data, initial: { ...initial, [key]: up.endsWith("-") ? DROP : `-${DROP}` } };
}
