/** Bodies with a size: what the palette offers besides the empty one. Their inertia follows from mass and length by formulas. */

import { symbolOf } from "./coordinates";
import { freeName, namesOf, textOf } from "./entries";
import { formulaNames } from "./names";
import type { Json, JsonObject, Model, PaletteElement } from "../types";

interface Template {
  readonly title: string;
  readonly summary: string;
  /** The letter of its length, a parameter of value 1 or of another one. */
  readonly length: string;
  readonly size: string;
  /** Axes of inertia, frames and shape by names of mass and length. */
  readonly inertia: (m: string, l: string) => readonly [string, string, string];
  readonly frames: (l: string) => Readonly<Record<string, readonly [string, string]>>;
  readonly shape?: (l: string) => JsonObject;
}

const BODY_TEMPLATES: Readonly<Record<string, Template>> = {
  link: {
    title: "Link", summary: "A bar with an end A and an end B.", length: "L", size: "1",
    inertia: (m, l) => [`${m}*${l}^2/600`, `${m}*${l}^2/12`, `${m}*${l}^2/12`],
    frames: (l) => ({ A: [`-${l}/2`, "0"], B: [`${l}/2`, "0"] }),
  },
  plate: {
    title: "Plate", summary: "An equilateral triangle with corners A, B and C.", length: "a", size: "1",
    inertia: (m, l) => [`${m}*${l}^2/24`, `${m}*${l}^2/24`, `${m}*${l}^2/12`],
    frames: (l) => ({ A: [`-${l}/2`, `-${l}*sqrt(3)/6`], B: [`${l}/2`, `-${l}*sqrt(3)/6`], C: ["0", `${l}*sqrt(3)/3`] }),
  },
  slider: {
    title: "Slider", summary: "A block, a piston or a cart: half as high as it is long, connected at its centre.", length: "a", size: "0.4",
    inertia: (m, l) => [`${m}*${l}^2/24`, `5*${m}*${l}^2/48`, `5*${m}*${l}^2/48`],
    frames: () => ({}),
    shape: (l) => ({ type: "box", size: [l, `${l}/2`, `${l}/2`] }),
  },
  wheel: {
    title: "Wheel", summary: "A disc about z, connected at its centre.", length: "R", size: "0.3",
    inertia: (m, l) => [`${m}*${l}^2/4`, `${m}*${l}^2/4`, `${m}*${l}^2/2`],
    frames: () => ({}),
    shape: (l) => ({ type: "cylinder", radius: l, length: `${l}/5` }),
  },
  ball: {
    title: "Ball", summary: "A solid ball, connected at its centre.", length: "R", size: "0.2",
    inertia: (m, l) => [`2*${m}*${l}^2/5`, `2*${m}*${l}^2/5`, `2*${m}*${l}^2/5`],
    frames: () => ({}),
    shape: (l) => ({ type: "sphere", radius: l }),
  },
};

/** Return what the palette offers: bodies with a size in front of the empty one. */
export function withTemplates(elements: readonly PaletteElement[]): PaletteElement[] {
  return elements.flatMap((element) => {
    if (element.section !== "body") return [element];
    const sized = Object.entries(BODY_TEMPLATES).map(([type, { title, summary }]) => ({ ...element, type, title, summary }));
    return [...sized, { ...element, title: "Empty body" }];
  });
}

/** Return data with a body of a template at their end, with its parameters; null where the type is none of them. */
export function withTemplate(data: Model, type: string): Model | null {
  const template = BODY_TEMPLATES[type];
  if (template === undefined) return null;
  const taken = formulaNames(data);
  const m = freeName("m1", taken);
  const l = freeName(`${template.length}1`, taken);
  const places = Object.entries(template.frames(l)).map(([frame, [x, y]]) => [frame, { at: [x, y, "0"] }] as const);
  const body: Record<string, Json> = {
    name: freeName(`${template.title}1`, namesOf(data)), mass: m, inertia: template.inertia(m, l),
    ...(places.length === 0 ? {} : { frames: Object.fromEntries(places) }),
    ...(template.shape === undefined ? {} : { shape: [template.shape(l)] }),
  };
  const parameters = { ...(data["parameters"] as JsonObject | undefined), [m]: "1", [l]: template.size };
  return { ...data, parameters, body: [...((data["body"] as readonly Json[] | undefined) ?? []), body] };
}

const GAP = 1.4; // between the middles of bodies that nothing joins yet [m]

/** Return data in which a new last body that nothing joins stands beside all others that are free, so that each is seen. */
export function besideOthers(data: Model, joined: ReadonlySet<string>): Model {
  const bodies = (data["body"] as readonly JsonObject[] | undefined) ?? [];
  const names = bodies.map((each) => textOf(each["name"]));
  const last = names.at(-1);
  const free = names.filter((each) => !joined.has(each)).length;
  if (last === undefined || free < 2) return data;
  const key = `${symbolOf(last)}_x`;
  return { ...data, initial: { ...(data["initial"] as JsonObject | undefined), [key]: String(Number((GAP * (free - 1)).toFixed(2))) } };
}
