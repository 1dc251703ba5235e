"""Draw constraints with bodies and multipliers: `python docs/draw_constraints.py` writes docs/pictures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from sketch import BLUE, DARK, END, GREY, OWN, START, UNITS, Array, Picture, turned

FRONT: Final = 0.07 * UNITS[0]  # the front of a wheel


def _ground(p: Picture, size: float = 0.9) -> None:
    p.box((0, 0, -0.04), (2 * size, 2 * size, 0.08), GREY)


def rolling(p: Picture) -> None:
    """Draw a disc that leans, its contact frame, and its axle."""
    _ground(p)
    radius, lean = 0.75, 62.0
    axle = turned("z", 12) @ turned("x", lean) @ UNITS[2]
    normal = UNITS[2]
    cosine = float(axle @ normal)
    sine = float(np.sqrt(1 - cosine**2))
    forward = np.cross(axle, normal) / sine
    contact = np.array([0.1, -0.1, 0.0])
    centre = contact - radius * (cosine * axle - normal) / sine
    up = (normal - cosine * axle) / sine
    turn = np.linspace(0, 2 * np.pi, 90)
    rim = centre + radius * (np.outer(np.cos(turn), up) + np.outer(np.sin(turn), forward))
    p.rod(centre - 0.04 * axle, centre + 0.04 * axle, radius, BLUE)
    p.rod(centre, centre + 0.3 * axle, 0.06, BLUE)
    p.curve(rim, END, 1.2)
    p.arrow(centre, centre + 0.7 * axle, END)
    p.text(centre + 0.84 * axle, "axis", END)
    p.text(centre - 0.12 * axle, "P", END)
    for direction, name in (
        (forward, "x forward"),
        (np.cross(normal, forward), "y left"),
        (normal, "z normal"),
    ):
        p.arrow(contact, contact + 0.6 * direction, OWN)
        p.text(contact + 0.76 * direction, name)
    p.text(contact + np.array([0.02, -0.12, -0.1]), "C")
    top = centre + radius * up
    p.arrow(top, top + 0.4 * forward, END)  # of a positive spin


def knife_edge(p: Picture) -> None:
    """Draw a blade, its normal, and the only velocity it leaves."""
    _ground(p)
    r = turned("z", -25)
    p.frame((-0.7, -0.5, 0), UNITS, START, "", 0.5)
    at = np.array([0.1, 0.1, 0.0])
    p.box(at + [0, 0, 0.19], (0.9, 0.04, 0.38), BLUE, r)
    p.arrow(at, at + 0.75 * r[:, 1], OWN)
    p.text(at + 0.95 * r[:, 1], "axis, lambda")
    p.arrow(at, at + 0.9 * r[:, 0], END)
    p.text(at + 1.04 * r[:, 0], "v", END)


def point_on_curve(p: Picture) -> None:
    """Draw a curve in start, its parameter, and the point of end."""
    p.frame((-0.5, -0.6, -0.3), UNITS, START, "", 0.7)
    origin = np.array([-0.5, -0.6, -0.3])
    s = np.linspace(0, 2.2, 80)
    curve = origin + np.column_stack([0.9 - 0.55 * s, 0.1 + 0.75 * s, 0.45 + 0.45 * np.sin(1.4 * s)])
    p.tube(curve[:66], np.tile(UNITS[0], (66, 1)), 0.045, GREY)
    point = curve[48]
    p.box(point, (0.22, 0.22, 0.22), BLUE, turned("z", 40) @ turned("x", 30))
    p.curve(curve[:49], OWN, 1.8)
    p.text(curve[24] + np.array([0, 0, 0.16]), "parameter")
    p.frame(point, turned("z", 40) @ turned("x", 30), END, "'", 0.4)
    p.arrow(origin, point, START)
    p.text((origin + point) / 2 + np.array([0, 0.0, -0.14]), "p", START)


def distance(p: Picture) -> None:
    """Draw a rod between two origins, and the force along it."""
    a, b = np.array([-0.2, -1.0, -0.35]), np.array([0.1, 0.75, 0.45])
    p.frame(a, UNITS, START, "", 0.8)
    p.frame(b, turned("z", -50) @ turned("y", 35), END, "'", 0.75)
    p.box(a - np.array([0, 0, 0.16]), (0.5, 0.5, 0.28), GREY)
    p.box(b, (0.34, 0.34, 0.34), BLUE, turned("z", -50) @ turned("y", 35))
    p.rod(a, b, 0.05, DARK)
    p.text((a + b) / 2 + np.array([0, -0.1, 0.16]), "value", START)
    along = (b - a) / np.linalg.norm(b - a)
    p.arrow(b, b + 0.6 * along, OWN)
    p.text(b + 0.7 * along + np.array([0, 0.1, 0.1]), "lambda")


def point_on_line(p: Picture) -> None:
    """Draw an axis of start, a point of end on it, and the two forces across."""
    a, at = np.array([0, -0.85, 0]), np.array([0, 0.35, 0])
    r = turned("z", 90)
    p.line(a - 0.15 * UNITS[1], a + 2.1 * UNITS[1])
    p.frame(a, r, START, "", 0.4, unnamed="x")
    p.text(a + np.array([0, 0.42, 0.14]), "x", START)
    p.box((0, 0.2, -0.14), (0.3, 2.4, 0.06), GREY)
    p.rod((0, -0.95, 0), (0, 1.3, 0), 0.05, GREY)
    p.sphere(at, 0.12, BLUE)
    p.frame(at, turned("x", 140) @ turned("z", 40), END, "'", 0.4)
    p.arrow(a, at, START)
    p.text((a + at) / 2 + np.array([0, 0.15, -0.16]), "p", START)
    for direction, name in ((r[:, 1], "lambda_1"), (r[:, 2], "lambda_2")):
        p.arrow(at, at + 0.75 * direction, OWN)
        p.text(at + 0.95 * direction, name)


def point_on_plane(p: Picture) -> None:
    """Draw a plane of start, a point of end in it, and the force along the normal."""
    _ground(p)
    a, at = np.array([0.2, -0.7, 0]), np.array([0.0, 0.45, 0])
    p.frame(a, UNITS, START, "", 0.5)
    p.rod(at, at + 0.3 * (turned("x", 25) @ UNITS[2]), 0.1, BLUE)
    p.sphere(at, 0.1, BLUE)
    p.frame(at, turned("x", 25) @ turned("z", 30), END, "'", 0.4, unnamed="z")
    p.arrow(a, at, START)
    p.text((a + at) / 2 + np.array([0, 0.1, 0.14]), "p", START)
    p.arrow(at, at + 0.85 * UNITS[2], OWN)
    p.text(at + 1.0 * UNITS[2], "lambda")


def point_on_surface(p: Picture) -> None:
    """Draw a surface f = 0 in start, a point of end on it, and the force along the gradient."""
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, 31), np.linspace(-0.9, 0.9, 31))
    p.surface(np.dstack([x, y, 0.35 - 0.35 * (x**2 + y**2)]), GREY)
    origin = np.array([-0.2, -0.3, -0.55])
    p.frame(origin, UNITS, START, "", 0.45)
    at = np.array([0.35, 0.4, 0.35 - 0.35 * (0.35**2 + 0.4**2)])
    gradient = np.array([0.7 * at[0], 0.7 * at[1], 1.0])
    gradient /= np.linalg.norm(gradient)
    p.sphere(at, 0.09, BLUE)
    p.frame(at, turned("z", 60), END, "'", 0.35, unnamed="z")
    p.arrow(at, at + 0.75 * gradient, OWN)
    p.text(at + 0.9 * gradient, "lambda grad f")


def _axes_of_two(p: Picture, degrees: float, first: str, second: str) -> tuple[Array, Array, Array]:
    """Draw an axis of start and one of end; return where the second stands, and both directions."""
    a, b = np.array([0, -0.85, -0.2]), np.array([0, -0.1, -0.2])
    one, two = UNITS[2], turned("x", -degrees) @ UNITS[2]
    p.box(a, (0.45, 0.35, 0.35), GREY)
    p.box(b, (0.45, 0.35, 0.35), BLUE, turned("x", -degrees))
    p.arrow(a, a + 1.1 * one, START)
    p.text(a + 1.24 * one, first, START)
    p.arrow(b, b + 1.0 * two, END)
    p.text(b + 1.14 * two, second, END)
    return b, one, two


def parallel(p: Picture) -> None:
    """Draw two axes of one direction, and the moments that keep them so."""
    b, one, _ = _axes_of_two(p, 0, "first", "second")
    for normal, name, k in ((UNITS[0], "n_1", 1), (UNITS[1], "n_2", 2)):
        p.arrow(b, b + 0.8 * normal, START, 1.3)
        p.text(b + 0.94 * normal, name, START)
        # about second x n, which is the other normal but for its sign
        about = np.cross(one, normal)
        p.angle(b + 0.3 * one, about, turned(about, -80) @ one, 70, f"lambda_{k}", 0.45, 0.3)


def perpendicular(p: Picture) -> None:
    """Draw two axes at a right angle, and the moment that keeps it."""
    b, one, two = _axes_of_two(p, 90, "first", "second")
    p.arrow(b, b + 0.6 * one, START, 1.3)
    square = np.array([b + 0.16 * one, b + 0.16 * (one + two), b + 0.16 * two])
    p.curve(square, START, 1.0)
    p.angle(b, UNITS[0], turned("x", -75) @ UNITS[2], 60, "lambda", 0.42, 0.3)


def angle(p: Picture) -> None:
    """Draw two axes, the angle between them, and the sense of the moment."""
    b, one, two = _axes_of_two(p, 55, "first", "second")
    p.arrow(b, b + 0.8 * one, START, 1.3)
    arc = np.array([b + 0.4 * (turned("x", -k) @ one) for k in np.linspace(0, 55, 30)])
    p.curve(arc, START, 1.2)
    p.text(b + 0.55 * (turned("x", -27) @ one), "value", START)
    p.angle(b, UNITS[0], turned("x", -75) @ UNITS[2], 40, "", 0.62)
    p.text(b + 0.8 * (turned("x", -84) @ one), "lambda")


def _wheel(p: Picture, centre: Array, radius: float, colour: str, teeth: int = 0) -> None:
    """Draw a wheel in the plane across the view's x, with teeth about its radius."""
    tall = 0.07 if teeth else 0.0
    front, back = centre + 0.06 * UNITS[0], centre - 0.06 * UNITS[0]
    p.rod(back, front, radius - tall, colour)
    p.rod(back - 0.1 * UNITS[0], front + 0.02 * UNITS[0], 0.07, DARK)
    for k in range(teeth):
        r = turned("x", 360.0 * (k + 0.5 * (centre[1] > 0)) / teeth)
        p.box(centre + (radius - 0.03) * r[:, 1], (0.12, 0.16, np.pi * radius / teeth * 0.8), colour, r)


def gear(p: Picture) -> None:
    """Draw two wheels, their angles, and the torque on the first."""
    a, b = np.array([0, -0.45, 0.2]), np.array([0, 0.6, 0.2])
    _wheel(p, a, 0.65, GREY, 26)
    _wheel(p, b, 0.4, BLUE, 16)
    p.angle(a + FRONT, UNITS[0], UNITS[1], 110, "first, lambda", 0.25, 0.28)
    p.angle(b + FRONT, UNITS[0], UNITS[1], 110, "second", 0.2, 0.26)


def rack_pinion(p: Picture) -> None:
    """Draw a pinion on a rack, the angle, the displacement, and the force on the rack."""
    centre = np.array([0, 0.0, 0.5])
    _wheel(p, centre, 0.5, GREY, 20)
    p.angle(centre + FRONT, UNITS[0], UNITS[1], 70, "angle", 0.25, 0.3)
    p.box((0, 0, -0.1), (0.2, 1.9, 0.1), BLUE)
    for k in range(-5, 6):
        p.box((0, np.pi / 20 * (k + 0.5), -0.02), (0.12, 0.07, 0.1), BLUE)
    p.slide((0, -0.9, -0.28), (0, -0.1, -0.28), "displacement", (0, 0.1, -0.2))
    p.slide((0, 0.35, 0.12), (0, 0.95, 0.12), "lambda", (0, 0.1, 0.17))


def belt(p: Picture) -> None:
    """Draw two pulleys, the belt, their angles, and the pull."""
    a, b, r, s = np.array([0, -0.55, 0.2]), np.array([0, 0.65, 0.2]), 0.5, 0.3
    _wheel(p, a, r, GREY)
    _wheel(p, b, s, BLUE)
    lean = np.arcsin((r - s) / np.linalg.norm(b - a))
    for side in (1, -1):
        normal = np.array([0, np.sin(lean), side * np.cos(lean)])
        corner = np.stack([a + r * normal, b + s * normal])
        p.surface(np.stack([corner - 0.05 * UNITS[0], corner + 0.05 * UNITS[0]]), DARK)
    p.angle(a + FRONT, UNITS[0], UNITS[1], 70, "first", 0.22, 0.26)
    p.angle(b + FRONT, UNITS[0], UNITS[1], 70, "second", 0.14, 0.26)
    top = a + r * np.array([0, np.sin(lean), np.cos(lean)])
    p.slide(top + np.array([0, 0.75, -0.06]), top + np.array([0, 0.2, 0.04]), "lambda", (0, 0.1, 0.16))


def differential(p: Picture) -> None:
    """Draw two half shafts and the carrier that turns about them."""
    p.line(-1.0 * UNITS[1], 1.0 * UNITS[1])
    p.rod((0, -1.0, 0), (0, -0.2, 0), 0.08, GREY)
    p.rod((0, 0.2, 0), (0, 1.0, 0), 0.08, GREY)
    p.rod((0, -0.28, 0), (0, -0.16, 0), 0.24, GREY)
    p.rod((0, 0.16, 0), (0, 0.28, 0), 0.24, GREY)
    p.ring((0, 0, 0), UNITS[1], 0.5, BLUE, 0.06)
    p.rod((0, 0, -0.5), (0, 0, 0.5), 0.04, BLUE)
    for side in (-1, 1):
        p.rod((0, 0, 0.2 * side), (0, 0, 0.32 * side), 0.16, DARK)
    for at, name, radius in ((-0.75, "left", 0.3), (0.75, "right", 0.3), (0.0, "carrier", 0.62)):
        p.angle((0, at, 0), UNITS[1], turned("y", 150) @ UNITS[0], 100, name, radius, 0.16)


def equation(p: Picture) -> None:
    """Draw what an equation between coordinates leaves, and the efforts of its multiplier across it."""
    p.arrow(-0.9 * UNITS[0], 1.0 * UNITS[0], START)
    p.arrow(-0.9 * UNITS[1], 1.0 * UNITS[1], START)
    p.text(1.15 * UNITS[0], "q1", START)
    p.text(1.15 * UNITS[1], "q2", START)
    s = np.linspace(-0.8, 0.8, 80)
    curve = np.column_stack([s, 0.35 - 0.7 * s**2, 0 * s])
    p.curve(curve, END, 1.6)
    p.text(curve[-1] + np.array([0.1, -0.25, 0]), "f(q1, q2) = 0", END)
    at, slope = curve[52], np.array([1.4 * s[52], 1.0, 0])
    p.slide(at, at + 0.6 * slope, "lambda grad f", (0.3, 0.35, -0.06))


def stop(p: Picture) -> None:
    """Draw a slide before the end of its rail, the gap between them, and the effort that opens it."""
    p.rod((0, -1.0, 0), (0, 1.0, 0), 0.05, GREY)
    p.box((0, 0.85, 0.1), (0.5, 0.12, 0.7), GREY)
    p.box((0, -0.35, 0.1), (0.4, 0.6, 0.4), BLUE)
    p.slide((0, -0.05, 0.55), (0, 0.79, 0.55), "gap", (0, -0.42, 0.14))
    p.slide((0, -0.65, 0.1), (0, -1.25, 0.1), "lambda", (0, -0.1, 0.18))


CONSTRAINTS: Final[dict[str, Callable[[Picture], None]]] = {
    "distance": distance,
    "point_on_line": point_on_line,
    "point_on_plane": point_on_plane,
    "point_on_curve": point_on_curve,
    "point_on_surface": point_on_surface,
    "parallel": parallel,
    "perpendicular": perpendicular,
    "angle": angle,
    "knife_edge": knife_edge,
    "rolling": rolling,
    "gear": gear,
    "rack_pinion": rack_pinion,
    "belt": belt,
    "differential": differential,
    "equation": equation,
    "stop": stop,
}


def main() -> None:
    """Write every picture."""
    for name, draw in CONSTRAINTS.items():
        picture = Picture(name.replace("_", " "))
        draw(picture)
        picture.save(f"constraint_{name}")


if __name__ == "__main__":
    main()
