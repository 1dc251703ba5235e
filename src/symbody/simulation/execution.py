"""`execute`: one smooth motion, from its record to its trajectory."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.events.events import EventSide, Occurrence
from symbody.simulation.methods.breakdowns import judge_friction, judge_pivots, pivot_events
from symbody.simulation.methods.closed_loops.change_point import integrate_on_branch
from symbody.simulation.methods.integration import Integration
from symbody.simulation.motion import Motion
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.results.checks import singular_passages, stop_note
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status

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
