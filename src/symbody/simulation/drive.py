"""`drive`: a motion piece by piece, from one instant at which more than smooth motion happens to the next.

At one instant, in this order: prescribed rates jump; events act; signals are sampled; FMUs take their
steps; ropes strike; and modes are decided: which joints stick and which ropes are taut. Events and samples
that leave the equations as they are happen inside of a piece, in the compiled loop.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.co_simulation.held_inputs import HeldInputs
from symbody.simulation.events.event_watch import chattering_note
from symbody.simulation.events.events import EventSide
from symbody.simulation.execution import MotionPiece, execute
from symbody.simulation.hybrid.rate_jumps import (
    jump_notes,
    jump_times,
    neglect_note,
    no_speeds,
    strikes,
    torn_constraint,
)
from symbody.simulation.hybrid.switching import (
    DeadEndError,
    PieceStart,
    SwitchingModes,
    check_backwards,
    check_strike,
    switches,
)
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.methods.closed_loops.change_point import samples_on_the_way
from symbody.simulation.methods.integration import MotionPlan
from symbody.simulation.native.strikes import Strike
from symbody.simulation.pieces import MotionInstant, Pieces
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import INSTANT

Floats = NDArray[np.float64]

# So many changes of modes, or actions, at one instant are one too many.
_MOST_CHANGES: Final = 50
_MOST_NOTES: Final = 8  # of a motion with FMUs: each piece may have some


class Driven(NamedTuple):
    """A motion, its problem with what FMUs computed as tables, and where the values of its events stand."""

    run: Trajectory
    problem: SimulationProblem
    sides: tuple[EventSide, ...]


def drive(plan: MotionPlan, inputs: Mapping[str, object] | None = None) -> Driven:
    """Return a motion with all that happens on its way.

    Parameters
    ----------
    inputs : mapping of str to law
        Of these, FMUs are asked at their samples.

    Raises
    ------
    UsageError
        If what happens does not fit together, or an FMU cannot be used.
    SimulationError
        If an FMU or a law fails, or no speeds fit rates that jump.
    """
    integration = plan.integration
    problem, span, x = integration.problem, integration.span, integration.state
    fmus = {name: law for name, law in (inputs or {}).items() if isinstance(law, FmuInput)}
    sampler = None if problem.sampler is None or samples_on_the_way(plan) else problem.sampler
    with ExitStack() as stack:
        held = HeldInputs(problem, fmus, span, x, stack, sampler)
        motion = _MotionByPieces(plan, held)
        if not motion.has_instants:
            piece = execute(plan)
            return Driven(piece.run, problem, piece.sides)
        return motion.go()


class _MotionByPieces:
    """A motion under way.

    Parameters
    ----------
    plan : MotionPlan
        Of the whole motion.
    held : HeldInputs
        What is sampled between pieces.
    """

    def __init__(self, plan: MotionPlan, held: HeldInputs) -> None:
        integration = plan.integration
        problem, span = integration.problem, integration.span
        self._plan, self._held = plan, held
        self._pieces = Pieces(plan)
        self._times, margin = jump_times(problem, integration.state, span)
        self._way = 1.0 if span[1] >= span[0] else -1.0
        self._step = self._way * margin
        self._jumped: list[tuple[float, float]] = []  # jumps that changed a speed: when, and the energy
        self._passed = 0  # of the jumps
        self._modes = SwitchingModes(held.problem, self._pieces) if switches(problem.eqs.formed) else None
        self._acts = any(event.mapping for event in integration.events)
        self._changes: list[float] = []
        if self._modes is not None:
            check_backwards(span)
        if self._modes is not None and self._times:
            check_strike(problem.eqs.formed, self._times[0])

    @property
    def has_instants(self) -> bool:
        """Whether anything happens that the compiled loop does not do."""
        return bool(self._times) or self._modes is not None or np.isfinite(self._held.due)

    def go(self) -> Driven:
        """Return the whole motion."""
        try:
            run = self._march()
        except KeyboardInterrupt:  # between two pieces: what came before is kept
            if not self._pieces.runs:
                raise
            self._pieces.interrupt()
            run = self._whole()
        end = self._plan.integration.span[1]
        return Driven(run, self._held.problem_of_record(end), self._pieces.sides)

    def _march(self) -> Trajectory:
        """Go from instant to instant until the motion ends."""
        integration = self._plan.integration
        stage: PieceStart | None = PieceStart(integration.span[0], integration.state, {})
        try:
            while stage is not None:
                x = self._settle(stage)
                until = self._next_instant(stage.t)
                stage = self._end_piece(self._move(x, stage.t, until), until)
        except DeadEndError as end:
            return self._dead_end(end)
        return self._whole()

    def _settle(self, stage: PieceStart) -> Floats:
        """Take the samples that are due, and decide the modes; return the state with which a piece begins."""
        if self._held.is_due(stage.t):
            self._held.sample(stage.t, stage.x)
            if self._modes is not None:
                self._modes.use(self._held.problem)
        return stage.x if self._modes is None else self._modes.settle(stage)

    def _next_instant(self, t: float) -> MotionInstant:
        """Return when more happens than events."""
        end, way = self._plan.integration.span[1], self._way
        if way * (end - t) <= 0.0:  # behind a jump at the end
            return MotionInstant("end", t, t, t)
        found = MotionInstant("end", end, end, end)
        due = self._held.due
        if due < end - self._held.width:
            found = MotionInstant("sample", due, due, due, self._held.width)
        if self._passed < len(self._times):
            jump, step = self._times[self._passed], self._step
            before = max(jump - step, t, key=lambda time: way * time)
            if way * before <= way * found.at:
                behind = min(jump + step, end, key=lambda time: way * time)
                found = MotionInstant("jump", jump, before, behind)
        return found

    def _move(self, x: Floats, t: float, until: MotionInstant) -> MotionPiece:
        """Add the piece from a state to an instant, or to what ends it before."""
        modes = self._modes
        if modes is None:
            piece = execute(self._pieces.plan(self._held.problem, x, t, until))
            self._pieces.add(piece, until)
            return piece
        free = modes.free if self._acts else None
        piece = execute(self._pieces.plan(modes.problem, x, t, until, modes.ends, free))
        labels = {event.label for event in modes.ends}
        events = tuple(event for event in piece.run.events if event.name not in labels)
        modes.note_speeds(piece.run)
        self._pieces.add(piece._replace(run=replace(piece.run, events=events)), until, modes.modes)
        return piece

    def _end_piece(self, piece: MotionPiece, until: MotionInstant) -> PieceStart | None:
        """Let happen what ends a piece; return the state with which the motion goes on, if it does."""
        run, modes = piece.run, self._modes
        stops = {event.label for event in self._plan.integration.events if event.action == "stop"}
        if modes is not None and run.status is Status.STOPPED and piece.happened[-1].name not in stops:
            stage = modes.state_behind(piece)
            if piece.after is not None:
                stage = self._act(piece, piece.after)
            else:
                self._pieces.leave_out(piece.happened[-1].t)
            self._check_chatter(piece)
            return stage
        if run.status is not Status.SUCCESS:
            return None
        x = np.zeros(0) if run.dense_output is None else run.dense_output.at_end()
        if until.happens == "end":
            self._held.sample_signals(until.at, x)
            return None
        if until.happens == "jump":
            self._passed += 1
            return PieceStart(until.behind, self._jump(x, until), {})
        self._report(until.at)
        return PieceStart(until.behind, x)

    def _act(self, piece: MotionPiece, after: Floats) -> PieceStart:
        """Go on from a state that actions set."""
        t = piece.happened[-1].t
        self._pieces.add_energy(float(after[-1] - piece.run.stored["work"][-1]))
        self._pieces.leave_out(t, is_replaced=True)
        if self._modes is not None:
            self._modes.check_ropes(t, after[:-1], piece.happened[-1].name)
        return PieceStart(t, after[:-1], {})

    def _check_chatter(self, piece: MotionPiece) -> None:
        """End a motion in which modes change, or events act, again and again within an instant.

        Raises
        ------
        DeadEndError
            See above.
        """
        start, end = self._plan.integration.span
        last = piece.happened[-1]
        self._changes.append(last.t)
        recent = self._changes[-_MOST_CHANGES:]
        if len(self._changes) > _MOST_CHANGES and last.t - recent[0] < INSTANT * (end - start):
            raise DeadEndError(last.t, Status.CHATTERING, chattering_note(last.name, goes_on=False))

    def _jump(self, x: Floats, until: MotionInstant) -> Floats:
        """Return the state behind a jump of prescribed rates."""
        problem, behind, strike = self._held.problem, until.behind, Strike(self._held.problem)
        momenta = strike.find_momenta(until.before, behind, x)
        if momenta is None:
            raise torn_constraint(problem.eqs, strike.block.torn - 1, behind)
        moved = x
        if problem.eqs.speed_names:
            found = self._speeds_behind(strike, behind, x, momenta)
            if found is None:
                raise no_speeds(behind)
            moved = found
        gained = strike.energy_gained(behind, moved)
        self._pieces.add_energy(gained)
        if strikes(problem, moved - x):
            self._jumped.append((until.at, gained))
        return moved

    def _speeds_behind(self, strike: Strike, t: float, x: Floats, momenta: Floats) -> Floats | None:
        """Return the state behind a jump of the momenta that prescribed rates give; None if there is none."""
        if self._modes is not None:
            found = self._modes.strike(t, x, momenta)
            return None if found is None else found.x
        moved = x.copy()
        return moved if strike.change_speeds(moved) else None

    def _report(self, t: float) -> None:
        """Report how far the motion is at a sample: pieces are too short for reports of their own.

        Raises
        ------
        KeyboardInterrupt
            If the motion is to end.
        """
        integration = self._plan.integration
        start, end = integration.span
        if integration.progress is not None and integration.progress((t - start) / (end - start)) is False:
            raise KeyboardInterrupt

    def _dead_end(self, end: DeadEndError) -> Trajectory:
        """Return the motion up to a state in which it cannot go on."""
        if not self._pieces.runs:
            integration = self._plan.integration
            t, problem = integration.span[0], self._held.problem
            start = MotionInstant("start", t, t, t)
            self._pieces.add(execute(self._pieces.plan(problem, integration.state, t, start)), start)
        run = self._whole()
        return replace(run, status=end.status, notes=(*run.notes, f"at t = {end.t:.9g} s {end.why}"))

    def _whole(self) -> Trajectory:
        """Return the motion so far."""
        problem = self._plan.integration.problem
        run = self._pieces.trajectory()
        notes = run.notes
        if np.isfinite(self._held.due) and len(notes) > _MOST_NOTES:
            notes = (*notes[:_MOST_NOTES], f"{len(notes) - _MOST_NOTES} more notes on values between samples")
        impacts = () if self._modes is None else self._modes.notes
        jumps = (*jump_notes(self._jumped), *neglect_note(problem.eqs.formed)) if self._jumped else ()
        return replace(run, notes=(*notes, *jumps, *impacts))
