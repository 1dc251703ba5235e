"""A slider-crank placed by hand in three sets of coordinates, and drawn with joints."""

from __future__ import annotations

from collections.abc import Callable
from math import asin, cos, sin

import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb

DATA = {"L1": 0.3, "L2": 1.1, "m1": 0.7, "m2": 1.3, "m3": 0.9, "J1": 0.02, "J2": 0.17, "g": 9.81}
L1, L2, m1, m2, m3, J1, J2, g = sp.symbols(list(DATA))
# The crank's angle and rate of the comparisons, and what follows for the rod.
THETA, RATE = 0.7, 1.3
ROD = -asin(DATA["L1"] * sin(THETA) / DATA["L2"])

Mechanism = tuple[list[mb.BODY], list[sp.Expr], list[sp.Expr]]


def revolute(P: mb.POINT, Q: mb.POINT) -> list[sp.Expr]:
    v = mb.project(mb.join_points(P, Q), mb.ground)
    return [mb.comp_X(v), mb.comp_Y(v)]


def bodies(crank: mb.POINT, rod: mb.POINT, slider: mb.FRAME) -> list[mb.BODY]:
    return [
        mb.make_BODY(crank, m1, 0, 0, J1, name="crank"),
        mb.make_BODY(rod, m2, 0, 0, J2, name="rod"),
        mb.make_BODY(slider, m3, 0, 0, 1, name="slider"),
    ]


def recursive() -> Mechanism:
    q = theta, beta, s = dynamicsymbols("theta beta s")
    RF1 = mb.rotate("Z", theta)
    RF2 = RF1 * mb.translate(L1, 0, 0) * mb.rotate("Z", beta)
    RF3 = mb.translate(s, 0, 0)
    parts = bodies(mb.make_POINT(RF1, L1 / 2, 0, 0), mb.make_POINT(RF2, L2 / 2, 0, 0), RF3)
    return parts, revolute(mb.origin(RF3), mb.make_POINT(RF2, L2, 0, 0)), list(q)


def absolute() -> Mechanism:
    q = x1, y1, a1, x2, y2, a2, x3, y3, a3 = dynamicsymbols("x1 y1 theta x2 y2 a2 s y3 a3")
    places = ((x1, y1, a1), (x2, y2, a2), (x3, y3, a3))
    RF1, RF2, RF3 = (mb.translate(x, y, 0) * mb.rotate("Z", a) for x, y, a in places)
    Phi = [
        *revolute(mb.origin(RF3), mb.make_POINT(RF2, L2 / 2, 0, 0)),
        *revolute(mb.origin(mb.ground), mb.make_POINT(RF1, -L1 / 2, 0, 0)),
        *revolute(mb.make_POINT(RF1, L1 / 2, 0, 0), mb.make_POINT(RF2, -L2 / 2, 0, 0)),
        mb.dot_prod(mb.uvec_Y(mb.ground), mb.uvec_X(RF3)),
        mb.dot_prod(mb.uvec_Y(mb.ground), mb.join_points(mb.origin(mb.ground), mb.origin(RF3))),
    ]
    return bodies(mb.origin(RF1), mb.origin(RF2), RF3), Phi, list(q)


def natural() -> Mechanism:
    q = ax, ay, bx, by, x2, y2, s = dynamicsymbols("u1x u1y u2x u2y x2 y2 s")
    RF1, RF2 = (
        sp.Matrix([[u, -v, 0, x], [v, u, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])
        for u, v, x, y in ((ax, ay, 0, 0), (bx, by, x2, y2))
    )
    RF3 = mb.translate(s, 0, 0)
    Phi = [
        *revolute(mb.origin(RF3), mb.make_POINT(RF2, L2, 0, 0)),
        *revolute(mb.make_POINT(RF1, L1, 0, 0), mb.origin(RF2)),
        ax**2 + ay**2 - 1,
        bx**2 + by**2 - 1,
    ]
    return bodies(mb.make_POINT(RF1, L1 / 2, 0, 0), mb.make_POINT(RF2, L2 / 2, 0, 0), RF3), Phi, list(q)


def objects_of(mechanism: Mechanism) -> tuple[list[mb.BODY | mb.CONSTRAINT], list[sp.Expr]]:
    """Bodies with the constraint, and the coordinates."""
    parts, Phi, q = mechanism
    lambdas = dynamicsymbols(f"lambda1:{len(Phi) + 1}")
    return [*parts, mb.make_CONSTRAINT(Phi, lambdas)], q


MECHANISMS: dict[str, Callable[[], Mechanism]] = {
    "recursive": recursive, "absolute": absolute, "natural": natural,
}  # fmt: skip
_TIP = (0.3 * cos(THETA), 0.3 * sin(THETA))
INITIAL = {
    "recursive": {"theta": THETA, "theta_dot": RATE},
    "absolute": {"theta": THETA, "theta_dot": RATE},
    "natural": {"u1x": cos(THETA), "u1y_dot": RATE * cos(THETA)},
}
GUESS = {
    "recursive": {"beta": ROD - THETA, "s": 1.3},
    "absolute": {"a2": ROD, "s": 1.3, "x1": 0.1, "y1": 0.1, "x2": 0.7, "y2": 0.1},
    "natural": {"u1y": sin(THETA), "u2x": cos(ROD), "u2y": sin(ROD), "x2": _TIP[0], "y2": _TIP[1], "s": 1.3},
}


def drawn() -> sb.Model:
    crank = sb.Body(
        "crank",
        "m1",
        (0, 0, "J1"),
        frames={"base": sb.Frame(("-L1/2", 0, 0)), "tip": sb.Frame(("L1/2", 0, 0))},
    )
    rod = sb.Body(
        "rod", "m2", (0, 0, "J2"), frames={"base": sb.Frame(("-L2/2", 0, 0)), "tip": sb.Frame(("L2/2", 0, 0))}
    )
    slider = sb.Body("slider", "m3", (0, 0, 1))
    joints = [
        sb.Revolute("A", "ground", crank["base"], coordinate="theta"),
        sb.Revolute("B", crank["tip"], rod["base"], coordinate="beta"),
        sb.Prismatic("D", "ground", slider, axis="x", coordinate="s"),
        sb.Revolute("C", slider, rod["tip"], tree=False),
    ]
    return sb.Model("slider-crank", joints, gravity=(0, "-g", 0), parameters=DATA)
