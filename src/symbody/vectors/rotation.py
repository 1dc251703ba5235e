"""Rotations as successive simple turns, so that turns about one axis merge before any matrix is formed.

``R_AB`` takes components in B to components in A (docs/notation.md). A turn by `angle` about `axis`
leads from one frame to the next; the axis has the same components in both.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from symbody.expr.expression import Expr, cos, number, sin
from symbody.expr.graph import Graph

Triple = tuple[Expr, Expr, Expr]
Matrix = tuple[Triple, Triple, Triple]


@dataclass(frozen=True, slots=True)
class Turn:
    """One simple rotation.

    Attributes
    ----------
    axis : (3,) Expr
        Unit vector, the same components before and after the turn.
    angle : Expr
        Angle [rad], right-handed about `axis`.
    """

    axis: Triple
    angle: Expr


@dataclass(frozen=True, slots=True)
class Rotation:
    """Successive body-fixed turns leading from frame A to frame B; none is the identity."""

    turns: tuple[Turn, ...] = ()

    def then(self, other: Rotation) -> Rotation:
        """Return this rotation followed by `other`, neighbouring turns about parallel axes merged."""
        turns = list(self.turns)
        for turn in other.turns:
            merged = _merged(turns[-1], turn) if turns else None
            if merged is None:
                turns.append(turn)
            elif merged.angle.is_zero:
                turns.pop()
            else:
                turns[-1] = merged
        return Rotation(tuple(turns))

    @property
    def inverse(self) -> Rotation:
        """The rotation back."""
        return Rotation(tuple(Turn(turn.axis, -turn.angle) for turn in reversed(self.turns)))


def rotation_of(turns: Iterable[Turn]) -> Rotation:
    """Return the rotation made of `turns`, merged, turns by zero left out."""
    return Rotation().then(Rotation(tuple(turn for turn in turns if not turn.angle.is_zero)))


def rotation_matrix(graph: Graph, rotation: Rotation) -> Matrix:
    """Return ``R_AB``, whose columns are B's axes in A."""
    result = identity(graph)
    for turn in rotation.turns:
        result = product(result, turn_matrix(graph, turn))
    return result


def turn_matrix(graph: Graph, turn: Turn) -> Matrix:
    """Return ``1 cos + (1 - cos) a a^T + sin a~`` (Euler, Rodrigues)."""
    one = number(graph, 1)
    c, s = cos(turn.angle), sin(turn.angle)
    a = turn.axis
    skew = ((0, -1, 2), (1, 0, -3), (-2, 3, 0))  # +-(k + 1) with k the axis not involved
    place = {1: a[2], 2: a[1], 3: a[0]}
    rows = []
    for i in range(3):
        row = []
        for j in range(3):
            entry = c * (1 - a[i] * a[i]) + a[i] * a[i] if i == j else (one - c) * a[i] * a[j]
            code = skew[i][j]
            if code:
                entry = entry + place[abs(code)] * s if code > 0 else entry - place[abs(code)] * s
            row.append(entry)
        rows.append((row[0], row[1], row[2]))
    return (rows[0], rows[1], rows[2])


def identity(graph: Graph) -> Matrix:
    """Return the unit matrix."""
    zero, one = number(graph, 0), number(graph, 1)
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return ``a b``."""
    rows = [apply_matrix(transpose(b), row) for row in a]
    return (rows[0], rows[1], rows[2])


def transpose(a: Matrix) -> Matrix:
    """Return the transposed matrix."""
    return (
        (a[0][0], a[1][0], a[2][0]),
        (a[0][1], a[1][1], a[2][1]),
        (a[0][2], a[1][2], a[2][2]),
    )


def apply_matrix(a: Matrix, x: Triple) -> Triple:
    """Return ``a x``."""
    y = [row[0] * x[0] + row[1] * x[1] + row[2] * x[2] for row in a]
    return (y[0], y[1], y[2])


def _merged(first: Turn, second: Turn) -> Turn | None:
    if first.axis == second.axis:
        return Turn(first.axis, first.angle + second.angle)
    if first.axis == tuple(-component for component in second.axis):
        return Turn(first.axis, first.angle - second.angle)
    return None
