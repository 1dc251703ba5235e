"""The constraints of a mechanism by hand as rows of the equations of motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from symbody.equations.by_hand.energies import is_on_velocities
from symbody.equations.by_hand.mechanism import HandPlaced
from symbody.equations.constraints.couplings import velocity_row
from symbody.equations.constraints.integrability import is_integrable
from symbody.equations.constraints.pairs import by_time
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.row import Row, scalar_row
from symbody.errors import FormulationError, Problem
from symbody.expr.fingerprint import vanishing
from symbody.expr.printing.text import to_text


def rows_by_hand(mechanism: HandPlaced, kinematics: Kinematics) -> tuple[tuple[Row, ...], tuple[str, ...]]:
    """Return the rows, those on positions first, and what is said of them.

    Raises
    ------
    FormulationError
        If one is not of first degree in the rates, or holds nothing that moves.
    """
    rows, notes, problems = [], [], []
    for row in sorted(_rows(mechanism, kinematics), key=lambda row: not row.is_holonomic):
        graph = kinematics.graph
        idle = all(vanishing(graph, [slope.index for slope in row.slopes.values()]))
        left = row.value if row.is_holonomic else row.rest
        if not idle:
            rows.append(row)
            if not row.is_holonomic and is_integrable(kinematics, row):
                notes.append(
                    f"constraint {row.element}: it constrains rates, but it is the rate of a constraint on "
                    "positions, which would keep them from drifting; write it in coordinates"
                )
        elif vanishing(graph, [left.index])[0]:
            notes.append(f"constraint {row.element}: it holds identically and is dropped")
        else:
            problems.append(_never(row, to_text(graph, left.index)))
    if problems:
        raise FormulationError(*problems)
    return tuple(rows), tuple(notes)


def _rows(mechanism: HandPlaced, kinematics: Kinematics) -> Iterator[Row]:
    for constraint in mechanism.constraints:
        for value, name in zip(constraint.values, constraint.multipliers, strict=True):
            if is_on_velocities(kinematics.graph, value.index):
                row = velocity_row(kinematics, name, value, f"constraint {name}")
                yield replace(row, name=name, driven=-row.rest)
            else:
                row = scalar_row(kinematics, name, name, value)
                yield replace(row, driven=-by_time(value))


def _never(row: Row, left: str) -> Problem:
    return Problem(
        "by_hand.never_closed", f"constraint {row.element}",
        f"its left-hand side is {left}, whatever moves",
        "no coordinate is in it", "leave it out, or write it in the coordinates it holds",
    )  # fmt: skip
