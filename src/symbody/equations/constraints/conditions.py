"""The rows of every constraint beside the joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from symbody.equations.constraints.couplings import coupling_rows, equation_rows
from symbody.equations.constraints.directions import angle_rows, parallel_rows, perpendicular_rows
from symbody.equations.constraints.points import (
    curve_rows,
    distance_rows,
    line_rows,
    plane_rows,
    surface_rows,
)
from symbody.equations.constraints.rolling import blade_rows, rolling_rows
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.row import Row
from symbody.model.constraint import Condition
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
_MAKERS: Final[Mapping[type[Condition], Callable[[Names, Kinematics, Any], Iterator[Row]]]] = (
    MappingProxyType(
        {
            Distance: distance_rows,
            PointOnLine: line_rows,
            PointOnPlane: plane_rows,
            PointOnCurve: curve_rows,
            PointOnSurface: surface_rows,
            Parallel: parallel_rows,
            Perpendicular: perpendicular_rows,
            Angle: angle_rows,
            KnifeEdge: blade_rows,
            Rolling: rolling_rows,
            Gear: coupling_rows,
            RackPinion: coupling_rows,
            Belt: coupling_rows,
            Differential: coupling_rows,
            Constraint: equation_rows,
        }
    )
)


def condition_rows(names: Names, kinematics: Kinematics, condition: Condition) -> list[Row]:
    """Return the rows of a constraint, counted as they come.

    Raises
    ------
    FormulationError
        If an equation is not of first degree in the speeds.
    """
    rows = _MAKERS[type(condition)](names, kinematics, condition)
    return [replace(row, name=f"lambda_{condition.name}_{k}") for k, row in enumerate(rows, start=1)]
