"""Lagrange's top.

A symmetric top on a fixed tip, released with nothing but its spin: its axis falls, turns aside, and rises
to a cusp again and again, as the top goes around.

Check: energy and the two conserved angular momenta leave `u'^2 = beta (1 - u^2)(e - u) - (b - a u)^2` for
the cosine `u` of the tilt, `a = C w/A`, `beta = 2 m g l/A`; between the roots `u1 < u2` of this cubic,
`u3` the third, `u = u1 + (u2 - u1) sn(K + t sqrt(beta (u3 - u1))/2)^2`, Jacobi's function with
`k^2 = (u2 - u1)/(u3 - u1)`, and the axis goes around at `(b - a u)/(1 - u^2)`. H. Goldstein, Classical
Mechanics, on the heavy symmetrical top.
"""

import numpy as np
from scipy.special import ellipj, ellipk

import symbody as sb

MASS, ARM, SPIN, TILT = 0.5, 0.06, 180.0, 0.6  # kg, m, rad/s, rad from the vertical at first
AXIAL, ACROSS = 4e-4, 2.1e-3  # kg m^2, about the tip
TOLERANCE = 1e-8
LOOK = {"times": (0.25,), "traces": ["Top.top"], "view": (1.0, -1.3, 0.3)}


def model():
    """Return the mechanism."""
    side = ACROSS - MASS * ARM**2
    ends = {"tip": sb.Frame((0, 0, -ARM)), "top": sb.Frame((0, 0, 0.06))}
    shapes = [
        sb.Cone(0.036, 0.06, at=(0, 0, -0.03), rotate=[("x", "pi")], color="steelblue"),
        sb.Cylinder(0.036, 0.015, at=(0, 0, 0.0075), color="goldenrod"),
        sb.Cylinder(0.005, 0.045, at=(0, 0, 0.037), color="dimgray"),
        sb.Sphere(0.004, at=(0.027, 0, 0.015), color="crimson"),
    ]
    parts = [
        sb.Body("Top", MASS, (side, side, AXIAL), frames=ends, shapes=shapes),
        sb.Spherical("tip", "ground", "Top.tip", angles="313", coordinates=["zeta", "eta", "xi"]),
    ]
    stand = [sb.Cylinder(0.02, 0.03, at=(0, 0, -0.015), color="lightgray")]
    first = {"eta": TILT, "xi_dot": SPIN}
    return sb.Model("heavy top", parts, gravity=(0, 0, -9.81), ground_shapes=stand, initial=first)


def motion():
    """Return two seconds from the release."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 401), rtol=1e-11, atol=1e-12)


def comparison(run):
    """Return the cosine of the tilt and the rate around, in turns a second, and the formulas."""
    a, beta, first = AXIAL * SPIN / ACROSS, 2 * MASS * 9.81 * ARM / ACROSS, np.cos(TILT)
    # With u2 = cos(TILT), where the top starts, b = a u2 and e = u2: (u2 - u)(beta (1 - u^2) - a^2 (u2 - u)).
    u1, u3 = np.sort(np.roots([-beta, a**2, beta - a**2 * first]))
    square = (first - u1) / (u3 - u1)
    sn = ellipj(run.t * np.sqrt(beta * (u3 - u1)) / 2 + ellipk(square), square)[0]
    u = u1 + (first - u1) * sn**2
    around = a * (first - u) / (1 - u**2)
    return np.array([np.cos(run["eta"]), run["zeta_dot"] / (2 * np.pi)]), np.array([u, around / (2 * np.pi)])
