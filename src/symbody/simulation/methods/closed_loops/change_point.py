"""Motions past positions where constraints become dependent, and the choice of what passes them.

Accelerations leave the branch of the motion open there (change points, such as a flat parallelogram's), and
constraints that follow from others only where all loops are closed, as in Bennett's linkage or where three
wheels share a rod, seem to lock the mechanism beside such states. `Partition` passes both; other ways to hold
constraints are judged by what they computed: velocities are continuous on the branch of a motion.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.expr.graph import SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.kernels.step_bounds import EPSILON
from symbody.manifold import count_significant
from symbody.simulation.hybrid.switching import SwitchingModes
from symbody.simulation.methods.closed_loops.crossing import crossing_of_motion
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR, LoopConstraints, motion_branch
from symbody.simulation.methods.closed_loops.overconstrained import (
    end_where_rows_change,
    integrate_by_partition,
    integrate_independent,
    is_overconstrained,
)
from symbody.simulation.methods.closed_loops.partition import Partition
from symbody.simulation.methods.closed_loops.passages import LOW, Passages, locks_up
from symbody.simulation.methods.constraints import Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.gear_gupta_leimkuhler import GGL
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.methods.integration import Integration, end_run, integrate_motion
from symbody.simulation.methods.moreau_jean import MoreauJean
from symbody.simulation.motion import Motion
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import RawRun
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

_BESIDE: Final = 1e-2  # rad, or share of the mechanism's size
# Share of a motion below which the last of too many steps is one that became ever smaller.
_SHORT: Final = 1e-3
_TWO: Final = 2
_PROJECTION: Final = Projection()
_PARTITION: Final = Partition()
# What is said where `Partition` takes over; else a cure follows.
_TAKES_OVER: Final = ", so sb.Partition() integrates the motion"
_BY_PARTITION: Final = "omit constraints=, or use sb.Partition()"
_CHANGED: Final = (
    "at t = {:.6g} s constraints become dependent (change point), where sb.Projection() may continue on "
    "another branch"
)
_LEFT: Final = (
    "at t = {:.6g} s constraints become dependent (change point), where {} leaves the branch of the motion",
    _BY_PARTITION,
)
_LEAPT: Final = (
    "near t = {:.6g} s branches of the mechanism pass each other without meeting (lengths that differ by "
    "{:.2g} of the mechanism's size would make them meet), and {} switches to another one",
    "use a smaller rtol",
)
_UNBALANCED: Final = (
    "near t = {:.6g} s branches of the mechanism meet or come close, and energy minus work changes there by "
    "{:.3g} J with {}, but by {:.3g} J in a neighbouring step",
    "use a smaller rtol, or omit constraints=",
)
_ENDS: Final = (
    "the motion ends near a change point, where constraints become dependent and {} cannot continue",
    _BY_PARTITION,
)
_STARTS: Final = (
    "the start is a change point, where constraints become dependent and {} cannot continue",
    "omit constraints=, use sb.Partition(), or start slightly away from it",
)
_SEVERAL: Final = (
    "the start is a change point, where the mechanism can move along several branches, and the velocities "
    "do not select one: the result is one of several possible motions; start slightly away from it, or give "
    "other velocities"
)
_LOCKED: Final = (
    "some constraints are redundant only where all loops are closed, see sb.redundancy(), so that for {} "
    "the mechanism is locked near such states",
    _BY_PARTITION,
)
_EXCHANGED: Final = (
    "at t = {:.6g} s sb.Projection() cannot continue: some constraints are redundant, see sb.redundancy(), "
    "and which of them are independent changes there"
)
_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE, Status.TOO_MANY_STEPS)
# Ends after which the motion is looked at: one that was interrupted is not begun again.
_JUDGED: Final = (Status.SUCCESS, Status.STOPPED, *_COLLAPSES)


def change_point_note(notes: Iterable[str]) -> str:
    """Return what the notes of a motion say of a change point on its way; empty without one."""
    return next((note for note in notes if "(change point)" in note or "near a change point" in note), "")


def samples_on_the_way(motion: Motion) -> bool:
    """Return whether the method of a motion takes the samples of signals inside its loop."""
    return not isinstance(motion.integrator, Stiff | MoreauJean) and not isinstance(motion.constraints, GGL)


def integrate_on_branch(motion: Motion) -> Integration:
    """Return a motion on its branch; without constraints given, `Projection` holds it where that is safe."""
    constraints = motion.constraints or _PROJECTION
    problem, t, x = motion.permanent_problem, motion.span[0], motion.state
    eqs = problem.eqs
    if not eqs.multiplier_names or not eqs.speed_names:
        return integrate_motion(motion)
    if eqs.plans.get(
        "constant rows", partial(has_constant_rows, eqs)
    ):  # nothing becomes dependent on the way
        return integrate_motion(motion)
    follows = is_overconstrained(problem, t, x)
    if isinstance(constraints, Partition):
        run = integrate_motion(motion)
        return run if follows or not run.raw.status.success else _judge_passages(motion, run)
    is_replaceable = isinstance(constraints, Projection) and isinstance(motion.integrator, Explicit | None)
    if follows and is_replaceable:
        return integrate_by_partition(motion)
    run = (
        integrate_motion(motion)
        if isinstance(constraints, GGL) or not follows
        else integrate_independent(motion)
    )
    run = _with_step_notes(run, motion)
    if run.raw.status not in _JUDGED:
        return run
    passages = find_passages(problem, run.raw)
    at = _first_change_point(passages, run.raw) if passages and motion.constraints is None else None
    is_locked = follows and isinstance(constraints, GGL)
    is_plain = run.raw.status.success and passages is None
    end = None if is_plain else _end_of_branch(motion, run, passages, is_locked=is_locked)
    if is_replaceable and (reason := _reason_to_replace(problem, run.raw, at, end)):
        second = _integrate_again(replace(motion, constraints=_PARTITION))
        if second.raw.status.success:
            return _judge_passages(motion, second._replace(notes=(reason, *second.notes)))
        if second.raw.status is Status.SINGULAR and second.raw.reached == t:
            run = run._replace(notes=(*run.notes, _SEVERAL))
    if end is None:
        return end_where_rows_change(motion, run)
    return end_run(run, end.t, end.note(f"sb.{type(constraints).__name__}()"))


def _integrate_again(motion: Motion) -> Integration:
    """Return another run of a motion; if it does not succeed held values and modes stay as they were."""
    both = (motion.problem.sampler, motion.modes)
    held: list[Sampler | SwitchingModes] = [each for each in both if each is not None]
    saved = [each.save() for each in held]
    run = integrate_motion(motion)
    if not run.raw.status.success:
        for each, values in zip(held, saved, strict=True):
            each.put_back(values)
    return run


def _judge_passages(motion: Motion, run: Integration) -> Integration:
    """Return a run by `Partition` that ends before a passage that its energies or its branch do not allow."""
    passages = find_passages(motion.permanent_problem, run.raw)
    end = None if passages is None else _untaken_passage(motion, passages)
    return run if end is None else end_run(run, end.t, end.note("sb.Partition()"))


def _untaken_passage(motion: Motion, passages: Passages) -> _BranchEnd | None:
    """Return where a motion goes over to a branch that does not meet its own, or gains or loses energy."""
    leap = passages.leap()
    if leap is not None:
        return _BranchEnd(leap.before, _LEAPT, (leap.at, leap.opening, "{}"))
    for at, before, after in passages.sides():
        balance = passage_balance(motion.problem, passages.dense, before, after, motion.rtol)
        if not balance.holds:
            return _BranchEnd(before, _UNBALANCED, (at, balance.change, "{}", balance.usual))
    return None


def has_constant_rows(eqs: EquationSet) -> bool:
    """Return whether the Jacobian of the constraints is the same wherever and whenever it is taken."""
    graph = eqs.formed.graph
    entries = [entry.index for row in eqs.formed.rows for entry in row.jacobian.values()]
    symbols = (graph.symbols[graph.left[place]] for place in symbols_of(graph, entries))
    return all(symbol.kind is SymbolKind.PARAMETER for symbol in symbols)


def _with_step_notes(run: Integration, motion: Motion) -> Integration:
    """Return a run with a note where steps of a given length are too long; others follow their errors."""
    fixed = FixedStep | GeneralizedAlpha | MoreauJean
    step = motion.integrator.step if isinstance(motion.integrator, fixed) else None
    if step is None:
        return run
    notes = unresolved_pose_notes(motion.permanent_problem, run.raw, step)
    return run._replace(notes=(*run.notes, *notes))


def is_change_point(problem: SimulationProblem, t: float, x: Floats) -> bool:
    """Return whether branches meet at a state, where constraints are dependent that are not so elsewhere."""
    loops = LoopConstraints(problem)
    branch = motion_branch(loops, t, x)
    if not branch.speeds:
        return False
    if not loops.singular_values(t, x[loops.places])[branch.speeds - 1] < NEAR * branch.reference:
        return False
    crossing = crossing_of_motion(loops, branch, t, x)
    return crossing is None or crossing.meets


def _reason_to_replace(
    problem: SimulationProblem, raw: RawRun, at: float | None, end: _BranchEnd | None
) -> str:
    """Return why `Partition` should integrate again what `Projection` computed; empty if it need not."""
    if at is not None:
        return _CHANGED.format(at) + _TAKES_OVER
    if end is not None:
        return end.what("sb.Projection()") + _TAKES_OVER
    return _EXCHANGED.format(raw.reached) + _TAKES_OVER if _breaks_off_dependent(problem, raw) else ""


def _breaks_off_dependent(problem: SimulationProblem, raw: RawRun) -> bool:
    """Return whether steps became ever smaller where constraints follow from others."""
    dense = raw.dense_output
    if dense is None or not _is_collapse(raw.status, dense.breaks):
        return False
    loops = LoopConstraints(problem)
    return loops.depends(raw.reached, dense(raw.reached)[loops.places])


def _first_change_point(passages: Passages, raw: RawRun) -> float | None:
    at = next(passages.times(), None)
    if at is None and _is_collapse(raw.status, passages.dense.breaks) and passages.ends_at_crossing():
        return float(passages.dense.breaks[-1])
    return at


@dataclass(frozen=True, slots=True)
class _BranchEnd:
    """Where a motion leaves the branch of its start; None if its run ended there by itself.

    `said` is what to say of it and the cure, `values` are those of the fields, "{}" that of the method.
    """

    t: float | None
    said: tuple[str, str]
    values: tuple[float | str, ...] = ("{}",)

    def what(self, method: str) -> str:
        """Return what happens with a method that holds constraints."""
        return self.said[0].format(*self.values).format(method)

    def note(self, method: str) -> str:
        """Return what happens, and the cure."""
        return f"{self.what(method)}: {self.said[1]}"


def _end_of_branch(
    motion: Motion, run: Integration, passages: Passages | None, *, is_locked: bool
) -> _BranchEnd | None:
    """Return where a motion leaves its branch, or breaks off; `is_locked` if for constraints that follow."""
    raw, _, watch = run
    problem, t, x = motion.permanent_problem, motion.span[0], motion.state
    if passages is not None:
        happened = [t for t, _ in raw.jumps] + [event.t for event in (watch.occurrences if watch else ())]
        for at in passages.times():
            before = passages.jump(at, happened)
            if before is not None:
                return _BranchEnd(before, _LEFT, (at, "{}"))
        if (end := _untaken_passage(motion, passages)) is not None:
            return end
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
    problem: SimulationProblem, t: float, x: Floats, raw: RawRun, passages: Passages | None
) -> _BranchEnd | None:
    """Return where a motion breaks off beside a change point, if it does: there steps become ever smaller.

    One that reached the change point and never came away from it may be on any branch since then.
    """
    if raw.dense_output is None or passages is None or not passages.ends_at_crossing():
        return None
    loops, branch = passages.loops, passages.branch
    q = raw.dense_output(raw.reached)[loops.places]
    if locks_up(loops, raw.reached, q, branch.speeds, branch.reference):
        return None
    apart = np.abs((q - x[loops.places]) / loops.sizes).max()
    if apart < _BESIDE and is_change_point(problem, t, x):
        return _BranchEnd(None, _STARTS)
    return _BranchEnd(passages.last_clear(), _ENDS)


def find_passages(problem: SimulationProblem, raw: RawRun) -> Passages | None:
    """Return the passages of a motion past singular configurations; None without constraints that count."""
    eqs, dense = problem.eqs, raw.dense_output
    if not eqs.multiplier_names or not eqs.speed_names or dense is None:
        return None
    loops = LoopConstraints(problem)
    sizes = loops.singular_values(dense.breaks, dense.at_breaks()[loops.places].T)
    if not np.isfinite(sizes).all():
        return None
    rank = count_significant(sizes)
    if rank == 0:
        return None
    if not (sizes[:, :rank].min(axis=0) < LOW * sizes[:, :rank].max(axis=0)).any():
        return None
    start = float(dense.breaks[0])
    branch = motion_branch(loops, start, dense(start))
    rank = min(rank, branch.speeds) or rank
    largest = float(sizes[:, rank - 1].max())
    return Passages(loops, dense, branch, rank, largest, sizes[:, rank - 1] / largest)


def _is_collapse(status: Status, breaks: Floats) -> bool:
    """Return whether steps became ever smaller, which a mere limit on their number does not say."""
    if status is not Status.TOO_MANY_STEPS or breaks.size < _TWO:
        return status in _COLLAPSES
    return bool(abs(breaks[-1] - breaks[-2]) < _SHORT * abs(breaks[-1] - breaks[0]))


# What a passage may be worse than the steps beside it.
_WORSE: Final = 1e3
_STEPS: Final = 5  # on either side
_OUTPUTS: Final = ("kinetic_energy", "potential_energy")


class PassageBalance(NamedTuple):
    """How T + V - W changes across a passage [J].

    Attributes
    ----------
    change : float
        Across the passage.
    usual : float
        In a step beside it, or by the tolerance of one, whichever is more.
    """

    change: float
    usual: float

    @property
    def holds(self) -> bool:
        """Whether the passage is no worse than what decides nothing."""
        return bool(self.change <= _WORSE * self.usual)


def passage_balance(
    problem: SimulationProblem, dense: DenseOutput, before: float, after: float, rtol: float
) -> PassageBalance:
    """Return how the balance of a motion changes between two times about a passage.

    Parameters
    ----------
    dense : DenseOutput
        The motion, the work behind its state.
    rtol : float
        Relative tolerance of a step: of the energies it may leave as much.
    """
    breaks, way = dense.breaks, 1.0 if dense.breaks[-1] >= dense.breaks[0] else -1.0
    first = breaks[way * (breaks - before) < 0.0][-_STEPS:]
    last = breaks[way * (breaks - after) > 0.0][:_STEPS]
    t = np.concatenate([first, [before, after], last])
    n_u, n = len(problem.eqs.speed_names), len(problem.eqs.state_names)
    x = dense(t)
    function = problem.compile_outputs(_OUTPUTS)
    kinetic, potential = problem.evaluate(function, t, x[n_u:n], x[:n_u])
    balance = kinetic + potential - x[-1]
    largest = max(float(np.abs(part).max()) for part in (kinetic, x[-1] - x[-1, 0], potential - potential[0]))
    rounding = EPSILON * float(np.abs(potential).max() + np.abs(x[-1]).max())
    changes = np.abs(np.diff(balance))
    usual = np.delete(changes, first.size).max(initial=rtol * largest + rounding)
    return PassageBalance(float(changes[first.size]), float(usual))


# Poses that a motion of fixed steps passes faster than its steps resolve. Beside a flat pose the least
# singular value of J goes to zero like the distance, and accelerations change as fast as its inverse. A
# method of order p is worth its order while the steps are short beside that distance.


Places = NDArray[np.int64]

# In so many steps a least singular value must not change by as much as itself: what a step of order 4 is off
# by goes with the fourth power of this.
_RESOLVING: Final = 4.0
# Places that are looked at first; around so many of the lowest ones every step is.
_PLACES: Final = 200
_LOWEST: Final = 8
# Singular values that stay below this share of the largest belong to constraints that follow from others.
_INDEPENDENT: Final = 1e-6
_NOTE: Final = (
    "near t = {:.6g} s some constraints are almost redundant, and steps of {:.3g} s are too long for how "
    "fast this changes: from there on the motion is much less accurate than the order of the method "
    "suggests; use shorter steps, or omit integrator="
)


def unresolved_pose_notes(problem: SimulationProblem, raw: RawRun, step: float) -> tuple[str, ...]:
    """Return a note where steps of a length [s] do not resolve how dependent the constraints are."""
    dense = raw.dense_output
    if dense is None or dense.breaks.size < 3:
        return ()
    t, loops = dense.breaks, LoopConstraints(problem)

    def singular_values(places: Places) -> Floats:
        return loops.singular_values(t[places], dense(t[places])[loops.places].T)

    coarse = np.arange(0, t.size, -(-t.size // _PLACES))
    values = singular_values(coarse)
    if not np.isfinite(values).all():
        return ()
    rank = int((np.median(values, axis=0) > _INDEPENDENT * values.max(initial=0.0)).sum())
    if rank == 0:
        return ()
    places = _low_places(coarse, values[:, rank - 1], t.size)
    least = [singular_values(some)[:, rank - 1] for some in places]
    unresolved = [some[are_unresolved(sizes)] for some, sizes in zip(places, least, strict=True)]
    times = sorted(float(t[some[0]]) for some in unresolved if some.size)
    return (_NOTE.format(times[0], step),) if times else ()


def _low_places(coarse: Places, least: Floats, count: int) -> list[Places]:
    """Return the steps' ends around the lowest values at some of them, where these may vanish between."""
    stride = int(coarse[1] - coarse[0])
    if stride == 1:
        return [coarse]
    low = coarse[are_unresolved(least)]
    lowest = low[np.argsort(least[low // stride], kind="stable")][:_LOWEST]
    return [np.arange(max(k - stride, 0), min(k + stride + 1, count)) for k in np.sort(lowest)]


def are_unresolved(least: Floats) -> NDArray[np.bool_]:
    """Return a mask of the steps' ends at which a singular value changes too fast for its size."""
    changes = np.abs(np.diff(least))
    beside = np.maximum(np.append(changes, 0.0), np.append(0.0, changes))
    return np.asarray(least < _RESOLVING * beside, dtype=np.bool_)
