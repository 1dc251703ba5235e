"""`drive`: a motion piece by piece, from one step of an FMU to the next.

At one instant, in this order: prescribed rates jump; events act; signals are sampled; FMUs take their
steps; gaps close with impacts; modes are decided: which joints stick, which gaps are closed. Explicit
methods do all but FMUs in the compiled loop, see `symbody.kernels.modes.switching_motion`; others end a piece
at each sample and, beside modes, at each jump, action and end of a mode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.solving.modal_equations import switches
from symbody.simulation.co_simulation.held_inputs import HeldInputs
from symbody.simulation.events.events import EventSide
from symbody.simulation.execution import MotionPiece, execute
from symbody.simulation.hybrid.impulsive_contacts import (
    ImpulsiveContacts,
    check_jumps,
    with_impulses,
)
from symbody.simulation.hybrid.rate_jumps import jump_notes, jump_times, neglect_note
from symbody.simulation.hybrid.switching import (
    DeadEndError,
    SwitchingModes,
    check_backwards,
    check_strike,
)
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.methods.closed_loops.change_point import samples_on_the_way
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.methods.integration import takes_steps_compiled
from symbody.simulation.methods.moreau_jean import MoreauJean
from symbody.simulation.motion import Motion
from symbody.simulation.pieces import MotionInstant, Pieces, one_state, work_at_end
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import INSTANT

Floats = NDArray[np.float64]

# So many changes of modes, or actions, at one instant are one too many.
_MOST_CHANGES: Final = 50
_MOST_NOTES: Final = 8  # of a motion with FMUs: each piece may have some


class PieceStart(NamedTuple):
    """A time [s] and state (u, q, s) between two pieces of a motion.

    Attributes
    ----------
    is_changed : bool
        Whether the state was changed there, so that modes before it do not matter.
    """

    t: float
    x: Floats
    is_changed: bool = False


class Driven(NamedTuple):
    """A motion, its problem with what FMUs computed as tables, and where the values of its events stand."""

    run: Trajectory
    problem: SimulationProblem
    sides: tuple[EventSide, ...]


def drive(motion: Motion, inputs: Mapping[str, object] | None = None) -> Driven:
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
    if isinstance(motion.integrator, MoreauJean):
        motion = with_impulses(motion)
    problem, span, x = motion.problem, motion.span, motion.state
    jumps = jump_times(motion.moving_problem, x, span)
    if jumps.times:
        motion = replace(motion, jumps=jumps)
    if motion.impulses is not None:
        check_jumps(jumps)
    fmus = {name: law for name, law in (inputs or {}).items() if isinstance(law, FmuInput)}
    sampler = None if problem.sampler is None or samples_on_the_way(motion) else problem.sampler
    has_modes = motion.impulses is None and switches(problem.eqs.formed)
    if not (has_modes or fmus) and sampler is None:  # the compiled loop does all that happens
        piece = execute(motion)
        run = with_jump_notes(piece.run, problem, piece.jumps)
        return Driven(with_impulse_notes(run, motion.impulses), problem, piece.sides)
    with ExitStack() as stack:
        held = HeldInputs(problem, fmus, span, x, stack, sampler)
        modes = SwitchingModes(held.problem) if has_modes else None
        return _MotionByPieces(motion, held, modes).go()


class _MotionByPieces:
    """A motion under way.

    Parameters
    ----------
    motion : Motion
        The whole of it.
    held : HeldInputs
        What is sampled between pieces.
    modes : SwitchingModes or None
        Decides which joints stick and which gaps are closed.
    """

    def __init__(self, motion: Motion, held: HeldInputs, modes: SwitchingModes | None) -> None:
        self._motion, self._held, self._modes = motion, held, modes
        self._pieces = Pieces(motion)
        self._integrator = motion.integrator
        self._decided = 0  # rows of the record of modes where the piece begins
        self._changes: list[float] = []
        if self._modes is not None:
            check_backwards(motion.span)
        if self._modes is not None and motion.jumps.times:
            check_strike(motion.problem.eqs.formed, motion.jumps.times[0])

    def go(self) -> Driven:
        """Return the whole motion."""
        try:
            run = self._march()
        except KeyboardInterrupt:  # between two pieces: what came before is kept
            if not self._pieces.runs:
                raise
            self._pieces.interrupt()
            run = self._whole()
        end = self._motion.span[1]
        return Driven(run, self._held.problem_of_record(end), self._pieces.sides)

    def _march(self) -> Trajectory:
        """Go from instant to instant until the motion ends."""
        motion = self._motion
        stage: PieceStart | None = PieceStart(motion.span[0], motion.state, is_changed=True)
        try:
            while stage is not None:
                x = self._settle(stage)
                until = self._next_instant(stage.t)
                stage = self._end_piece(*self._move(x, stage.t, until))
        except DeadEndError as end:
            return self._dead_end(end)
        return self._whole()

    def _settle(self, stage: PieceStart) -> Floats:
        """Take the samples that are due, and decide the modes; return the state with which a piece begins."""
        if self._held.is_due(stage.t):
            self._held.sample(stage.t, stage.x)
            if self._modes is not None:
                self._modes.use(self._held.problem)
        if self._modes is None:
            return stage.x
        if stage.is_changed:
            self._modes.forget()
        t, modes = stage.t, self._modes
        x, work, is_struck = modes.settle(t, stage.x)
        if is_struck:
            self._pieces.begin_behind(t, self._pieces.plan(modes.problem, stage.x, t, one_state(t)))
        self._pieces.add_energy(work)
        self._decided = modes.switch.recorded
        return x

    def _next_instant(self, t: float) -> MotionInstant:
        """Return when more happens than events."""
        end, due, jumps = self._motion.span[1], self._held.due, self._motion.jumps
        if not due < end - self._held.width:
            return MotionInstant("end", end, end)
        beside = [jump + jumps.margin for jump in jumps.times if jump > t and abs(jump - due) <= jumps.margin]
        return MotionInstant("sample", due, min(max([due, *beside]), end), self._held.width)

    def _move(self, x: Floats, t: float, until: MotionInstant) -> tuple[MotionPiece, MotionInstant]:
        """Add the piece from a state to an instant, or to what ends it before; return it and when it ends."""
        modes = self._modes
        problem = self._held.problem if modes is None else modes.problem
        piece = self._execute(problem, x, t, until)
        if piece.goes_on is not None and takes_steps_compiled(self._motion) and self._integrator is None:
            self._integrator = Stiff()  # which was chosen on the way: the loop itself goes on in other modes
        end = None if modes is None else self._end_of_shares(piece, modes)
        if end is not None:
            until = MotionInstant("modes", end, end)
            piece = self._execute(problem, x, t, until)
        self._pieces.add(piece)
        return piece, until

    def _execute(self, problem: SimulationProblem, x: Floats, t: float, until: MotionInstant) -> MotionPiece:
        """Return the piece from a state to an instant."""
        motion = self._pieces.plan(problem, x, t, until)
        return execute(replace(motion, modes=self._modes, integrator=self._integrator))

    def _end_of_shares(self, piece: MotionPiece, modes: SwitchingModes) -> float | None:
        """Return when joints no longer hold together in a piece whose modes are decided here [s]."""
        dense = piece.run.dense_output
        return None if dense is None or modes.switch.recorded != self._decided else modes.end_of_shares(dense)

    def _end_piece(self, piece: MotionPiece, until: MotionInstant) -> PieceStart | None:
        """Let happen what ends a piece; return the state with which the motion goes on, if it does."""
        run = piece.run
        if piece.goes_on is not None:
            t = piece.goes_on
            self._check_chatter(t)
            if piece.after is not None:
                return self._act(t, piece, piece.after)
            self._pieces.leave_out(t)
            return PieceStart(t, np.zeros(0) if run.dense_output is None else run.dense_output.at_end())
        if run.status is not Status.SUCCESS:
            return None
        x = np.zeros(0) if run.dense_output is None else run.dense_output.at_end()
        if piece.behind is not None:
            self._pieces.add_energy(float(piece.behind[-1]) - work_at_end(run))
            x = piece.behind[:-1]
        if piece.reached < until.end:  # just behind a jump
            self._pieces.leave_out(piece.reached, is_replaced=True)
            return PieceStart(piece.reached, x, is_changed=True)
        if until.happens == "end":
            self._held.sample_signals(until.at, x)
            return None
        if until.happens == "modes":
            self._check_chatter(until.at)
        else:
            self._report(until.at)
        return PieceStart(until.end, x)

    def _act(self, t: float, piece: MotionPiece, after: Floats) -> PieceStart:
        """Go on from a state that actions set."""
        self._pieces.add_energy(float(after[-1] - piece.run.stored["work"][-1]))
        self._pieces.leave_out(t, is_replaced=True)
        if self._modes is not None:
            self._modes.check_gaps(t, after[:-1], piece.happened[-1].name)
        return PieceStart(t, after[:-1], is_changed=True)

    def _check_chatter(self, t: float) -> None:
        """End a motion in which modes change, or events act, again and again within an instant.

        Raises
        ------
        DeadEndError
            See above.
        """
        start, end = self._motion.span
        self._changes.append(t)
        recent = self._changes[-_MOST_CHANGES:]
        if len(self._changes) > _MOST_CHANGES and t - recent[0] < INSTANT * (end - start):
            raise DeadEndError(t, Status.CHATTERING, "modes change again and again")

    def _report(self, t: float) -> None:
        """Report how far the motion is at a sample: pieces are too short for reports of their own.

        Raises
        ------
        KeyboardInterrupt
            If the motion is to end.
        """
        motion = self._motion
        start, end = motion.span
        if motion.progress is not None and motion.progress((t - start) / (end - start)) is False:
            raise KeyboardInterrupt

    def _dead_end(self, end: DeadEndError) -> Trajectory:
        """Return the motion up to a state in which it cannot go on."""
        if not self._pieces.runs:
            motion = self._motion
            t, problem = motion.span[0], self._held.problem
            start = one_state(t)
            problem = problem if self._modes is None else self._modes.problem
            self._pieces.add(execute(self._pieces.plan(problem, motion.state, t, start)))
        run = self._whole()
        return replace(run, status=end.status, notes=(*run.notes, f"at t = {end.t:.9g} s {end.why}"))

    def _whole(self) -> Trajectory:
        """Return the motion so far."""
        problem = self._motion.problem
        run = self._pieces.trajectory()
        notes = run.notes
        if np.isfinite(self._held.due) and len(notes) > _MOST_NOTES:
            notes = (*notes[:_MOST_NOTES], f"{len(notes) - _MOST_NOTES} more notes on values between samples")
        run = with_jump_notes(replace(run, notes=notes), problem, self._pieces.jumps)
        run = with_impulse_notes(run, self._motion.impulses)
        return run if self._modes is None else self._with_modes(run, self._modes)

    def _with_modes(self, run: Trajectory, modes: SwitchingModes) -> Trajectory:
        """Return a motion with the changes of modes among its events."""
        record = modes.record
        events = sorted((*run.events, *record.occurrences), key=lambda event: event.t)
        return replace(
            run,
            events=tuple(events),
            notes=(*run.notes, *record.notes),
            modes=record.changes,
            mode_inputs=record.inputs,
        )


def with_jump_notes(
    run: Trajectory, problem: SimulationProblem, jumps: Sequence[tuple[float, float]]
) -> Trajectory:
    """Return a motion with notes on when prescribed rates have changed speeds, and on the energy."""
    if not jumps:
        return run
    return replace(run, notes=(*run.notes, *jump_notes(jumps), *neglect_note(problem.eqs.formed)))


def with_impulse_notes(run: Trajectory, impulses: ImpulsiveContacts | None) -> Trajectory:
    """Return a motion with notes on the impulses in it."""
    return run if impulses is None else replace(run, notes=(*run.notes, *impulses.notes))
