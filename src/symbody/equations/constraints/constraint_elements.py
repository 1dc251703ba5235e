"""The rows of every constraint beside the joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from symbody.equations.constraints.couplings import coupling_equations, stop_equations, written_equations
from symbody.equations.constraints.frame_constraints import pair_equation
from symbody.equations.constraints.points import (
    curve_equations,
    direction,
    distance_equations,
    line_equations,
    plane_equations,
    surface_equations,
)
from symbody.equations.constraints.rolling import blade_equations, rolling_equations
from symbody.equations.contacts.rigid_contacts import gap_rows
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr, cos
from symbody.model.constraint import ConstraintElement, FrameConstraint
from symbody.model.constraints import (
    Angle,
    Belt,
    Constraint,
    Differential,
    Distance,
    Gear,
    KnifeEdge,
    Parallel,
    Perpendicular,
    PointOnCurve,
    PointOnLine,
    PointOnPlane,
    PointOnSurface,
    RackPinion,
    Rolling,
    Stop,
)
from symbody.model.contacts.contact import Contact
from symbody.model.element import Element
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import cross, dot, vector


def _parallel_equations(
    names: Names, kinematics: Kinematics, parallel: Parallel
) -> Iterator[ConstraintEquation]:
    """Return two rows: the direction of end stands on two perpendiculars of that of start."""
    first, second = (direction(names, parallel, axis) for axis in parallel.axes)
    for across in perpendiculars(names.graph, first):
        yield _cosine_equation(kinematics, parallel, across, second)


def _perpendicular_equations(
    names: Names, kinematics: Kinematics, pair: Perpendicular
) -> Iterator[ConstraintEquation]:
    """Return the row of a cosine of 0."""
    first, second = (direction(names, pair, axis) for axis in pair.axes)
    yield _cosine_equation(kinematics, pair, first, second)


def _angle_equations(names: Names, kinematics: Kinematics, pair: Angle) -> Iterator[ConstraintEquation]:
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


# Each maker takes the class it stands beside.
_MAKERS: Final[Mapping[type[Element], Callable[[Names, Kinematics, Any], Iterator[ConstraintEquation]]]] = (
    MappingProxyType(
        {
            Distance: distance_equations,
            PointOnLine: line_equations,
            PointOnPlane: plane_equations,
            PointOnCurve: curve_equations,
            PointOnSurface: surface_equations,
            Parallel: _parallel_equations,
            Perpendicular: _perpendicular_equations,
            Angle: _angle_equations,
            KnifeEdge: blade_equations,
            Rolling: rolling_equations,
            Gear: coupling_equations,
            RackPinion: coupling_equations,
            Belt: coupling_equations,
            Differential: coupling_equations,
            Constraint: written_equations,
            Stop: stop_equations,
            Contact: gap_rows,
        }
    )
)


def constraint_equations(
    names: Names, kinematics: Kinematics, condition: ConstraintElement | Contact
) -> list[ConstraintEquation]:
    """Return the rows of a constraint, counted as they come.

    Raises
    ------
    FormulationError
        If an equation is not of first degree in the speeds.
    """
    rows = [*_MAKERS[type(condition)](names, kinematics, condition)]
    several = len(rows) > 1
    return [
        replace(
            row,
            name=f"lambda_{condition.name}_{k}",
            gap="" if not row.sense else f"{condition.name} {k}" if several else condition.name,
        )
        for k, row in enumerate(rows, start=1)
    ]
