"""Speeds that were eliminated, at configurations where they do not follow from the others."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.closure import Closure
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem
from symbody.tolerances import ASSEMBLED

CURE: Final = (
    "name other dependent_speeds, whose pivot does not vanish on the way, or leave dependent_speeds out: "
    "multipliers have no such place"
)


def pivot_groups(eqs: EquationSet) -> list[list[str]]:
    """Return the dependent speeds that have a pivot which may vanish, those that share one together."""
    elimination = eqs.formed.elimination
    groups: dict[int, list[str]] = {}
    for name, pivot in () if elimination is None else elimination.pivots.items():
        groups.setdefault(pivot.index, []).append(name.removesuffix("_pivot"))
    return list(groups.values())


def check_pivots(evaluator: Closure, q: NDArray[np.float64]) -> None:
    """Refuse a configuration at which dependent speeds do not follow from the others.

    Raises
    ------
    AssemblyError
        Naming the speeds.
    """
    groups = pivot_groups(evaluator.eqs)
    if not groups:
        return
    still = np.zeros(len(evaluator.eqs.speed_names))
    found = np.ravel(evaluator.function([f"{names[0]}_pivot" for names in groups])(evaluator.t, q, still))
    lost = [names for names, value in zip(groups, found, strict=True) if not abs(value) > ASSEMBLED]
    if lost:
        raise AssemblyError(*(_vanishing_pivot(", ".join(names)) for names in lost))


def _vanishing_pivot(names: str) -> Problem:
    return Problem(
        "assembly.dependent_speeds", "dependent_speeds",
        f"at this configuration {names} do not follow from the other speeds",
        "the coefficients of these speeds in the constraints on velocities form a singular matrix", CURE,
    )  # fmt: skip
