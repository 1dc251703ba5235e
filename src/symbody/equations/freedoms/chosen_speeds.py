"""The choice of dependent speeds: those that follow best from the others, wherever the mechanism may stand.

At each of several assembled configurations the rows of the constraints on velocities are factored with column
pivoting (Golub & Van Loan 2013, section 5.4.2), speeds measured by their share of the kinetic energy. Each
configuration proposes the speeds of its pivots; taken are those whose coefficients are farthest from singular
where they are nearest to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from symbody.equations.elimination.dependent_speeds import nothing_to_eliminate
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.freedoms.mobility import values_when_assembled
from symbody.errors import FormulationError, Problem
from symbody.manifold import column_volume, pivot_order
from symbody.tolerances import RANK

Rows = list[list[float]]

_LEAST_MASS: Final = 1e-12  # of the largest: what is lighter counts as this, so that it is taken first


def choose_dependent_speeds(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the names of speeds to eliminate, one for each constraint on velocities.

    Raises
    ------
    FormulationError
        If there are no such constraints, or they depend on each other at every configuration, naming one
        that does.
    AssemblyError, ModelError
        If the loops close nowhere, or a parameter has no value.
    """
    places = [k for k, row in enumerate(formed.rows) if not row.is_holonomic]
    if not places:
        raise FormulationError(nothing_to_eliminate())
    found = [
        _scale_rows(formed, places, *values)
        for values in values_when_assembled(formed, ("jacobian", "mass_matrix"))
    ]
    proposals = list(dict.fromkeys(_pivots(rows) for rows in found))
    whole = [columns for columns in proposals if len(columns) == len(places)]
    if not whole:
        raise FormulationError(_dependent(formed, places, found[0]))
    best = max(whole, key=lambda columns: min(column_volume(rows, columns) for rows in found))
    return tuple(formed.u[k].label for k in sorted(best))


def _scale_rows(
    formed: EquationsOfMotion, places: Sequence[int], slopes: Sequence[float], mass: Sequence[float]
) -> Rows:
    """Return the rows in speeds of equal kinetic energy, each of unit length."""
    n = len(formed.u)
    weights = [mass[k * n + k] for k in range(n)]
    least = _LEAST_MASS * max(weights) or 1.0
    rows = []
    for place in places:
        row = [slopes[place * n + k] / math.sqrt(max(weights[k], least)) for k in range(n)]
        size = math.sqrt(sum(x * x for x in row)) or 1.0
        rows.append([x / size for x in row])
    return rows


def _pivots(rows: Rows) -> tuple[int, ...]:
    """Return the columns of a factorization with column pivoting, as many as are independent."""
    order, pivots = pivot_order(rows)
    return tuple(sorted(int(k) for k in order[: int((pivots > RANK).sum())]))


def _dependent(formed: EquationsOfMotion, places: Sequence[int], rows: Rows) -> Problem:
    """Say which row depends on those before it."""
    kept: Rows = []
    name = formed.rows[places[-1]].name
    for place, row in zip(places, rows, strict=True):
        if len(_pivots([*kept, row])) == len(kept):
            name = formed.rows[place].name
            break
        kept.append(row)
    return Problem(
        "equations.dependent_rows", "dependent_speeds",
        f"the velocity constraints depend on each other: {name} follows from those before it",
        f"each of the {len(places)} constraints must determine one speed",
        "remove the redundant constraint, or leave dependent_speeds out",
    )  # fmt: skip
