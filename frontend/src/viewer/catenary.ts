/** The path of a rope: straight where it is taut, else the catenary of its length. */

type Triple = [number, number, number];

/**
 * Write points from `start` to `end` into `path`, evenly spaced along a rope of a length [m].
 *
 * `down` is the unit direction in which the rope hangs.
 */
export function writeRope(
  start: Readonly<Triple>,
  end: Readonly<Triple>,
  length: number,
  down: Readonly<Triple>,
  path: Float64Array,
): void {
  const x = end[0] - start[0];
  const y = end[1] - start[1];
  const z = end[2] - start[2];
  const drop = x * down[0] + y * down[1] + z * down[2];
  const side: Triple = [x - drop * down[0], y - drop * down[1], z - drop * down[2]];
  const width = Math.hypot(side[0], side[1], side[2]);
  const points = path.length / 3;
  const distance = Math.hypot(x, y, z);
  const hangs = length > distance * (1 + 1e-6);
  const curve = hangs ? catenary(width, drop, length) : null;
  for (let index = 0; index < points; index += 1) {
    const part = index / (points - 1);
    let across = part * width;
    let below = part * drop;
    if (curve !== null) {
      across = curve.across(part * length);
      below = curve.below(part * length);
    }
    const scale = width > 0 ? across / width : 0;
    for (let axis = 0; axis < 3; axis += 1) {
      path[3 * index + axis] = start[axis]! + scale * side[axis]! + below * down[axis]!;
    }
  }
}

interface Catenary {
  across(arc: number): number;
  below(arc: number): number;
}

/**
 * Return the catenary of a length between two points, `width` apart and the second lower by `drop`.
 *
 * With the height y = a cosh(x / a), arc length s = a sinh(x / a), and u = width / (2 a):
 * sqrt(length^2 - drop^2) = 2 a sinh u, hence sinh(u) / u = sqrt(length^2 - drop^2) / width.
 */
export function catenary(width: number, drop: number, length: number): Catenary {
  const ratio = Math.sqrt(length * length - drop * drop) / Math.max(width, 1e-9 * length);
  if (ratio > 1e4) return folded(drop, length); // the ends hang one over the other
  const a = width / (2 * spread(ratio));
  const middle = a * Math.atanh(-drop / length); // mean of the two abscissas
  const first = a * Math.sinh((middle - width / 2) / a);
  const height = Math.hypot(a, first);
  return {
    across: (arc) => a * (Math.asinh((first + arc) / a) - Math.asinh(first / a)),
    below: (arc) => height - Math.hypot(a, first + arc),
  };
}

function folded(drop: number, length: number): Catenary {
  const lowest = (length + drop) / 2;
  return { across: () => 0, below: (arc) => (arc < lowest ? arc : 2 * lowest - arc) };
}

/** Return u > 0 with sinh(u) / u = ratio > 1, by Newton's method on the logarithm. */
function spread(ratio: number): number {
  const target = Math.log(ratio);
  let u = ratio < 3 ? Math.sqrt(6 * (ratio - 1)) : Math.log(2 * ratio) + Math.log(Math.log(2 * ratio));
  for (let step = 0; step < 30; step += 1) {
    const gap = Math.log(Math.sinh(u) / u) - target;
    const next = u - gap / (1 / Math.tanh(u) - 1 / u);
    if (Math.abs(next - u) < 1e-12 * u) return next;
    u = Math.max(next, 1e-9);
  }
  return u;
}
