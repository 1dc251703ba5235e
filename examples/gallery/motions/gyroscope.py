"""Gyroscope on one end of its axle.

A wheel that spins fast does not fall when one end of its axle is held: it goes around the post. With the
right initial speed it does so at a constant rate.

Check: the weight's moment `m g l` about the post turns the angular momentum `C w` of the spin, which is
level, at the rate `m g l/(C w)`; exactly, since with a level axle the angular momentum of the precession
is upright and does not turn. Derived here.
"""

import numpy as np

import symbody as sb

MASS, ARM, SPIN = 0.8, 0.15, 120.0  # kg, m, rad/s
AXIAL, ACROSS = 0.002, 0.0012  # kg m^2
TOLERANCE = 1e-6  # rad
LOOK = {"times": (0.0, 0.6), "traces": ["Wheel"], "view": (1.0, -1.2, 0.6)}


def model():
    """Return the mechanism."""
    rate = MASS * 9.81 * ARM / (AXIAL * SPIN)
    wheel = sb.Body(
        "Wheel", MASS, (AXIAL, ACROSS, ACROSS), frames={"tip": sb.Frame((-ARM, 0, 0))},
        shapes=[
            sb.Cylinder(0.07, 0.015, rotate=[("y", "pi/2")], color="steelblue"),
            sb.Cylinder(0.006, 2 * ARM, rotate=[("y", "pi/2")]),
            sb.Sphere(0.008, at=(0.01, 0.055, 0), color="crimson"),
        ],
    )  # fmt: skip
    post = sb.Cylinder(0.008, 0.2, at=(0, 0, -0.1), color="gray")
    angles = ["precession", "nutation", "spin"]
    parts = [wheel, sb.Spherical("post", "ground", "Wheel.tip", angles="321", coordinates=angles)]
    first = {"spin_dot": SPIN, "precession_dot": rate}
    return sb.Model("gyroscope", parts, gravity=(0, 0, -9.81), ground_shapes=[post], initial=first)


def motion():
    """Return two seconds of even precession."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201))


def comparison(run):
    """Return precession and nutation, and their formulas."""
    rate = MASS * 9.81 * ARM / (AXIAL * SPIN)
    return np.array([run["precession"], run["nutation"]]), np.array([rate * run.t, 0 * run.t])
