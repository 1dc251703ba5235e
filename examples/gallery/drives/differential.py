"""Bevel gear differential.

A bevel gear on the carrier meshes with one on each half shaft: the wheels of a car may turn at different
speeds, and get the same torque.

Check: the carrier turns at the mean of the half shafts and, as power in is power out at any speeds, its
torque goes to both in equal parts, so the motion against two unequal brakes is that of two linear equations,
solved by the matrix exponential; at its end each wheel turns at half of the torque over its brake. Derived
here.
"""

import numpy as np
from scipy.linalg import expm

import symbody as sb

DRIVE, BRAKES = 2.0, (0.05, 0.4)  # N m, N m s
CARRIER, SHAFT = 0.08, 0.03  # kg m^2
TOLERANCE = 1e-6
LOOK = {"times": (0.0,), "view": (1.0, -1.3, 0.6)}


def model():
    """Return the mechanism."""
    carrier = sb.Body(
        "Carrier", 4.0, (CARRIER, CARRIER, CARRIER), frames={"pin": sb.Frame((0, 0, 0.06)),
        "left": sb.Frame((-0.05, 0, 0)), "right": sb.Frame((0.05, 0, 0))},
    )  # fmt: skip
    spider = sb.Body("Spider")
    parts = [
        carrier,
        *(sb.Body("Left", 1.0, (SHAFT,) * 3), sb.Body("Right", 1.0, (SHAFT,) * 3), spider),
        sb.Revolute("case", "ground", carrier, "x", "phi", torque=sb.Drive(applied=DRIVE)),
        sb.Revolute("left axle", "Carrier.left", "Left", "x", "left"),
        sb.Revolute("right axle", "Carrier.right", "Right", "x", "right"),
        sb.Revolute("pin", "Carrier.pin", spider, "z", "spin"),
        sb.Gear("left mesh", ["spin", "left"], 1),
        sb.Gear("right mesh", ["spin", "right"], -1),
        sb.Torque("left brake", "Left", (f"-{BRAKES[0]}*(phi_dot + left_dot)", 0, 0)),
        sb.Torque("right brake", "Right", (f"-{BRAKES[1]}*(phi_dot + right_dot)", 0, 0)),
    ]
    return sb.Model("differential", parts)


def motion():
    """Return three seconds from rest."""
    eqs = sb.form_equations(model())
    return sb.simulate(eqs, 3.0, times=np.linspace(0, 3, 151), rtol=1e-10, atol=1e-12)


def comparison(run):
    """Return the speeds of both wheels, and the solution of the two linear equations."""
    inertia = np.full((2, 2), CARRIER / 4) + SHAFT * np.eye(2)
    A = -np.linalg.solve(inertia, np.diag(BRAKES))
    final = DRIVE / 2 / np.array(BRAKES)
    formula = np.array([final - expm(A * t) @ final for t in run.t]).T
    wheels = [run[f"frame w {side} ground ground x"] for side in ("Left", "Right")]
    return np.array(wheels), formula
