"""Rows of directions held parallel, perpendicular, or at an angle."""

from __future__ import annotations

from collections.abc import Iterator

from symbody.equations.constraints.pairs import pair_row
from symbody.equations.constraints.points import direction
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.row import Row
from symbody.expr.expression import Expr, cos
from symbody.model.constraint import Contact
from symbody.model.constraints import Angle, Parallel, Perpendicular
from symbody.vectors.matrix import Triple
from symbody.vectors.vector import cross, dot, vector


def parallel_rows(names: Names, kinematics: Kinematics, parallel: Parallel) -> Iterator[Row]:
    """Return two rows: the direction of end stands on two perpendiculars of that of start."""
    first, second = (direction(names, parallel, axis) for axis in parallel.axes)
    for across in perpendiculars(names.graph, first):
        yield _cosine(kinematics, parallel, across, second)


def perpendicular_rows(names: Names, kinematics: Kinematics, pair: Perpendicular) -> Iterator[Row]:
    """Return the row of a cosine of 0."""
    first, second = (direction(names, pair, axis) for axis in pair.axes)
    yield _cosine(kinematics, pair, first, second)


def angle_rows(names: Names, kinematics: Kinematics, pair: Angle) -> Iterator[Row]:
    """Return the row of a cosine."""
    first, second = (direction(names, pair, axis) for axis in pair.axes)
    cosine = cos(names.expression(pair.value, f"constraint {pair.name}"))
    yield _cosine(kinematics, pair, first, second, cosine)


def _cosine(
    kinematics: Kinematics, pair: Contact, first: Triple, second: Triple, target: Expr | None = None
) -> Row:
    """Return ``a . b - target = 0`` for a fixed in start and b fixed in end."""
    tree = kinematics.tree
    a, b = vector(tree.home(pair.start.frame), first), vector(tree.home(pair.end.frame), second)
    return pair_row(kinematics, pair, value=dot(tree, a, b), moment=cross(tree, b, a), target=target)
