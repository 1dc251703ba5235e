"""Watt's linkage.

Two equal arms turn about posts on both sides; the middle of the short bar between their ends moves almost
straight up and down. It guided the piston rods of steam engines, and it guides rear axles of cars.

Check: the whole curve of that point, `r^2 = b^2 - (a sin(t) -+ sqrt(c^2 - a^2 cos(t)^2))^2` in polar
coordinates about the middle of the posts, which are `2 a` apart, with arms `b` and bar `2 c`; here times
`r^2`, squared, without the root. Watt's curve in E. H. Lockwood, A Book of Curves, Cambridge University
Press 1967.
"""

import numpy as np

import symbody as sb

ARM, HALF_BAR = 1.0, 0.3  # m
HALF_POSTS = float(np.hypot(ARM, HALF_BAR))  # the bar then stands across the arms when these are parallel
TOLERANCE = 1e-9
LOOK = {"times": (0.25, 0.5, 0.75), "traces": ["Bar"]}


def bar(name, length):
    """Return a bar from a to b along its x axis."""
    frames = {"a": sb.Frame((-length / 2, 0, 0)), "b": sb.Frame((length / 2, 0, 0))}
    return sb.Body(name, 1.0, (0, 0, length**2 / 12), frames=frames)


def model():
    """Return the mechanism."""
    lean = float(np.arctan2(HALF_BAR, ARM))
    parts = [
        *(bar("Left", ARM), bar("Right", ARM), bar("Bar", 2 * HALF_BAR)),
        sb.Revolute("A", "ground.A", "Left.a", coordinate="left", motion=f"{lean} + 0.45*sin(2*pi*t)"),
        sb.Revolute("B", "Left.b", "Bar.a", coordinate="turn"),
        sb.Revolute("C", "Bar.b", "Right.b"),
        sb.Revolute("D", "ground.D", "Right.a", coordinate="right"),
    ]
    posts = {"A": sb.Frame((-HALF_POSTS, 0, 0)), "D": sb.Frame((HALF_POSTS, 0, 0))}
    first = {"turn": -np.pi / 2, "right": np.pi + lean}
    return sb.Model("Watt's linkage", parts, ground=posts, initial=first)


def motion():
    """Return one swing of the left arm, to and fro."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return both sides of the equation of Watt's curve at the middle of the bar."""
    x, y = run["frame r Bar ground ground"][:2]
    r2, a2 = x**2 + y**2, HALF_POSTS**2
    left = r2 * (r2 - ARM**2 + HALF_BAR**2) + a2 * (y**2 - x**2)
    return left**2, 4 * a2 * y**2 * (HALF_BAR**2 * r2 - a2 * x**2)
