"""Cardan's gears.

A gear rolls inside a ring twice its size: each point of its rim moves back and forth on a straight line
through the middle, each point within on an ellipse. Presses and engines have used it instead of crank and
rod; before Cardano, Nasir al-Din al-Tusi used it in a model of the planets.

Check: with the arm at `phi` the gear has turned by `-phi`, so a point a distance `c` from its centre is
at `r exp(i phi) + c exp(-i phi)`: `x = (r + c) cos(phi)`, `y = (r - c) sin(phi)`, a line for `c = r`.
"""

import numpy as np

import symbody as sb

RADIUS, INNER = 0.1, 0.05  # m: the gear, and a point within
TOLERANCE = 1e-9
LOOK = {"times": (0.0, 0.12, 0.3), "traces": ["Gear.rim", "Gear.inside"]}


def model():
    """Return the mechanism."""
    ends = {"hub": sb.Frame((-RADIUS / 2, 0, 0)), "pin": sb.Frame((RADIUS / 2, 0, 0))}
    points = {"rim": sb.Frame((RADIUS, 0, 0)), "inside": sb.Frame((INNER, 0, 0))}
    parts = [
        sb.Body("Arm", 0.2, (0, 0, 0.001), frames=ends),
        sb.Body("Gear", "m", (0, 0, "m*r^2/2"), frames=points),
        sb.Revolute("hub", "ground", "Arm.hub", coordinate="phi", torque=sb.Drive(applied="T")),
        sb.Revolute("pin", "Arm.pin", "Gear", coordinate="psi"),
        sb.Gear("ring", ["psi", "phi"], -2),
    ]  # fmt: skip
    return sb.Model(
        "Cardan's gears", parts, parameters={"r": RADIUS, "m": 0.5, "T": 0.02}, initial={"phi_dot": 4.0},
    )  # fmt: skip


def motion():
    """Return two seconds under a steady torque."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201))


def comparison(run):
    """Return the places of the two points, and the formulas."""
    phi = run["phi"]
    rim, inside = (run[f"frame r Gear.{name} ground ground"][:2] for name in ("rim", "inside"))
    line = np.array([2 * RADIUS * np.cos(phi), 0 * phi])
    ellipse = np.array([(RADIUS + INNER) * np.cos(phi), (RADIUS - INNER) * np.sin(phi)])
    return np.vstack([rim, inside]), np.vstack([line, ellipse])
