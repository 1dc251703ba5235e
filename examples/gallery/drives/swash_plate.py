"""Swash plate with five pistons.

A plate on a shaft, tilted, pushes the pistons of pumps and air conditioners back and forth as it turns:
there is no crank, and the tilt sets the stroke.

Check: the shoe at `(R cos(p), R sin(p))` is in the plane across
`(sin(a) cos(phi), sin(a) sin(phi), cos(a))`, `a` the tilt, so that the piston is at
`-R tan(a) cos(phi - p)`, a pure sine; stroke `2 R tan(a)`. Derived here.
"""

import numpy as np

import symbody as sb

PISTONS, RADIUS, TILT = 5, 0.06, 0.3  # m, rad
TOLERANCE = 1e-9
LOOK = {"times": (0.13,), "view": (0.8, -1.2, 0.45)}


def model():
    """Return the mechanism."""
    plate = sb.Body(
        "Plate", 1.0, (0.001, 0.001, 0.002), frames={"face": sb.Frame(rotate=[("y", TILT)])},
        shapes=[sb.Cylinder(0.09, 0.01, rotate=[("y", TILT)], color="steelblue"),
                sb.Cylinder(0.012, 0.12, at=(0, 0, -0.06))],
    )  # fmt: skip
    parts = [plate, sb.Revolute("shaft", "ground", plate, coordinate="phi", motion="2*pi*t")]
    posts = {}
    for k in range(PISTONS):
        angle = 2 * np.pi * k / PISTONS
        place = (float(RADIUS * np.cos(angle)), float(RADIUS * np.sin(angle)), 0)
        posts[f"bore{k}"] = sb.Frame(place)
        shapes = [sb.Cylinder(0.014, 0.08, at=(0, 0, 0.045), color="orange"), sb.Sphere(0.012)]
        piston = sb.Body(f"Piston{k}", 0.1, (1e-4, 1e-4, 1e-5), shapes=shapes)
        parts += [
            sb.Prismatic(f"guide{k}", f"ground.bore{k}", piston, "z", f"s{k}"),
            sb.PointOnPlane(f"shoe{k}", "Plate.face", piston, axis="z"),
        ]
    return sb.Model("swash plate", parts, ground=posts)


def motion():
    """Return one turn of the shaft."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the places of the pistons, and the formula."""
    angles = 2 * np.pi * np.arange(PISTONS)[:, None] / PISTONS
    places = np.array([run[f"s{k}"] for k in range(PISTONS)])
    return places, -RADIUS * np.tan(TILT) * np.cos(run["phi"] - angles)
