"""Linkages that can be put together in several ways, or that are made of others whose motions agree.

K. Wohlhart, Merging two general Goldberg 5R linkages to obtain a new 6R space mechanism, Mech. Mach. Theory 26
(1991), 659-668; A. C. Dixon, On certain deformable frameworks, Messenger of Mathematics 29 (1899), 1-21.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

import symbody as sb
from tests.problems.overconstrained import Array, Link, closed_angles, closing, plates, step

# Angles nearer than that are those of one assembly, and so are points.
SAME = 1e-6
TRIES = 60


def assemblies(links: Sequence[Link], first: float) -> list[list[float]]:
    """All sets of angles that close a loop of hinges with the first one held, as far as random starts find them."""
    random, found = np.random.default_rng(7), list[list[float]]()
    for _ in range(TRIES):
        start = random.uniform(-np.pi, np.pi, len(links) - 1)
        fit = least_squares(lambda x: closing(links, [first, *x]), start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        angles = [first, *np.arctan2(np.sin(fit.x), np.cos(fit.x)).tolist()]
        is_new = all(np.abs(np.exp(1j * np.subtract(angles, other)) - 1).max() > SAME for other in found)
        if np.abs(fit.fun).max() < 1e-12 and is_new:
            found.append(angles)
    return found


def axes(links: Sequence[Link], angles: Sequence[float]) -> tuple[Array, Array]:
    """Points on the axes of all hinges and their directions, as the first link sees them: two arrays (n, 3)."""
    frames = [np.eye(4)]
    for link, angle in zip(links[:-1], angles[:-1], strict=True):
        frames.append(frames[-1] @ step(link, angle))
    seen = np.linalg.inv(frames[1]) @ np.array(frames)
    return seen[:, :3, 3], seen[:, :3, 2]


def merged(
    links: Sequence[Link], others: Sequence[Link], angle: float, guesses: list[list[float]]
) -> tuple[Array, Array]:
    """The six axes that are left of two loops of five hinges without the two links that they begin with.

    Both loops share these and the angle between them, so each moves as the other one wants.
    """
    (p, d), (p_, d_) = (
        axes(loop, closed_angles(loop, guess, {1: angle}))
        for loop, guess in zip((links, others), guesses, strict=True)
    )
    return np.vstack([p[[0, 4, 3, 2]], p_[[3, 4]]]), np.vstack([d[[0, 4, 3, 2]], d_[[3, 4]]])


def link_shapes(points: Array, directions: Array) -> Array:
    """What does not change when rigid links move: of each pair of neighbouring axes (angle, distance, offsets)."""
    shapes = []
    for k in range(len(points)):
        u, v = directions[k], directions[(k + 1) % len(points)]
        w = points[(k + 1) % len(points)] - points[k]
        shapes.append([u @ v, np.cross(u, v) @ w])
    return np.array(shapes)


def four_bar(sides: tuple[float, float], crossed: bool, angle: float = 1.0) -> sb.Model:
    """A parallelogram with two sides on ground and opposite to it, or crossed."""
    a, b = sides
    A, B, D = np.array([0.0, 0.0]), np.array([a, 0.0]), b * np.array([np.cos(angle), np.sin(angle)])
    C = B + D
    if crossed:  # the mirror image across BD
        along = (D - B) / np.linalg.norm(D - B)
        C = B + 2 * along * (along @ (C - B)) - (C - B)
    places = {name: (float(x), float(y)) for name, (x, y) in zip("ABCD", (A, B, C, D), strict=True)}
    return plates(places, ["AB", "BC", "CD", "AD"])


def dixon() -> sb.Model:
    """Every of three points on one line is joined to each of three on a line across: both lines remain across."""
    points = {f"x{k}": (x, 0.0) for k, x in enumerate((1.0, -0.7, 1.9))}
    points |= {f"y{k}": (0.0, y) for k, y in enumerate((0.8, -1.3, 1.6))}
    return plates(points, [[a, b] for a in points if a[0] == "x" for b in points if b[0] == "y"])


def peaucellier(fold: str) -> sb.Model:
    """Peaucellier's inversor with its rhombus ABCD folded, so that A meets C or B meets D; B moves about Q."""
    turn, crank, arm, side = 0.5, 1.2, 2.2, 1.3
    O, Q = np.zeros(2), np.array([0.8, 0.0])
    B = Q + crank * np.array([np.cos(turn), np.sin(turn)])
    reach = float(np.linalg.norm(B))
    along = B / reach
    x = (arm**2 - side**2 + reach**2) / (2 * reach)
    y = np.sqrt(arm**2 - x**2) * np.array([-along[1], along[0]])
    A, C = x * along + y, x * along + (y if fold == "AC" else -y)
    D = A + side * np.array([np.cos(2.0), np.sin(2.0)]) if fold == "AC" else B
    places = dict(zip("OQABCD", (O, Q, A, B, C, D), strict=True))
    return plates(
        {name: (float(p[0]), float(p[1])) for name, p in places.items()},
        ["OQ", "OA", "OC", "AB", "BC", "CD", "DA", "QB"],
    )
