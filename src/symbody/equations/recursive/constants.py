"""Constants of the geometry as numbers: where they are known, axes can be chosen that save operations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from symbody.expr.expression import Expr, cos, number, sin
from symbody.expr.graph import Graph
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, build_sequence
from symbody.spatial.matrix import Matrix, Matrix3, Triple, matrix3
from symbody.spatial.transform import CoordinateRotation

# Sines and cosines of an angle typed as 1.570796 are not taken for 0 and 1; those of rounded products are.
_ROUNDING: Final = 1e-13

Floats = tuple[float, ...]


def numbers(values: Sequence[Expr]) -> Floats | None:
    """Return constants as floats, -1, 0, 1 exactly if so up to rounding; None if one has a symbol."""
    constants = [value.number for value in values]
    if any(value is None for value in constants):
        graph, nodes = values[0].graph, [value.index for value in values]
        if symbols_of(graph, nodes):
            return None
        sequence = build_sequence(graph, [Roots("", (), tuple(nodes))], {}, merge=False, contract=False)
        constants = evaluate_sequence(sequence, {})[0]
    return tuple(_round(float(value)) for value in constants if value is not None)


def matrix_numbers(m: Matrix) -> tuple[Floats, Floats, Floats] | None:
    """Return a constant matrix as floats."""
    entries = numbers([entry for row in m for entry in row])
    return None if entries is None else (entries[:3], entries[3:6], entries[6:])


def variable_rotation(axis: int, angle: float, variable: Expr) -> CoordinateRotation[Expr]:
    """Return the turn by a variable angle plus a constant one; quarter turns cost nothing."""
    quarters = angle / (math.pi / 2)
    whole = round(quarters)
    if abs(quarters - whole) > _ROUNDING:
        total = variable + angle
        return CoordinateRotation(axis, cos(total), sin(total))
    c, s = cos(variable), sin(variable)
    c, s = ((c, s), (-s, c), (-c, -s), (s, -c))[whole % 4]
    return CoordinateRotation(axis, c, s)


def constant_rotation(graph: Graph, axis: int, angle: float) -> CoordinateRotation[Expr]:
    """Return the turn by a constant angle."""
    return variable_rotation(axis, angle, number(graph, 0))


def twist_angles(c: Sequence[Floats]) -> tuple[float, float, float]:
    """Return (a, alpha, b) with ``C = Rz(a) Rx(alpha) Rz(b)``, a as near to 0 as it can be had."""
    across = math.hypot(c[0][2], c[1][2])
    if across == 0:
        flipped = c[2][2] < 0
        b = math.atan2(-c[0][1], c[0][0]) if flipped else math.atan2(c[1][0], c[0][0])
        return 0.0, math.pi if flipped else 0.0, b
    a, alpha = math.atan2(c[0][2], -c[1][2]), math.atan2(across, c[2][2])
    if abs(a) > math.pi / 2 + _ROUNDING:
        a, alpha = math.atan2(-c[0][2], c[1][2]), -alpha
    # What is left of C's first column when the first two turns are taken back.
    x = math.cos(a) * c[0][0] + math.sin(a) * c[1][0]
    y = math.cos(a) * c[1][0] - math.sin(a) * c[0][0]
    return a, alpha, math.atan2(math.cos(alpha) * y + math.sin(alpha) * c[2][0], x)


def axes_with_z(graph: Graph, axis: Triple) -> Matrix3[Expr] | None:
    """Return a rotation whose third column is a constant direction; None if it has symbols."""
    direction = numbers(axis)
    if direction is None:
        return None
    x, y, z = direction
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = _round(x / length), _round(y / length), _round(z / length)
    if abs(z) > 0.9:  # the first axis is the projection of x, else that of z
        first = (1 - x * x, -x * y, -x * z)
    elif abs(x) == 1:
        first = (0.0, x, 0.0)
    elif abs(y) == 1:
        first = (0.0, 0.0, y)
    else:
        first = (-z * x, -z * y, 1 - z * z)
    norm = math.hypot(*first)
    p, q, r = (_round(part / norm) for part in first)
    second = (y * r - z * q, z * p - x * r, x * q - y * p)
    columns = ((p, q, r), tuple(map(_round, second)), (x, y, z))
    a, b, c = (
        (exact_number(graph, row[0]), exact_number(graph, row[1]), exact_number(graph, row[2]))
        for row in zip(*columns, strict=True)
    )
    return matrix3(a, b, c)


def exact_number(graph: Graph, x: float) -> Expr:
    """Return a number as an expression, an exact one if it is whole."""
    return number(graph, int(x) if x in (-1.0, 0.0, 1.0) else x)


def _round(x: float) -> float:
    whole = round(x)
    return float(whole) if abs(whole) <= 1 and abs(x - whole) <= _ROUNDING else x
