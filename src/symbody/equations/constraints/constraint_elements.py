"""The rows of every constraint beside the joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from symbody.equations.constraints.couplings import coupling_equations, written_equations
from symbody.equations.constraints.directions import (
    angle_equations,
    parallel_equations,
    perpendicular_equations,
)
from symbody.equations.constraints.points import (
    curve_equations,
    distance_equations,
    line_equations,
    plane_equations,
    surface_equations,
)
from symbody.equations.constraints.rolling import blade_equations, rolling_equations
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.model.constraint import ConstraintElement
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
)

# Each maker takes the class it stands beside.
_MAKERS: Final[
    Mapping[type[ConstraintElement], Callable[[Names, Kinematics, Any], Iterator[ConstraintEquation]]]
] = MappingProxyType(
    {
        Distance: distance_equations,
        PointOnLine: line_equations,
        PointOnPlane: plane_equations,
        PointOnCurve: curve_equations,
        PointOnSurface: surface_equations,
        Parallel: parallel_equations,
        Perpendicular: perpendicular_equations,
        Angle: angle_equations,
        KnifeEdge: blade_equations,
        Rolling: rolling_equations,
        Gear: coupling_equations,
        RackPinion: coupling_equations,
        Belt: coupling_equations,
        Differential: coupling_equations,
        Constraint: written_equations,
    }
)


def constraint_equations(
    names: Names, kinematics: Kinematics, condition: ConstraintElement
) -> list[ConstraintEquation]:
    """Return the rows of a constraint, counted as they come.

    Raises
    ------
    FormulationError
        If an equation is not of first degree in the speeds.
    """
    rows = _MAKERS[type(condition)](names, kinematics, condition)
    return [replace(row, name=f"lambda_{condition.name}_{k}") for k, row in enumerate(rows, start=1)]
