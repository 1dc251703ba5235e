"""Equations without constraints that follow from others on the branch of a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints, motion_branch
from symbody.simulation.methods.closed_loops.partition_states import partition_columns
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]


def independent_rows(problem: SimulationProblem, t: float, x: Floats) -> list[int]:
    """Return the places of as many constraints as are independent on the branch of a state.

    They are the farthest from dependent at a regular configuration of the branch.
    """
    loops = LoopConstraints(problem)
    branch = motion_branch(loops, t, x)
    count = len(problem.eqs.formed.rows)
    if branch.speeds == count:
        return list(range(count))
    kept: list[int] = partition_columns(loops.speeds(branch.t, branch.q)[0], branch.speeds).rows.tolist()
    return kept


def without_other_rows(eqs: EquationSet, kept: Sequence[int]) -> EquationSet:
    """Return the equations with these constraints alone."""
    return EquationSet(eqs.model, eqs.formed.with_independent(kept), eqs.notes)
