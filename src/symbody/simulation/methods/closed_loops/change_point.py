"""Motions past positions where constraints become dependent, and the choice of what passes them.

Accelerations leave the branch of the motion open there (change points, such as a flat parallelogram's), and
constraints that follow from others only where all loops are closed, as in Bennett's linkage or where three
wheels share a rod, seem to lock the mechanism beside such states. `Partition` passes both; other ways to hold
constraints are judged by what they computed: velocities are continuous on the branch of a motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.expr.graph import SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.manifold import count_significant
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR, LoopConstraints, motion_branch
from symbody.simulation.methods.closed_loops.overconstrained import (
    end_where_rows_change,
    integrate_by_partition,
    integrate_independent,
    is_overconstrained,
)
from symbody.simulation.methods.closed_loops.partition import Partition
from symbody.simulation.methods.closed_loops.unresolved_poses import unresolved_pose_notes
from symbody.simulation.methods.constraints import Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.gear_gupta_leimkuhler import GGL
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.integration import Integration, MotionPlan, end_run, integrate_plan
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import RawRun
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

_BESIDE: Final = 1e-2  # rad, or share of the mechanism's size
# A change point is passed where the smallest singular value falls to this share of its largest, or a motion
# breaks off below the larger one. A minimum worth a closer look is below the third.
_PASSED: Final = 3e-3
_STUCK: Final = 5e-2
_LOW: Final = 0.5
# Share of a motion below which the last of too many steps is one that became ever smaller.
_SHORT: Final = 1e-3
_TWO: Final = 2
_PROJECTION: Final = Projection()
_PARTITION: Final = Partition()
# Share of the prescribed velocities that counts.
_DEMANDED: Final = 1e-2
_REFINEMENTS: Final = 12
_PER_REFINEMENT: Final = 9
# Velocities on both sides of a change point are compared where the singular value is this share: some tenths
# of a radian apart. Extrapolated from one side, with what a parabola leaves, they agree to the cube of that;
# those of two branches differ by their angle, of order one.
_BESIDE_IT: Final = 0.03
_SAME_BRANCH: Final = 0.1
_DOUBLINGS: Final = 48
_CHANGED: Final = (
    "at t = {:.6g} s constraints become dependent (change point), where sb.Projection() may take another "
    "branch: sb.Partition() integrates the motion"
)
_LEFT: Final = (
    "at t = {:.6g} s constraints become dependent (change point), where {} leaves the branch of the motion: "
    "leave constraints out, or use sb.Partition()"
)
_ENDS: Final = (
    "the motion breaks off near a change point, where constraints become dependent and {} finds no way on: "
    "leave constraints out, or use sb.Partition()"
)
_STARTS: Final = (
    "the start is a change point, where constraints become dependent and {} finds no way on: leave "
    "constraints out, use sb.Partition(), or start a little beside it"
)
_SEVERAL: Final = (
    "the start is a change point, where the mechanism can go on in several ways, and its velocities are not "
    "those of one of them: the motion is one of several; start a little beside it, or give other velocities"
)
_LOCKED: Final = (
    "some constraints follow from others only where all loops are closed, see sb.redundancy(), so that {} "
    "finds the mechanism locked beside such states: leave constraints out, or use sb.Partition()"
)
_EXCHANGED: Final = (
    "at t = {:.6g} s sb.Projection() finds no way on: some constraints follow from others, see "
    "sb.redundancy(), and which of them count changes there; sb.Partition() integrates the motion"
)
_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE, Status.TOO_MANY_STEPS)
# Ends after which the motion is looked at: one that was interrupted is not begun again.
_JUDGED: Final = (Status.SUCCESS, Status.STOPPED, *_COLLAPSES)


def change_point_note(notes: Iterable[str]) -> str:
    """Return what the notes of a motion say of a change point on its way; empty without one."""
    return next((note for note in notes if "(change point)" in note or "near a change point" in note), "")


def integrate_on_branch(plan: MotionPlan) -> Integration:
    """Return the run of a plan on its branch; without constraints given, `Projection` where that is safe."""
    constraints = plan.constraints or _PROJECTION
    integration = plan.integration
    problem, eqs, t, x = integration.problem, integration.eqs, integration.span[0], integration.state
    if isinstance(constraints, Partition) or not eqs.multiplier_names or not eqs.speed_names:
        return integrate_plan(plan)
    if eqs.plans.get(
        "constant rows", partial(has_constant_rows, eqs)
    ):  # nothing becomes dependent on the way
        return integrate_plan(plan)
    by_partition = replace(plan, constraints=_PARTITION)
    is_replaceable = isinstance(constraints, Projection) and isinstance(plan.integrator, Explicit | None)
    follows = is_overconstrained(problem, t, x)
    if follows and is_replaceable:
        return integrate_by_partition(plan)
    run = integrate_plan(plan) if isinstance(constraints, GGL) or not follows else integrate_independent(plan)
    run = _with_step_notes(run, plan)
    if run.raw.status not in _JUDGED:
        return run
    at = change_point(problem, run.raw) if plan.constraints is None else None
    is_plain = plan.constraints is None and at is None and run.raw.status.success
    end = (
        None
        if is_plain
        else _end_of_branch(problem, t, x, run, is_locked=follows and isinstance(constraints, GGL))
    )
    if is_replaceable and (reason := _reason_to_replace(problem, run.raw, at, end)):
        second = integrate_plan(by_partition)
        if second.raw.status.success:
            return second._replace(notes=(reason, *second.notes))
        if second.raw.status is Status.SINGULAR and second.raw.reached == t:
            run = run._replace(notes=(*run.notes, _SEVERAL))
    if end is None:
        return end_where_rows_change(plan, run)
    return end_run(run, end.t, end.note.format(f"sb.{type(constraints).__name__}()"))


def has_constant_rows(eqs: EquationSet) -> bool:
    """Return whether the Jacobian of the constraints is the same wherever and whenever it is taken."""
    graph = eqs.formed.graph
    entries = [entry.index for row in eqs.formed.rows for entry in row.jacobian.values()]
    symbols = (graph.symbols[graph.left[place]] for place in symbols_of(graph, entries))
    return all(symbol.kind is SymbolKind.PARAMETER for symbol in symbols)


def _with_step_notes(run: Integration, plan: MotionPlan) -> Integration:
    """Return a run with a note where steps of a given length are too long; others follow their errors."""
    step = plan.integrator.step if isinstance(plan.integrator, FixedStep | GeneralizedAlpha) else None
    if step is None:
        return run
    notes = unresolved_pose_notes(plan.integration.problem, run.raw, step)
    return run._replace(notes=(*run.notes, *notes))


def is_change_point(problem: SimulationProblem, t: float, x: Floats) -> bool:
    """Return whether constraints are dependent at a state that are not so elsewhere on its branch."""
    loops = LoopConstraints(problem)
    branch = motion_branch(loops, t, x)
    return (
        branch.speeds > 0
        and loops.singular_values(t, x[loops.places])[branch.speeds - 1] < NEAR * branch.reference
    )


def _reason_to_replace(
    problem: SimulationProblem, raw: RawRun, at: float | None, end: _BranchEnd | None
) -> str:
    """Return why `Partition` should integrate again what `Projection` computed; empty if it need not."""
    if at is not None:
        return _CHANGED.format(at)
    if end is not None:
        return end.note.format("sb.Projection()")
    return _EXCHANGED.format(raw.reached) if _breaks_off_dependent(problem, raw) else ""


def _breaks_off_dependent(problem: SimulationProblem, raw: RawRun) -> bool:
    """Return whether steps became ever smaller where constraints follow from others."""
    loops, dense = LoopConstraints(problem), raw.dense_output
    if dense is None or not _is_collapse(raw.status, dense.breaks):
        return False
    return loops.depends(raw.reached, dense(raw.reached)[loops.places])


def change_point(problem: SimulationProblem, raw: RawRun) -> float | None:
    """Return the time of the first change point of a motion, or None."""
    passages = _passages(problem, raw)
    return None if passages is None else next(passages.times(), passages.end(raw))


@dataclass(frozen=True, slots=True)
class _BranchEnd:
    """Where a motion leaves the branch of its start; None if its run ended there by itself."""

    t: float | None
    note: str


def _end_of_branch(
    problem: SimulationProblem, t: float, x: Floats, run: Integration, *, is_locked: bool
) -> _BranchEnd | None:
    """Return where a motion leaves its branch, or breaks off; `is_locked` if for constraints that follow."""
    raw, _, watch = run
    passages = _passages(problem, raw, motion_branch(LoopConstraints(problem), t, x).speeds)
    if passages is not None:
        happened = [] if watch is None else [event.t for event in watch.occurrences]
        for at in passages.times():
            before = passages.jump(at, happened)
            if before is not None:
                return _BranchEnd(before, _LEFT.format(at, "{}"))
    if raw.status.success:
        return None
    if raw.reached == t and is_change_point(problem, t, x):
        return _BranchEnd(None, _STARTS)
    if raw.dense_output is not None and not _is_collapse(raw.status, raw.dense_output.breaks):
        return None
    if is_locked:
        return _BranchEnd(None, _LOCKED)
    return _end_beside_change_point(problem, t, x, raw, passages)


def _end_beside_change_point(
    problem: SimulationProblem, t: float, x: Floats, raw: RawRun, passages: _Passages | None
) -> _BranchEnd | None:
    """Return where a motion breaks off beside a change point, if it does: there steps become ever smaller.

    One that reached the change point and never came away from it may be on any branch since then.
    """
    if raw.dense_output is None:
        return None
    loops = LoopConstraints(problem)
    branch = motion_branch(loops, t, x)
    q = raw.dense_output(raw.reached)[loops.places]
    if (
        not branch.speeds
        or not loops.singular_values(raw.reached, q)[branch.speeds - 1] < _STUCK * branch.reference
    ):
        return None
    if _locks_up(loops, raw.reached, q, branch.speeds, branch.reference):
        return None
    apart = np.abs((q - x[loops.places]) / loops.sizes).max()
    if apart < _BESIDE and is_change_point(problem, t, x):
        return _BranchEnd(None, _STARTS)
    return _BranchEnd(None if passages is None else passages.last_clear(), _ENDS)


def _locks_up(loops: LoopConstraints, t: float, q: Floats, rank: int, reference: float) -> bool:
    """Return whether prescribed motions ask for what is lost at a configuration: there their branch ends."""
    rows, drift = loops.speeds(t, q)
    if not loops.is_driven or not np.isfinite(rows).all():
        return False
    left, sizes, _ = np.linalg.svd(rows)
    lost = left[:, :rank][:, sizes[:rank] < _STUCK * reference]
    return bool(np.linalg.norm(lost.T @ drift) > _DEMANDED * np.linalg.norm(drift))


def _passages(problem: SimulationProblem, raw: RawRun, most: int | None = None) -> _Passages | None:
    """Return what finds the change points of a motion; None if it has no constraints that count.

    Parameters
    ----------
    most : int, optional
        How many constraints are independent on the branch of the start, above which a motion has left it.
    """
    eqs, dense = problem.eqs, raw.dense_output
    if not eqs.multiplier_names or not eqs.speed_names or dense is None:
        return None
    loops = LoopConstraints(problem)
    sizes = loops.singular_values(dense.breaks, dense.at_breaks()[loops.places].T)
    if not np.isfinite(sizes).all():
        return None
    rank = count_significant(sizes)
    rank = min(rank, most or rank)
    if rank == 0:
        return None
    largest = float(sizes[:, rank - 1].max())
    return _Passages(loops, dense, rank, largest, sizes[:, rank - 1] / largest)


@dataclass(frozen=True, slots=True, eq=False)
class _Passages:
    """A motion with the least singular value that counts, over its largest, at the ends of all steps."""

    loops: LoopConstraints
    dense: DenseOutput
    rank: int
    largest: float
    least: Floats

    def shares(self, t: Floats) -> Floats:
        """Return that value at any times."""
        found: Floats = self.loops.singular_values(t, self.dense(t)[self.loops.places].T)[:, self.rank - 1]
        return found / self.largest

    def times(self) -> Iterator[float]:
        """Yield the times of change points."""
        breaks = self.dense.breaks
        for k in _minima(self.least):
            at = _dip(self.shares, float(breaks[max(k - 1, 0)]), float(breaks[min(k + 1, breaks.size - 1)]))
            if at is not None:
                yield at

    def end(self, raw: RawRun) -> float | None:
        """Return the end of the motion if it broke off near a change point."""
        is_stuck = _is_collapse(raw.status, self.dense.breaks) and self.least[-1] < _STUCK
        return float(self.dense.breaks[-1]) if is_stuck else None

    def jump(self, at: float, happened: list[float]) -> float | None:
        """Return a time shortly before a change point if velocities are others after it, not by an event."""
        breaks = self.dense.breaks
        before, after = self._time_beside(at, float(breaks[0])), self._time_beside(at, float(breaks[-1]))
        if before is None and after is not None:  # the motion starts there
            return float(breaks[0]) if self._differs(after, float(breaks[0]), happened) else None
        if before is None:
            return None
        if after is None:  # it never came away
            end = float(breaks[-1])
            if _locks_up(self.loops, end, self.dense(end)[self.loops.places], self.rank, self.largest):
                return None
            after = min(2.0 * at - before, end, key=lambda t: abs(t - at))
        # Too short a motion before the change point is compared with where velocities beyond it come from.
        sides = (before, after) if self._reaches(before, after) else (after, before)
        return before if self._differs(*sides, happened) else None

    def last_clear(self) -> float | None:
        """Return the last time before the change point at which a motion ends; None if it came to none."""
        start, end = self.dense.breaks[[0, -1]].tolist()
        for at in self.times():
            if self._time_beside(at, end) is None:
                return self._time_beside(at, start)
        return None

    def _differs(self, near: float, far: float, happened: list[float]) -> bool:
        """Return whether velocities at one time are not those to which they lead from beyond another one."""
        if not self._reaches(near, far) or any(min(near, far) <= t <= max(near, far) for t in happened):
            return False
        times = near + (near - far) * np.array([0.5, 0.25, 0.0])
        u = self.dense(np.array([*times, far])).T[:, : self.loops.speed_sizes.size] / self.loops.speed_sizes
        # The parabola through velocities at 0, 1 and 2, at 6.
        apart = np.abs(np.array([10.0, -24.0, 15.0]) @ u[:3] - u[3]).max()
        return bool(apart > _SAME_BRANCH * np.abs(u).max())

    def _reaches(self, near: float, far: float) -> bool:
        """Return whether there is enough motion on the far side of a time to lead to another one."""
        first, last = sorted(map(float, self.dense.breaks[[0, -1]]))
        return first <= near + 0.5 * (near - far) <= last

    def _time_beside(self, at: float, limit: float) -> float | None:
        """Return the nearest time towards a limit at which constraints are independent again."""
        times = at + (limit - at) * np.exp2(-np.arange(_DOUBLINGS - 1.0, -1.0, -1.0))
        times[-1] = limit  # the sum may be rounded to beyond it, where there is no motion
        clear = np.flatnonzero(self.shares(times) > _BESIDE_IT)
        return float(times[clear[0]]) if clear.size else None


def _is_collapse(status: Status, breaks: Floats) -> bool:
    """Return whether steps became ever smaller, which a mere limit on their number does not say."""
    if status is not Status.TOO_MANY_STEPS or breaks.size < _TWO:
        return status in _COLLAPSES
    return bool(abs(breaks[-1] - breaks[-2]) < _SHORT * abs(breaks[-1] - breaks[0]))


def _minima(values: Floats) -> list[int]:
    """Return where low values are no larger than their neighbours."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    low = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]) & (values < _LOW)
    return [int(k) for k in np.flatnonzero(low)]


def _dip(shares: Callable[[Floats], Floats], start: float, stop: float) -> float | None:
    """Return where shares fall to `_PASSED` between two times, by ever closer samples about the least."""
    for _ in range(_REFINEMENTS):
        inside = np.linspace(start, stop, _PER_REFINEMENT)
        found = shares(inside)
        best = int(found.argmin())
        if found[best] < _PASSED:
            return float(inside[best])
        start, stop = float(inside[max(best - 1, 0)]), float(inside[min(best + 1, inside.size - 1)])
    return None
