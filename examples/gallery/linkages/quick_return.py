"""Quick-return mechanism with a slotted arm.

The pin of a crank of radius `r` slides in the slot of an arm, pivoted a distance `d` below: the arm moves
forward slowly and back quickly. Shaping machines cut during the slow stroke.

Check: the pin is at `(r cos(t), d + r sin(t))` from the arm's pivot, so
`tan(arm) = (d + r sin(t))/(r cos(t))`. The arm turns back where it touches the circle of the pin, and the
times of the two strokes are as `180 + 2 asin(r/d)` to `180 - 2 asin(r/d)` degrees of the crank. Derived
here.
"""

import numpy as np

import symbody as sb

RADIUS, POSTS = 0.1, 0.25  # m
TOLERANCE = 1e-6
LOOK = {"times": (0.0, 0.2, 0.4), "traces": ["Arm.tip"]}


def model():
    """Return the mechanism."""
    parts = [
        sb.Body("Crank", 1.0, (0, 0, 0.01), frames={"pin": sb.Frame((RADIUS, 0, 0))}),
        sb.Body(
            "Arm", 2.0, (0, 0, 0.02), frames={"foot": sb.Frame((-0.25, 0, 0)), "tip": sb.Frame((0.25, 0, 0))}
        ),
        sb.Revolute("A", "ground", "Crank", coordinate="theta", motion="2*pi*t"),
        sb.Revolute("B", "ground.B", "Arm.foot", coordinate="phi"),
        sb.PinSlot("slot", "Arm.foot", "Crank.pin", axes=("z", "x"), coordinates=["turn", "along"]),
    ]
    return sb.Model(
        "quick return", parts, gravity=(0, -9.81, 0), ground={"B": sb.Frame((0, -POSTS, 0))},
        initial={"phi": "68 deg"},
    )  # fmt: skip


def motion():
    """Return two turns of the crank at one turn a second."""
    turning = sb.Event("phi_dot", name="turns back")
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 401), events=[turning])


def comparison(run):
    """Return the arm's angles and the ratio of the strokes' times, and their formulas."""
    theta = 2 * np.pi * run.t
    first, second, third = (event.t for event in run.events[:3])
    swing = np.arcsin(RADIUS / POSTS)
    angles = np.arctan2(POSTS + RADIUS * np.sin(theta), RADIUS * np.cos(theta))
    ratio = (np.pi + 2 * swing) / (np.pi - 2 * swing)
    return np.append(run["phi"], (third - second) / (second - first)), np.append(angles, ratio)
