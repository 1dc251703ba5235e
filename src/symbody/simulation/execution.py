"""`execute`: one smooth motion, from its record to its trajectory."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.velocities import CURE, pivot_groups
from symbody.simulation.events.events import Event, EventSide, LevelEvent, Occurrence
from symbody.simulation.methods.closed_loops.change_point import integrate_on_branch
from symbody.simulation.methods.integration import Integration
from symbody.simulation.motion import Motion
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.results.checks import singular_passages, stop_note
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import UNSOLVED

Floats = NDArray[np.float64]


class MotionPiece(NamedTuple):
    """A smooth motion, and what one that goes on has to know of it.

    Attributes
    ----------
    happened : tuple of Occurrence
        The events in its order.
    sides : tuple of EventSide
        Where the values of all events stand at its end.
    after : (n + 1,) array or None
        The state (u, q, s, work) that actions set at its end, if they are to be followed outside.
    goes_on : float or None
        When modes are to be decided outside for the motion to go on [s].
    behind : (n + 1,) array or None
        The state that actions set at the very end of a motion that goes on by itself.
    jumps : tuple
        When prescribed rates have changed speeds [s], and by how much the energy [J].
    reached : float
        When it ends [s].
    """

    run: Trajectory
    happened: tuple[Occurrence, ...] = ()
    sides: tuple[EventSide, ...] = ()
    after: Floats | None = None
    goes_on: float | None = None
    behind: Floats | None = None
    jumps: tuple[tuple[float, float], ...] = ()
    reached: float = math.nan


def execute(motion: Motion) -> MotionPiece:
    """Return the motion of equations that stay the same."""
    problem = motion.problem
    has_pivots = problem.eqs.formed.elimination is not None
    pivots = pivot_events(problem, motion.span[0], motion.state) if has_pivots else ()
    if pivots:
        motion = replace(motion, events=(*motion.events, *pivots))
    run = integrate_on_branch(motion)
    if pivots or not run.raw.status.success:
        run = judge_pivots(judge_friction(problem, run), pivots)
    watch, trajectory, reached = run.watch, _trajectory(problem, run), run.raw.reached
    if watch is None:
        return MotionPiece(trajectory, jumps=run.raw.jumps, reached=reached)
    after = watch.acted_state
    goes_on = watch.last_time if after is not None or watch.has_ended_mode else None
    goes_on = goes_on if run.raw.status is Status.STOPPED else None
    behind = watch.state_behind(reached) if run.raw.status is Status.SUCCESS else None
    return MotionPiece(
        trajectory, watch.occurrences, watch.sides_at(reached), after, goes_on, behind, run.raw.jumps, reached
    )


def _trajectory(problem: SimulationProblem, run: Integration) -> Trajectory:
    """Return the run with its names."""
    eqs, raw = problem.eqs, run.raw
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    n_q = len(eqs.coordinate_names)
    states, work = _split_work(raw.dense_output, n)
    passages = [] if states is None else list(singular_passages(eqs, states))
    ending = "" if run.watch is None else run.watch.ending
    if ending:
        stop = f"{raw.reach}; there {ending}"
    else:
        stop = "" if raw.status.success else stop_note(problem, raw)
    occurrences = () if run.watch is None else run.watch.occurrences
    watched = () if run.watch is None else run.watch.notes
    return Trajectory(
        t=raw.t,
        q=raw.x[n_u : n_u + n_q],
        u=raw.x[:n_u],
        coordinate_names=eqs.coordinate_names,
        speed_names=eqs.speed_names,
        s=raw.x[n_u + n_q : n],
        signal_state_names=eqs.signal_state_names,
        status=raw.status,
        statistics=raw.statistics,
        evaluate=Evaluator(problem, work),
        dense_output=states,
        stored={"work": raw.x[-1]},
        units=eqs.units,
        notes=(*run.notes, *watched, *(note for _, note in passages), *((stop,) if stop else ())),
        name=eqs.model.name,
        events=(*occurrences, *(event for event, _ in passages)),
    )


def _split_work(dense: DenseOutput | None, n: int) -> tuple[DenseOutput | None, DenseOutput | None]:
    """Return the dense output of the first `n` states, and of the others."""
    if dense is None:
        return None, None
    first, others = dense.pieces[:, :, :n], dense.pieces[:, :, n:]
    return DenseOutput(dense.breaks, first), DenseOutput(dense.breaks, others)


# Why a smooth motion ended where the mechanism leaves its accelerations or speeds open: friction and the
# reaction it comes from may have no solution, or two (Painleve); speeds that were eliminated may cease to
# follow.


# Errors of the independent speeds come back divided by the pivot: three digits are given away, no more.
_NEAR: Final = 1e-3
_SHARE: Final = 0.1  # of the first pivot, where that is small already
_LABEL: Final = "dependent speeds "
# Steps end where accelerations grow like 1 / margin; what is left there is far less, elsewhere far more.
_LEAST_MARGIN: Final = 1e-3
_BROKEN: Final = frozenset({Status.NOT_FINITE, Status.STEP_COLLAPSE, Status.SINGULAR, Status.TOO_MANY_STEPS})


def pivot_events(problem: SimulationProblem, t: float, x: Floats) -> tuple[Event, ...]:
    """Return what ends a motion from a state x = (u, q) before a pivot vanishes, on either side of zero."""
    groups = pivot_groups(problem.eqs)
    if not groups:
        return ()
    n_u = len(problem.eqs.speed_names)
    state = np.array([t]), x[n_u:, np.newaxis], x[:n_u, np.newaxis]
    pivots = problem.evaluate(problem.compile_outputs([f"{names[0]}_pivot" for names in groups]), *state)
    events = []
    for names, value in zip(groups, np.ravel(pivots), strict=True):
        limit = min(_NEAR, _SHARE * abs(float(value)))
        for sign in "-+":
            level = limit if sign == "-" else -limit
            label = f"{_LABEL}{', '.join(names)} {sign}"
            events.append(LevelEvent(f"{names[0]}_pivot", 0, "stop", label, level))
    return tuple(events)


def judge_pivots(run: Integration, events: tuple[Event, ...]) -> Integration:
    """Return a run with the verdict that one of the `pivot_events` ended it, if one did, and a note."""
    watch = run.watch
    last = watch.occurrences[-1] if watch is not None and watch.occurrences else None
    if watch is None or last is None or run.raw.status is not Status.STOPPED:
        return run
    if last.name not in {event.label for event in events}:
        return run
    watch.forget_last()
    names = last.name.removeprefix(_LABEL).rpartition(" ")[0]
    return _blame(
        run,
        Status.DEPENDENT_SPEEDS,
        f"at t = {last.t:.9g} s the dependent speeds {names} are hardly determined by the others any "
        f"longer; {CURE}",
    )


def judge_friction(problem: SimulationProblem, run: Integration) -> Integration:
    """Return a run with the verdict that friction is to blame, if it is, and a note that names the joint."""
    raw = run.raw
    friction = problem.eqs.formed.friction
    if raw.status not in _BROKEN or not friction:
        return run
    n_u, n = len(problem.eqs.speed_names), len(problem.eqs.state_names)
    x = raw.x[:, -1] if raw.dense_output is None else raw.dense_output(raw.reached)
    t = np.array([raw.reached])
    state = t, x[n_u:n, np.newaxis], x[:n_u, np.newaxis]
    margins = np.nan_to_num(problem.evaluate(problem.compile_outputs("friction_margin"), *state)[0], nan=-1.0)
    residuals = problem.evaluate(problem.compile_outputs("friction_residual"), *state)[0]
    unsolved = np.nan_to_num(residuals, nan=1.0) > UNSOLVED
    if margins.min() > _LEAST_MARGIN and not unsolved.any():
        return run
    k = int(margins.argmin() if margins.min() <= _LEAST_MARGIN else residuals.argmax())
    joint = friction[k].owner
    note = (
        f"at t = {raw.reached:.9g} s friction in joint {joint} increases its own normal force without "
        f"bound: the reaction is undetermined (margin {margins[k]:.3g})"
    )
    return _blame(run, Status.FRICTION, note)


def _blame(run: Integration, status: Status, note: str) -> Integration:
    """Return a run with another verdict and a note."""
    raw = replace(run.raw, status=status, state=None, kernel=None)
    return run._replace(raw=raw, notes=(*run.notes, note))
