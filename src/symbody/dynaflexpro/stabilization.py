"""Baumgarte's stabilization with the constants alpha and beta, for `SetBaumgarte`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.expression import Expr


def check_pair(pair: Sequence[float]) -> tuple[float, float]:
    """Return alpha and beta as they are.

    Raises
    ------
    UsageError
        If there are not two finite numbers >= 0.
    """
    values = list(pair) if isinstance(pair, Iterable) else [pair]
    numbers = all(isinstance(value, int | float) and 0 <= value < math.inf for value in values)
    if len(values) != 2 or not numbers:
        raise UsageError(
            Problem("dynaflexpro.baumgarte", "SetBaumgarte", f"{values} are not two numbers >= 0",
                    "", "give alpha and beta, for instance SetBaumgarte([5, 5]); [0, 0] switches it off")
        )  # fmt: skip
    return values[0], values[1]


def stabilize(eqs: EquationSet, alpha: float, beta: float) -> EquationSet:
    """Return equations whose constraints decay like ``Psi'' + 2 alpha Psi' + beta^2 Psi = 0``."""
    if not alpha and not beta:
        return eqs
    graph, rows = eqs.formed.graph, []
    for row in eqs.formed.rows:
        rate = row.drift
        for speed, slope in row.jacobian.items():
            rate = rate + slope * Expr(graph, speed)
        rows.append(replace(row, gamma=row.gamma - (rate * (2 * alpha) + row.value * beta**2)))
    return EquationSet(eqs.model, eqs.formed.with_rows(tuple(rows)), eqs.notes)
