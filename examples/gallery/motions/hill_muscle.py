"""Arm with Hill's muscle.

A fully active biceps bends the forearm against a steady moment at the elbow. The faster a muscle
shortens, the less it pulls, by a hyperbola; it approaches the speed at which it just holds the load.

Check: `(F + a)(v + b) = (F0 + a) b`, A. V. Hill, The heat of shortening and the dynamic constants of
muscle, Proc. R. Soc. Lond. B 126 (1938). With the muscle at a steady arm `d` the speed `v = d w` obeys
`M v' = F(v) - W`, `M = I/d^2`, `W = moment/d`, which separates:
`t = M/(a + W) (-v - (b + u) ln(1 - v/u))` with the final speed `u = b (F0 - W)/(a + W)`, Hill's equation
again.
"""

import numpy as np

import symbody as sb

FORCE, A, B = 1000.0, 250.0, 0.1  # N, N, m/s
ARM, INERTIA, MOMENT = 0.04, 0.08, 16.0  # m, kg m^2, N m
TOLERANCE = 1e-7  # s
LOOK = {"times": (0.0, 0.15, 0.3), "view": "front"}


def model():
    """Return the mechanism."""
    forearm = [
        sb.Capsule(0.03, 0.24, at=(0.13, 0, 0), rotate=[("y", "pi/2")], color="peachpuff"),
        sb.Sphere(0.045, at=(0.29, 0, 0), color="peachpuff"),
        sb.Cylinder(0.02, 0.2, at=(0.29, 0.0, 0), color="gray"),
        sb.Cylinder("d", 0.05, color="tan"),
    ]
    ground = [
        sb.Capsule(0.04, 0.26, at=(0, 0.15, 0), rotate=[("x", "pi/2")], color="peachpuff", opacity=0.6),
        sb.Capsule(0.022, 0.16, at=(0.055, 0.16, 0), rotate=[("x", "pi/2")], color="crimson"),
    ]
    pull = "(F0*b - a*d*phi_dot)/(b + d*phi_dot)"
    parts = [
        sb.Body("Forearm", 1.5, (0, 0, "I"), shapes=forearm),
        sb.Revolute("elbow", "ground", "Forearm", coordinate="phi", torque=sb.Drive(applied=f"d*{pull} - T")),
    ]
    sizes = {"F0": FORCE, "a": A, "b": B, "d": ARM, "I": INERTIA, "T": MOMENT}
    return sb.Model(
        "arm with Hill's muscle", parts, parameters=sizes, ground_shapes=ground, initial={"phi": -1.3}
    )


def motion():
    """Return the bending from rest."""
    return sb.simulate(
        sb.form_equations(model()), 0.4, times=np.linspace(0, 0.4, 801), rtol=1e-11, atol=1e-13
    )


def comparison(run):
    """Return the times, and those at which the formula has the muscle as fast."""
    load, mass = MOMENT / ARM, INERTIA / ARM**2
    final = B * (FORCE - load) / (A + load)
    v = ARM * run["phi_dot"]
    early = v < 0.99 * final  # later a small error of the speed is a large one of the time
    v = v[early]
    formula = mass / (A + load) * (-v - (B + final) * np.log1p(-v / final))
    return run.t[early], formula
