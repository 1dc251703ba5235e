"""Linkages that can be put together in several ways, or that are made of others whose motions agree.

K. Wohlhart, Merging two general Goldberg 5R linkages to obtain a new 6R space mechanism, Mech. Mach. Theory 26
(1991), 659-668; A. C. Dixon, On certain deformable frameworks, Messenger of Mathematics 29 (1899), 1-21.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np
from scipy.optimize import least_squares

import symbody as sb
from tests.problems.focal_linkages import meeting
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


def hart(reach: float, crossed: bool, guided: bool = False) -> sb.Model:
    """Hart's inversor: its point P moves on a circle through O about G; the four-bar A, D, B, C is crossed or not.

    Crossed, AB and CD are parallel and AB CD = AD^2 - AC^2, so that O, P and Q, which divide AD, AC and BD as
    s to 1 - s, lie on a line, and OP OQ = s (1 - s) (AD^2 - AC^2), P and Q on opposite sides of O: Q goes on a
    line across OG and may be guided in it. Uncrossed, Q goes on another curve, and a guide across OG locks it.

    Parameters
    ----------
    reach : float
        The length of CD.
    """
    long, short, share, crank = sqrt(3.94), sqrt(2.74), 0.6, 0.5
    C, D = 0j, complex(reach)
    A = meeting((C, short), (D, long), 1)
    B = meeting((C, long), (D, short), 1) if crossed else D - A
    O, P, Q = A + share * (D - A), A + share * (C - A), B + share * (D - B)
    G = meeting((O, crank), (P, crank), 1)
    points = dict(zip("ABCDOPGQ", (A, B, C, D, O, P, G, Q), strict=True))
    places = {name: (float(z.real), float(z.imag)) for name, z in points.items()}
    traced = places.pop("Q")
    model = plates(places, ["OG", "AOD", "APC", "BC", "BD", "GP"])
    return with_guide(model, "P4", traced, float(np.angle(1j * (G - O)))) if guided else model


def with_guide(model: sb.Model, bar: str, place: tuple[float, float], direction: float) -> sb.Model:
    """The linkage with a point of a bar guided in a line of ground, which has this direction [rad]."""
    frame = sb.Frame(at=(*place, 0.0), rotate=[("z", direction)])
    bodies = [
        sb.Body(body.name, body.mass, body.inertia, frames={**body.frames, "guided": frame})
        if body.name == bar else body
        for body in model.bodies
    ]  # fmt: skip
    slot = sb.PinSlot("guide", "ground.line", f"{bar}.guided", axes=["z", "x"], coordinates=["turn", "along"])
    others = [element for element in model.elements if not isinstance(element, sb.Body)]
    return sb.Model("guided", [*bodies, *others, slot], ground={**model.ground, "line": frame})
