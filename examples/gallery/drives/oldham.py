"""Oldham's coupling.

Two parallel shafts that do not meet: a disc with a tongue on each face, one across the other, slides in
slots of both. Unlike Cardan's joint it transmits a constant speed; the disc whirls at twice the speed.

Check: tongue and tongue stay at right angles, so both shafts turn alike, and the middle of the disc sees
their axes, `d` apart, under a right angle: it goes round on the circle over `d` (Thales), with `phi` from
the line of the axes at `d cos(phi) exp(i phi)`, two rounds a turn.
"""

import numpy as np

import symbody as sb

OFFSET = 0.03  # m
TOLERANCE = 1e-9
LOOK = {"times": (0.14,), "view": (-0.55, -1.0, 0.55), "traces": ["Disc"]}


def hub(x, color):
    """Return the shapes of a shaft with its flange, towards +z for x = 1."""
    return [
        sb.Cylinder(0.06, 0.012, at=(0, 0, 0.03 * x), color=color),
        sb.Cylinder(0.014, 0.1, at=(0, 0, 0.08 * x), color=color),
    ]


def model():
    """Return the mechanism."""
    disc = [
        sb.Cylinder(0.06, 0.016, color="orange", opacity=0.9),
        sb.Box((0.115, 0.014, 0.016), at=(0, 0, -0.014), color="crimson"),
        sb.Box((0.014, 0.115, 0.016), at=(0, 0, 0.014), color="crimson"),
    ]
    parts = [
        sb.Body("Input", 1.0, (0, 0, 2e-3), shapes=hub(-1, "steelblue")),
        sb.Body("Disc", 0.4, (0, 0, 5e-4), shapes=disc),
        sb.Body("Output", 1.0, (0, 0, 2e-3), shapes=hub(1, "seagreen")),
        sb.Revolute("first", "ground", "Input", coordinate="phi", torque=sb.Drive(applied="T")),
        sb.Prismatic("first slot", "Input", "Disc", axis="x", coordinate="u"),
        sb.Prismatic("second slot", "Disc", "Output", axis="y", coordinate="v"),
        sb.Revolute("second", "ground.far", "Output"),
        sb.Torque("load", "Output", (0, 0, "-c*phi_dot")),
    ]
    return sb.Model(
        "Oldham coupling", parts, parameters={"T": 0.3, "c": 0.02}, ground={"far": sb.Frame((OFFSET, 0, 0))},
        initial={"u": OFFSET, "phi_dot": 6.0},
    )  # fmt: skip


def motion():
    """Return a second under a torque, against a brake."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the speed of the output and the place of the disc, and the formulas."""
    phi = run["phi"]
    centre = OFFSET * np.cos(phi) * np.exp(1j * phi)
    computed = [run["frame w Output ground ground z"], *run["frame r Disc ground ground"][:2]]
    return np.array(computed), np.array([run["phi_dot"], centre.real, centre.imag])
