/** Orientations as three turns, about x, then the new y, then the new z, as people set them. */

export type Quaternion = readonly [number, number, number, number];
export type Turns = readonly [number, number, number];

/** Return the quaternion (w, x, y, z) of successive turns [rad]. */
export function quaternionOf([a, b, c]: Turns): Quaternion {
  const [ca, sa, cb, sb, cc, sc] = [a, b, c].flatMap((each) => [Math.cos(each / 2), Math.sin(each / 2)]) as [number, number, number, number, number, number];
  return [
    ca * cb * cc - sa * sb * sc, sa * cb * cc + ca * sb * sc, ca * sb * cc - sa * cb * sc, ca * cb * sc + sa * sb * cc,
  ]; // prettier-ignore
}

/** Return successive turns of a quaternion of any length; where the middle one is a quarter the last is 0. */
export function turnsOf([w, x, y, z]: Quaternion): Turns {
  const size = w * w + x * x + y * y + z * z || 1;
  const sine = Math.max(-1, Math.min(1, (2 * (x * z + w * y)) / size));
  const middle = Math.asin(sine);
  if (Math.abs(sine) > 1 - 1e-12) return [Math.atan2(2 * (y * z + w * x), w * w - x * x + y * y - z * z), middle, 0];
  return [Math.atan2(2 * (w * x - y * z), w * w - x * x - y * y + z * z), middle, Math.atan2(2 * (w * z - x * y), w * w + x * x - y * y - z * z)];
}
