"""`Pieces`: a motion piece by piece, and the one trajectory that they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.events.events import EventSide, Occurrence
from symbody.simulation.execution import MotionPiece, execute
from symbody.simulation.motion import Motion
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.evaluate import OutputEvaluator, Piecewise
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]


class MotionInstant(NamedTuple):
    """When more than smooth motion happens.

    Attributes
    ----------
    happens : str
        "sample", "modes" or "end"; "start" where a piece is one state, which is a sample.
    at : float
        The time [s].
    end : float
        Where the motion before it ends [s]: behind a jump of rates at the same time.
    width : float
        Times so much before it are the same time [s].
    """

    happens: str
    at: float
    end: float
    width: float = 0.0


def one_state(t: float) -> MotionInstant:
    """Return the end of a piece that is one state."""
    return MotionInstant("start", t, t)


class Pieces:
    """The pieces of a motion so far.

    Parameters
    ----------
    motion : Motion
        The whole of it.

    Attributes
    ----------
    runs : list of Trajectory
        Each starts where the one before ends.
    occurrences : list of Occurrence
        What happened.
    jumps : list of (float, float)
        When prescribed rates have changed speeds [s], and by how much the energy [J].
    sides : tuple of EventSide
        Where the values of the motion's events stand at the end.
    """

    def __init__(self, motion: Motion) -> None:
        self.runs: list[Trajectory] = []
        self.occurrences: list[Occurrence] = []
        self.sides: tuple[EventSide, ...] = motion.sides
        self._motion = motion
        self._changes: dict[int, float] = {}
        self._stored = 0  # of the samples asked for
        self._steps = 0
        self._width = 0.0
        self.jumps: list[tuple[float, float]] = []

    def plan(
        self, problem: SimulationProblem, x: Floats, t: float, end: MotionInstant
    ) -> Motion:  # fmt: skip
        """Return the motion of the next piece, with its equations."""
        whole = self._motion
        span = t, end.end
        self._width = max(self._width, end.width, abs(end.end - end.at))
        part = whole.part(x, span, self._times(span, end), self._steps, problem)
        if end.happens == "start":  # nothing happens in one state
            return replace(part, problem=replace(problem, sampler=None), events=())
        return replace(part, sides=self.sides)

    def _times(self, span: tuple[float, float], end: MotionInstant) -> Floats | None:
        """Return the samples of a piece; one at an instant belongs to the piece at later times."""
        whole = self._motion
        if whole.times is None or end.happens == "start":
            return None
        times, last = np.asarray(whole.times), None
        if end.happens != "end":
            last = int(np.count_nonzero(times < end.at - end.width))
        clipped: Floats = np.clip(times[self._stored : last], min(span), max(span))
        return clipped

    def add(self, piece: MotionPiece) -> None:
        """Add a piece."""
        run = piece.run
        self.runs.append(run)
        self.jumps.extend(piece.jumps)
        self.occurrences.extend(run.events)
        self._stored += run.t.size
        self._steps += run.statistics.accepted + (run.statistics.rejected or 0)
        if len(self.runs) == 1 or _length(run) or piece.happened:
            self.sides = piece.sides[: len(self._motion.events)]

    def leave_out(self, t: float, *, is_replaced: bool = False) -> None:
        """Leave out the last sample of the last piece if it is at a time at which the motion was cut.

        Of samples asked for it stays, unless the state behind `is_replaced`: then it is the one behind.
        """
        times, run = self._motion.times, self.runs[-1]
        if times is None or not run.t.size or run.t[-1] != t:
            return
        is_asked = self._stored <= np.size(times) and run.t[-1] in np.asarray(times)
        if is_asked and not is_replaced:
            return
        stored = {name: values[..., :-1] for name, values in run.stored.items()}
        self.runs[-1] = replace(
            run, t=run.t[:-1], q=run.q[:, :-1], u=run.u[:, :-1], s=run.s[:, :-1], stored=stored
        )
        self._stored -= 1

    def begin_behind(self, t: float, first: Motion) -> None:
        """Let the next piece begin in another state than the last one ended: both are samples.

        Of samples asked for it is the one behind; `first` is a motion that is the state before.
        """
        if self.runs:
            self.leave_out(t, is_replaced=True)
        elif self._motion.times is None:
            self.add(execute(first))

    def add_energy(self, change: float) -> None:
        """Count what the energy jumps by before the next piece [J] as work."""
        place = len(self.runs)
        self._changes[place] = self._changes.get(place, 0.0) + change

    def interrupt(self) -> None:
        """End the motion where it is."""
        self.runs[-1] = replace(self.runs[-1], status=Status.INTERRUPTED)

    def trajectory(self) -> Trajectory:
        """Return the whole motion, with the verdict of its last piece."""
        run = concatenate(self.runs, self.occurrences, self._changes)
        if self._motion.times is not None:
            run = at_times_asked(run, np.asarray(self._motion.times), self._width)
        return run


def _length(run: Trajectory) -> float:
    """Return how long a piece lasts [s]."""
    dense = run.dense_output
    return 0.0 if dense is None else abs(float(dense.breaks[-1] - dense.breaks[0]))


def concatenate(
    parts: Sequence[Trajectory],
    events: Sequence[Occurrence],
    jumps: Mapping[int, float],
) -> Trajectory:
    """Return parts of one motion, each starting where the one before ends, with the verdict of the last.

    Parameters
    ----------
    jumps : mapping of place to float
        By how much the energy jumps before a part [J]: that counts as work.
    """
    last = parts[-1]
    done = [jumps.get(0, 0.0)]
    for k, part in enumerate(parts[:-1], start=1):
        done.append(done[-1] + work_at_end(part) + jumps.get(k, 0.0))
    works = [part.stored["work"] + before for part, before in zip(parts, done, strict=True)]
    evaluate = [part.evaluate for part in parts if isinstance(part.evaluate, OutputEvaluator)]
    starts = np.array([part.dense_output.breaks[0] if part.dense_output else part.t[0] for part in parts])
    return replace(
        last,
        t=np.concatenate([part.t for part in parts]),
        q=np.concatenate([part.q for part in parts], axis=1),
        s=np.concatenate([part.s for part in parts], axis=1),
        u=np.concatenate([part.u for part in parts], axis=1),
        statistics=_total([part.statistics for part in parts]),
        evaluate=Piecewise(starts, tuple(evaluate), np.array(done)),
        dense_output=_dense([part.dense_output for part in parts]),
        stored={"work": np.concatenate(works)},
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        events=tuple(events),
    )


def at_times_asked(run: Trajectory, times: Floats, width: float) -> Trajectory:
    """Return a motion with samples at the times asked for, where these are as near as `width`.

    The last one of a motion that was stopped is its end.
    """
    t, count = run.t.copy(), min(run.t.size - (run.status is Status.STOPPED), times.size)
    near = np.abs(t[:count] - times[:count]) <= width
    t[:count][near] = times[:count][near]
    return replace(run, t=t)


def work_at_end(part: Trajectory) -> float:
    """Return the work done until a part ends [J]."""
    if part.dense_output is None:
        return 0.0
    end = part.dense_output.breaks[-1:]
    if part.t.size and part.t[-1] == end[0]:
        return float(part.stored["work"][-1])
    if isinstance(part.evaluate, Evaluator) and part.evaluate.work is not None:
        return float(part.evaluate.work.at_end()[0])
    return float(part.at(end)["work"][0])


def _total(spent: Sequence[Statistics]) -> Statistics:
    rejected = [s.rejected for s in spent if s.rejected is not None]
    residuals = [s.residual for s in spent if s.residual is not None]
    return Statistics(
        sum(s.accepted for s in spent),
        sum(rejected) if len(rejected) == len(spent) else None,
        sum(s.evaluations for s in spent),
        sum(s.loop_seconds for s in spent),
        max(residuals, default=None),
    )


def _dense(parts: Sequence[DenseOutput | None]) -> DenseOutput | None:
    """Return the motion of all steps; parts that take no time are left out, but for the last one."""
    known = [part for part in parts if part is not None and part.breaks[0] != part.breaks[-1]]
    last = parts[-1]
    if not known:
        return last
    if last is not None and last is not known[-1]:
        known.append(last)
    rows = max(part.pieces.shape[1] for part in known)
    pieces = [np.pad(part.pieces, ((0, 0), (0, rows - part.pieces.shape[1]), (0, 0))) for part in known]
    breaks = [known[0].breaks[:1], *(part.breaks[1:] for part in known)]
    return DenseOutput(np.concatenate(breaks), np.concatenate(pieces))
