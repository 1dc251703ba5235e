"""Rimless wheel.

A hub with eight spokes rolls down a slope, spoke after spoke, and reaches the same speed from any start:
the simplest of the passive walkers. A landing is an event, whose loss of speed is that of the angular
momentum about the new foot.

Check: at a landing the angular momentum about the new foot leaves `cos(2 a)` of the speed, `2 a` the
angle between spokes, all mass in the hub; over a step the weight adds `4 g/l sin(a) sin(slope)` to the
square of it. So each square follows from the one before, and the speed after landing tends to
`sqrt(4 g/l sin(a) sin(slope)) cot(2 a)`: T. McGeer, Passive dynamic walking, Int. J. Robotics Research
9(2) (1990), from page 62.
"""

import numpy as np

import symbody as sb

SPOKES, LENGTH, SLOPE = 8, 1.0, 0.12
ALPHA = np.pi / SPOKES
TOLERANCE = 1e-5  # rad/s
LOOK = {"times": (0.0, 1.5, 3.0, 4.5, 6.0, 7.5), "view": "front"}


def model():
    """Return the mechanism."""
    spokes = [
        sb.Capsule(0.025, LENGTH, at=(float(LENGTH / 2 * np.sin(a)), float(LENGTH / 2 * np.cos(a)), 0),
                   rotate=[("z", float(-a)), ("x", "pi/2")], color="steelblue")
        for a in 2 * ALPHA * np.arange(SPOKES)
    ]  # fmt: skip
    parts = [
        sb.Body("Foot"),
        sb.Body("Wheel", 5.0, frames={"foot": sb.Frame((0, -LENGTH, 0))}, shapes=[sb.Sphere(0.12), *spokes]),
        sb.Prismatic("slope", "ground", "Foot", axis="x", coordinate="x"),
        sb.Constraint("foot stands", "x_dot"),
        sb.Revolute("stance", "Foot", "Wheel.foot", axis=(0, 0, -1), coordinate="theta"),
    ]
    gravity = (9.81 * np.sin(SLOPE), -9.81 * np.cos(SLOPE), 0)
    floor = [sb.Box((13.5, 0.1, 1.0), at=(5.2, -0.05, 0), opacity=0.4)]
    first = {"theta": -ALPHA, "theta_dot": 2.5}
    return sb.Model("rimless wheel", parts, gravity=gravity, ground_shapes=floor, initial=first)


def motion():
    """Return eight seconds from a first speed; axes x down the slope, y away from it."""
    landing = sb.Event(
        f"theta - {ALPHA}", 1, name="lands",
        action={
            "theta": -ALPHA, "theta_dot": f"cos(2*{ALPHA})*theta_dot", "x": f"x + 2*{LENGTH}*sin({ALPHA})",
        },
    )  # fmt: skip
    return sb.simulate(sb.form_equations(model()), 8.0, events=[landing], rtol=1e-10)


def comparison(run):
    """Return the speeds after each landing, and McGeer's, which begin with 2.5 rad/s."""
    last = [np.searchsorted(run.t, event.t, side="right") - 1 for event in run.events]
    ratio = np.cos(2 * ALPHA) ** 2
    end = 4 * 9.81 / LENGTH * np.sin(ALPHA) * np.sin(SLOPE) / np.tan(2 * ALPHA) ** 2
    squares = end + ratio ** np.arange(1, len(last) + 1) * (2.5**2 - end)
    return run["theta_dot"][last], np.sqrt(squares)
