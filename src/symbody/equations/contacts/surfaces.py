"""Contacts with curves and surfaces given by formulas: the foot point by steps of Newton, on the graph.

The foot is the point of the surface whose normal goes through the centre. A fixed number of steps, each
kept from turning back by a bound on the curvature, reaches it to rounding where the radius is less than that
of the surface's curvature: then it is the only one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from symbody.equations.contacts.contact_geometry import ContactGeometry, ShapePair, perpendicular
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr, atan2, cos, maximum, minimum, number, sin, sqrt, symbol
from symbody.expr.graph import Symbol
from symbody.expr.rewrite import substitute
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import vector

# Steps of Newton, and the share of the whole curvature that a step may take off the slope of its equation.
_STEPS: Final = 6
_SHARE: Final = 0.9
# In the place of a square of 0 under a root or a line.
_TINY: Final = 1e-24


def height_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of ground under z = f(x, y) and a sphere or point."""
    x, y = (symbol(pair.kinematics.graph, Symbol(f"{pair.where} {letter}")) for letter in "xy")
    f = _formula(pair, {"x": x, "y": y})
    fx, fy = _slopes(f, (x, y))
    fxx, fxy = _slopes(fx, (x, y))
    fyy = _slopes(fy, (x, y))[1]
    cx, cy, cz = pair.components(pair.arm, pair.first)
    at_x, at_y = cx, cy
    for _ in range(_STEPS):
        height, a, b, p, q, r = _put_in((f, fx, fy, fxx, fxy, fyy), (x, y), (at_x, at_y))
        above = cz - height
        gx, gy = at_x - cx - above * a, at_y - cy - above * b
        bent = sqrt(p * p + 2 * q * q + r * r + _TINY) * sqrt(above * above + _TINY)
        share = above * minimum(_SHARE / bent, number(bent.graph, 1))
        hxx, hxy, hyy = 1 + a * a - share * p, a * b - share * q, 1 + b * b - share * r
        scale = hxx * hyy - hxy * hxy
        at_x = at_x - (hyy * gx - hxy * gy) / scale
        at_y = at_y - (hxx * gy - hxy * gx) / scale
    height, a, b = _put_in((f, fx, fy), (x, y), (at_x, at_y))
    length = sqrt(1 + a * a + b * b)
    n = (-a / length, -b / length, 1 / length)
    distance = n[0] * (cx - at_x) + n[1] * (cy - at_y) + n[2] * (cz - height)
    return _on_surface(pair, n, distance, "xy")


def cam_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a cam of radius r(angle) about z and a roller, sphere or point."""
    graph = pair.kinematics.graph
    angle = symbol(graph, Symbol(f"{pair.where} angle"))
    radius = _formula(pair, {"angle": angle})
    along = (radius * cos(angle), radius * sin(angle))
    first = [_slopes(value, (angle,))[0] for value in along]
    second = [_slopes(value, (angle,))[0] for value in first]
    cx, cy, _ = pair.components(pair.arm, pair.first)
    is_centre = cx * cx + cy * cy
    turn = atan2(cy, cx + (_TINY if is_centre.is_zero else 0))
    for _ in range(_STEPS):
        px, py, ax, ay, bx, by = _put_in((*along, *first, *second), (angle,), (turn,))
        square = ax * ax + ay * ay + _TINY
        slope = (px - cx) * ax + (py - cy) * ay
        bent = square + (px - cx) * bx + (py - cy) * by
        turn = turn - slope / maximum(bent, square * (1 - _SHARE))
    px, py, ax, ay = _put_in((*along, *first), (angle,), (turn,))
    length = sqrt(ax * ax + ay * ay + _TINY)
    n = (ay / length, -ax / length, number(graph, 0))
    return _on_surface(pair, n, n[0] * (cx - px) + n[1] * (cy - py), "zx")


def _on_surface(pair: ShapePair, n: Triple, distance: Expr, along: str) -> ContactGeometry:
    normal = vector(pair.home(pair.first), n)
    touch = pair.ball(normal, pair.arm, pair.second.radius, distance)
    forward = perpendicular(pair, normal, *along)
    return ContactGeometry(normal, forward, (touch,), pair.home(pair.first))


def _formula(pair: ShapePair, own: dict[str, Expr]) -> Expr:
    """Return the formula of the surface in symbols of its own."""
    assert pair.first.formula is not None
    return pair.names.with_values(own).expression(pair.first.formula, pair.where)


def _slopes(value: Expr, by: Sequence[Expr]) -> list[Expr]:
    found = gradient(value.graph, value.index, [each.index for each in by])
    return [Expr(value.graph, node) for node in found]


def _put_in(values: Sequence[Expr], by: Sequence[Expr], places: Sequence[Expr]) -> list[Expr]:
    """Return expressions with others in the place of their symbols."""
    graph = by[0].graph
    pairs = {old.index: new.index for old, new in zip(by, places, strict=True)}
    return [Expr(graph, node) for node in substitute(graph, [value.index for value in values], pairs)]
