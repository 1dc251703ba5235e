"""The constraints of a mechanism by hand as rows of the equations of motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from symbody.equations.by_hand.energies_by_hand import is_on_velocities
from symbody.equations.by_hand.mechanism import MechanismByHand
from symbody.equations.constraints.couplings import velocity_equation
from symbody.equations.constraints.frame_constraints import time_partial
from symbody.equations.constraints.integrability import is_integrable
from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.motion import Kinematics
from symbody.errors import FormulationError, Problem
from symbody.expr.fingerprint import find_zeros
from symbody.expr.printing.text import to_text


def rows_by_hand(
    mechanism: MechanismByHand, kinematics: Kinematics
) -> tuple[tuple[ConstraintEquation, ...], tuple[str, ...]]:
    """Return the rows, those on positions first, and what is said of them.

    Raises
    ------
    FormulationError
        If one is not of first degree in the rates, or holds nothing that moves.
    """
    rows, notes, problems = [], [], []
    for row in sorted(_rows(mechanism, kinematics), key=lambda row: not row.is_holonomic):
        graph = kinematics.graph
        idle = all(find_zeros(graph, [slope.index for slope in row.jacobian.values()]))
        left = row.value if row.is_holonomic else row.drift
        if not idle:
            rows.append(row)
            if not row.is_holonomic and is_integrable(kinematics, row):
                notes.append(
                    f"constraint {row.element}: it constrains rates, but it is the rate of a constraint on "
                    "positions, which would keep them from drifting; write it in coordinates"
                )
        elif find_zeros(graph, [left.index])[0]:
            notes.append(f"constraint {row.element}: it holds identically and is dropped")
        else:
            problems.append(_never(row, to_text(graph, left.index)))
    if problems:
        raise FormulationError(*problems)
    return tuple(rows), tuple(notes)


def _rows(mechanism: MechanismByHand, kinematics: Kinematics) -> Iterator[ConstraintEquation]:
    for constraint in mechanism.constraints:
        for value, name in zip(constraint.values, constraint.multipliers, strict=True):
            if is_on_velocities(kinematics.graph, value.index):
                row = velocity_equation(kinematics, name, value, f"constraint {name}")
                yield replace(row, name=name, driven=-row.drift)
            else:
                row = scalar_equation(kinematics, name, name, value)
                yield replace(row, driven=-time_partial(value))


def _never(row: ConstraintEquation, left: str) -> Problem:
    return Problem(
        "by_hand.never_closed", f"constraint {row.element}",
        f"its left-hand side is {left}, whatever moves",
        "no coordinate is in it", "leave it out, or write it in the coordinates it holds",
    )  # fmt: skip
