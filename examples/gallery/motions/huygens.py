"""Huygens' cycloid.

Three beads slide from rest on a cycloid that hangs like a bowl: from high or low, all are at the bottom
at the same time. Huygens gave his clock cheeks that guide the pendulum on such a curve.

Check: the distance along the curve from the bottom is `s = 4 a sin(u/2)`, and `s'' = -g/(4 a) s` exactly,
so each bead is at `s = s_0 cos(t sqrt(g/(4 a)))`: C. Huygens, Horologium oscillatorium, Paris 1673,
second part.
"""

import numpy as np

import symbody as sb

RADIUS, STARTS = 0.5, (2.6, 1.6, 0.7)  # m of the rolling circle; its angles at first
TOLERANCE = 1e-7
LOOK = {"times": (0.0, 0.35, 0.62), "view": "front"}


def model():
    """Return the mechanism; in the cycloid the parameter is the angle of the rolling circle."""
    parts, first = [], {}
    for k, (start, color) in enumerate(zip(STARTS, ("crimson", "orange", "steelblue"), strict=True)):
        bead = sb.Body(f"Bead{k}", 0.1, shapes=[sb.Sphere(0.09, color=color)])
        parts += [
            sb.Cartesian(f"place{k}", "ground", bead, coordinates=[f"x{k}", f"y{k}", f"z{k}"]),
            sb.PointOnCurve(f"wire{k}", "ground", bead, parameter=f"u{k}",
                            curve=(f"a*(u{k} + sin(u{k}))", 0, f"a*(1 - cos(u{k}))")),
        ]  # fmt: skip
        first |= {
            f"u{k}": start,
            f"x{k}": RADIUS * (start + np.sin(start)),
            f"z{k}": RADIUS * (1 - np.cos(start)),
        }
    return sb.Model("Huygens' cycloid", parts, gravity=(0, 0, -9.81), parameters={"a": RADIUS}, initial=first)


def motion():
    """Return three seconds from rest."""
    return sb.simulate(sb.form_equations(model()), 3.0, times=np.linspace(0, 3, 201), rtol=1e-11, atol=1e-13)


def comparison(run):
    """Return the ways from the bottom, and the formula."""
    ways = np.array([4 * RADIUS * np.sin(run[f"u{k}"] / 2) for k in range(len(STARTS))])
    swing = np.cos(np.sqrt(9.81 / (4 * RADIUS)) * run.t)
    return ways, 4 * RADIUS * np.sin(np.array(STARTS) / 2)[:, None] * swing
