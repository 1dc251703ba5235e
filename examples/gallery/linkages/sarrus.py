"""Sarrus linkage.

Two chains of three hinges, the hinges of one across those of the other, hold a plate parallel to the
ground: the first linkage for an exact straight line (1853), and a motion in space. By a count of
constraints it cannot move.

Check: each chain keeps the plate parallel to its own hinges, so the plate does not turn; each also keeps
its centre in the plane across them, and both planes meet above the centre of the base: the height is
`2 l sin(a)`. P. F. Sarrus presented it to the Academy in Paris in 1853 (Comptes rendus, volume 36).
"""

import numpy as np

import symbody as sb

LENGTH, EDGE = 0.4, 0.3  # m
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 0.5), "view": (1.0, -1.6, 0.6)}


def panel(name):
    """Return a panel from a to b along its x axis."""
    frames = {"a": sb.Frame((-LENGTH / 2, 0, 0)), "b": sb.Frame((LENGTH / 2, 0, 0))}
    shapes = [sb.Box((LENGTH, 0.25, 0.015))]
    return sb.Body(name, 1.0, (0.005, 0.014, 0.018), frames=frames, shapes=shapes)


def model():
    """Return the mechanism."""
    sides = {"east": sb.Frame((EDGE / 2, 0, 0)), "north": sb.Frame((0, EDGE / 2, 0), rotate=[("z", "pi/2")])}
    plate = sb.Body("Plate", 2.0, (0.02, 0.02, 0.04), frames=sides, shapes=[sb.Box((EDGE, EDGE, 0.02))])
    parts = [plate, *(panel(name) for name in ("East1", "East2", "North1", "North2"))]
    drive = {"east": {"motion": "-0.7 - 0.4*cos(2*pi*t)"}, "north": {}}
    for side, name in (("east", "East"), ("north", "North")):
        parts += [
            sb.Revolute(f"{side} foot", f"ground.{side}", f"{name}1.a", "y", f"{side}1", **drive[side]),
            sb.Revolute(f"{side} knee", f"{name}1.b", f"{name}2.a", "y", f"{side}2"),
            sb.Revolute(f"{side} top", f"Plate.{side}", f"{name}2.b", "y", f"{side}3"),
        ]
    first = {"east2": -0.94, "north1": -1.1, "north2": -0.94, "east3": -2.04, "north3": -2.04}
    return sb.Model("Sarrus linkage", parts, gravity=(0, 0, -9.81), ground=sides, initial=first)


def motion():
    """Return the plate going up and down."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 101))


def comparison(run):
    """Return place and turn of the plate, and the formula."""
    place = run["frame r Plate ground ground"]
    turn = run["frame R Plate ground"].reshape(9, -1)
    height = 2 * LENGTH * np.sin(np.abs(run["east1"]))
    zero = np.zeros_like(height)
    formula = np.vstack([zero, zero, height, np.repeat(np.eye(3).reshape(9, 1), len(height), axis=1)])
    return np.vstack([place, turn]), formula
