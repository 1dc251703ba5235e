"""Rows of directions held parallel, perpendicular, or at an angle."""

from __future__ import annotations

from collections.abc import Iterator

from symbody.equations.constraints.frame_constraints import pair_equation
from symbody.equations.constraints.points import direction
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr, cos
from symbody.model.constraint import FrameConstraint
from symbody.model.constraints import Angle, Parallel, Perpendicular
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import cross, dot, vector


def parallel_equations(
    names: Names, kinematics: Kinematics, parallel: Parallel
) -> Iterator[ConstraintEquation]:
    """Return two rows: the direction of end stands on two perpendiculars of that of start."""
    first, second = (direction(names, parallel, axis) for axis in parallel.axes)
    for across in perpendiculars(names.graph, first):
        yield _cosine_equation(kinematics, parallel, across, second)


def perpendicular_equations(
    names: Names, kinematics: Kinematics, pair: Perpendicular
) -> Iterator[ConstraintEquation]:
    """Return the row of a cosine of 0."""
    first, second = (direction(names, pair, axis) for axis in pair.axes)
    yield _cosine_equation(kinematics, pair, first, second)


def angle_equations(names: Names, kinematics: Kinematics, pair: Angle) -> Iterator[ConstraintEquation]:
    """Return the row of a cosine."""
    first, second = (direction(names, pair, axis) for axis in pair.axes)
    cosine = cos(names.expression(pair.value, f"constraint {pair.name}"))
    yield _cosine_equation(kinematics, pair, first, second, cosine)


def _cosine_equation(
    kinematics: Kinematics, pair: FrameConstraint, first: Triple, second: Triple, target: Expr | None = None
) -> ConstraintEquation:
    """Return ``a . b - target = 0`` for a fixed in start and b fixed in end."""
    tree = kinematics.tree
    a, b = (
        vector(tree.orientation_frame(pair.start.full_name), first),
        vector(tree.orientation_frame(pair.end.full_name), second),
    )
    return pair_equation(kinematics, pair, value=dot(tree, a, b), moment=cross(tree, b, a), target=target)
