"""Watt's governor.

Two balls on arms turn with a shaft, swing out as it turns faster, and lift a sleeve, which shuts the valve of
the engine: the best known of the early controllers.

Check: with four equal arms `l` without mass, jointed on the axis, two balls `m` and a sleeve `M`, which
moves twice as far as the balls, Jacobi's integral gives the speed of the swing at any angle `a` of the
arms: `(m + 2 M sin(a)^2) a'^2 = m w^2 (sin(a)^2 - sin(a_0)^2) + 2 (m + M) g/l (cos(a) - cos(a_0))` from
rest at `a_0`. Where its right side has no slope the balls stay: `(m + M) g/(m w^2)` below the upper
joint. Derived here.
"""

import numpy as np

import symbody as sb

BALL, SLEEVE, ARM, SPEED = 1.0, 3.0, 0.3, 15.0  # kg, kg, m, rad/s
START = 0.2  # rad, beyond the balance
TOLERANCE = 1e-6
LOOK = {"times": (0.1,), "view": (0.35, -1.0, 0.25)}


def balance():
    """Return the angle of the arms from the axis at which the balls stay."""
    return float(np.arccos((BALL + SLEEVE) * 9.81 / (BALL * SPEED**2 * ARM)))


def model():
    """Return the mechanism, which starts farther out than where it would stay."""
    angle = balance() + START
    top = {"hinge": sb.Frame((0, 0, "l"))}
    ball = [sb.Sphere(0.055, color="goldenrod"), sb.Capsule(0.008, "l", at=(0, 0, "l/2"), color="gray")]
    shaft = [
        sb.Cylinder(0.012, 0.75, at=(0, 0, -0.3), color="dimgray"),
        sb.Cylinder(0.03, 0.04, color="dimgray"),
    ]
    sleeve = [sb.Cylinder(0.07, 0.08, at=(0, 0, -0.04), color="steelblue")]
    parts = [
        sb.Body("Shaft", 1.0, (0, 0, 1e-3), shapes=shaft),
        sb.Body("Sleeve", "M", (1e-3, 1e-3, 1e-3), shapes=sleeve),
        sb.Revolute("bearing", "ground", "Shaft", coordinate="phi", motion="w*t"),
        sb.Prismatic("guide", "Shaft", "Sleeve", axis="z", coordinate="h"),
    ]
    for name, axis in (("Left", "y"), ("Right", (0, -1, 0))):
        parts += [
            sb.Body(name, "m", frames=top, shapes=ball),
            sb.Revolute(f"{name} hinge", "Shaft", f"{name}.hinge", axis=axis, coordinate=name.lower()),
            sb.Distance(f"{name} link", "Sleeve", name, "l"),
        ]
    first = {"left": angle, "right": angle, "h": -2 * ARM * np.cos(angle)}
    sizes = {"m": BALL, "M": SLEEVE, "l": ARM, "w": SPEED}
    return sb.Model("governor", parts, gravity=(0, 0, -9.81), parameters=sizes, initial=first)


def motion():
    """Return two seconds."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201), rtol=1e-10, atol=1e-13)


def comparison(run):
    """Return what the swing has of its energy, and the formula, for both arms."""
    first = balance() + START
    angle, rate = (np.array([run[f"{side}{order}"] for side in ("left", "right")]) for order in ("", "_dot"))
    spin = BALL * SPEED**2 * (np.sin(angle) ** 2 - np.sin(first) ** 2)
    weight = 2 * (BALL + SLEEVE) * 9.81 / ARM * (np.cos(angle) - np.cos(first))
    return (BALL + 2 * SLEEVE * np.sin(angle) ** 2) * rate**2, spin + weight
