"""Watt's governor.

Two balls on arms turn with a shaft, swing out as it turns faster, and lift a sleeve, which shuts the valve of
the engine: the first controller of industry.

Check: with four equal arms, balls m and a sleeve M, the joints on the axis, the balls swing steadily at a
height (m + M) g/(m w^2) below the upper joint, and no other: at that angle the moments of weight and
centrifugal force balance, m w^2 l^2 sin(a) cos(a) = (m + M) g l sin(a), derived here by virtual work, the
sleeve going down twice as far as the balls. Small swings about it have the frequency w sin(a) sqrt(m/(m + 2 M
sin(a)^2)), the arms without mass.
"""

import numpy as np

import symbody as sb

BALL, SLEEVE, ARM, SPEED = 1.0, 3.0, 0.3, 15.0  # kg, kg, m, rad/s
TOLERANCE = 2e-8  # rad
LOOK = {"times": (0.1,), "view": (0.35, -1.0, 0.25)}


def balance():
    """Return the angle of the arms from the axis, and the frequency of small swings about it [rad/s]."""
    angle = float(np.arccos((BALL + SLEEVE) * 9.81 / (BALL * SPEED**2 * ARM)))
    sine = np.sin(angle)
    return angle, SPEED * sine * np.sqrt(BALL / (BALL + 2 * SLEEVE * sine**2))


def model():
    """Return the mechanism: swings of a hundredth of a degree about the balance."""
    angle, _ = balance()
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
    first = {"left": angle + 2e-4, "right": angle + 2e-4, "h": -2 * ARM * np.cos(angle)}
    sizes = {"m": BALL, "M": SLEEVE, "l": ARM, "w": SPEED}
    return sb.Model("governor", parts, gravity=(0, 0, -9.81), parameters=sizes, initial=first)


def motion():
    """Return two seconds."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201), rtol=1e-10, atol=1e-13)


def comparison(run):
    """Return the swing of both arms about the balance over its first value, and that of the formula."""
    angle, frequency = balance()
    swing = run["left"][0] - angle
    return np.array([run["left"], run["right"]]) - angle, np.tile(swing * np.cos(frequency * run.t), (2, 1))
