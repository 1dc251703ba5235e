"""Motions of mechanisms whose constraints follow from others only where all loops are closed.

Bennett's linkage is one, and three wheels that share a rod. Stages of a step, the polynomial inside it and
samples before they are projected are open by what a tolerance allows; there all constraints are independent,
and hold the mechanism or turn it aside, however small the opening.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.manifold import count_significant
from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints, motion_branch
from symbody.simulation.methods.closed_loops.partition import Partition
from symbody.simulation.methods.closed_loops.partition_states import independent_rows, without_other_rows
from symbody.simulation.methods.constraints import Baumgarte
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.integration import Integration, end_run, integrate_motion
from symbody.simulation.motion import Motion
from symbody.simulation.native.run import RawRun
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

# Relative singular value of rows that no longer follow from others a step beside the closed configurations.
_STANDS: Final = 1e-7
# How far beside, in rad or shares of the mechanism's size. Where cranks stand across their rod, what the rows
# have of their own begins with the cube of this.
_BESIDE: Final = (0.01, 0.1)
# Where rows that are kept have a least singular value below this share of all rows', at so many places of a
# step: there `Partition` chooses others.
_LEAST_SHARE: Final = 0.1
_PER_STEP: Final = 5
_CHOSEN: Final = (
    "some constraints are redundant only where all loops are closed, see sb.redundancy(): sb.Partition() "
    "integrates the motion"
)
_REPLACED: Final = (
    "some constraints are redundant only where all loops are closed, see sb.redundancy(): between such "
    "states sb.Projection() would block or divert the mechanism, so sb.Partition() integrates the motion"
)
_WORN: Final = (
    "at t = {:.6g} s the motion ends for {}: some constraints are redundant only where all loops are "
    "closed, see sb.redundancy(), and the constraints it selected no longer represent all of them: omit "
    "integrator= and constraints=, or use sb.Partition()"
)
_JUMPED: Final = (
    "at t = {:.6g} s {} cannot continue: some constraints are redundant, see sb.redundancy(), and which of "
    "them are independent changes there within one step; omit integrator=, or use sb.Partition()"
)
# Positions that are open by more than this share of the mechanism's size are none that a step ends at.
_OPEN: Final = 1e-6
_LAST_STEPS: Final = 5


def is_overconstrained(problem: SimulationProblem, t: float, x: Floats) -> bool:
    """Return whether constraints follow from others only where all loops are closed."""
    eqs = problem.eqs
    if not eqs.multiplier_names or not eqs.speed_names:
        return False
    first = problem.first_numbers(t, x)
    if first is not None and first.is_regular:
        return False
    loops = LoopConstraints(problem)
    if not loops.depends(t, x[loops.places]):
        return False
    branch = motion_branch(loops, t, x)
    # Each coordinate that takes part goes on by an amount of its own: zeros stay, as across a plane.
    tangents = np.linalg.svd(loops.positions(branch.t, branch.q)[1])[2][branch.positions :]
    shares = np.linspace(0.5, 1.5, branch.q.size) * tangents.sum(axis=0)
    moves = np.multiply.outer(_BESIDE, shares * loops.sizes)
    beside = [loops.singular_values(branch.t, branch.q + move) for move in moves]
    return any(count_significant(sizes, _STANDS) > branch.speeds for sizes in beside)


def integrate_by_partition(motion: Motion) -> Integration:
    """Return the run of a motion by `Partition`, with a note that says so."""
    run = integrate_motion(replace(motion, constraints=Partition()))
    return run._replace(notes=(_CHOSEN if motion.constraints is None else _REPLACED, *run.notes))


def integrate_independent(motion: Motion) -> Integration:
    """Return the run of a motion without constraints that follow from others on the branch of the motion.

    It ends where those kept no longer determine the motion about as well as all of them.
    """
    problem, t, x = motion.problem, motion.span[0], motion.state
    kept = independent_rows(problem, t, x)
    if len(kept) == len(problem.eqs.formed.rows):
        return integrate_motion(motion)
    independent = replace(problem, eqs=without_other_rows(problem.eqs, kept))
    run = integrate_motion(replace(motion, problem=independent))
    end = _worn(LoopConstraints(problem), kept, run.raw)
    if end is None:
        return run
    method = motion.constraints if isinstance(motion.constraints, Baumgarte) else motion.integrator
    return end_run(run, end, _WORN.format(end, f"sb.{type(method).__name__}()"))


def end_where_rows_change(motion: Motion, run: Integration) -> Integration:
    """Return a run of steps of a given length that ends where the last of them left the mechanism closed.

    Steps that follow their errors become ever smaller where it changes which constraints count. Others go
    across, by accelerations without bounds, to positions that are open, of which nothing can be said.
    """
    integrator, dense = motion.integrator, run.raw.dense_output
    is_fixed = isinstance(integrator, FixedStep | GeneralizedAlpha) and integrator.step is not None
    if not is_fixed or run.raw.status not in (Status.SINGULAR, Status.NOT_FINITE) or dense is None:
        return run
    loops = LoopConstraints(motion.problem)
    for t in dense.breaks[-2 : -2 - _LAST_STEPS : -1].tolist():
        q = dense(t)[loops.places]
        values, _ = loops.positions(t, q)
        if (np.abs(values) <= _OPEN).all():
            note = _JUMPED.format(t, f"sb.{type(integrator).__name__}()")
            return end_run(run, t, note) if loops.depends(t, q) else run
    return run


def _worn(loops: LoopConstraints, kept: list[int], raw: RawRun) -> float | None:
    """Return the end of the last step before some constraints determine a motion much worse than all do."""
    dense, rank = raw.dense_output, len(kept)
    if dense is None or rank == 0:
        return None
    inside = np.diff(dense.breaks)[:, np.newaxis] * np.linspace(0.0, 1.0, _PER_STEP)[:-1]
    t = np.append(dense.breaks[:-1, np.newaxis] + inside, dense.breaks[-1])
    rows, _ = loops.speeds(t, dense(t)[loops.places].T)
    if not np.isfinite(rows).all():
        return None
    least, of_all = (np.linalg.svd(some, compute_uv=False)[:, rank - 1] for some in (rows[:, kept], rows))
    worn = np.flatnonzero(least < _LEAST_SHARE * of_all)
    return float(dense.breaks[worn[0] // (_PER_STEP - 1)]) if worn.size else None
