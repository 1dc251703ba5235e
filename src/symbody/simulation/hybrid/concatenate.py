"""Trajectories one after the other as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Occurrence
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.evaluate import Evaluate, EvaluateTogether
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import Evaluator
from symbody.simulation.status import Status

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Piecewise:
    """Computes outputs by the equations that hold at each time.

    Attributes
    ----------
    starts : (parts,) array
        When each part begins [s].
    parts : tuple of callable
        What computes in each.
    work : (parts,) array
        Done before each [J].
    modes : tuple of modes
        Of each part, empty where the equations stay the same; see `hybrid.modes`.
    """

    starts: Floats
    parts: tuple[Evaluate, ...]
    work: Floats
    modes: tuple[tuple[int, ...], ...] = ()

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        found: tuple[str, ...] = getattr(self.parts[0], "wrapped_angles", ()) if self.parts else ()
        return found

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        """Return the output with time last; of two samples at a change the first belongs to the part before.

        Raises
        ------
        UsageError
            If the parts do not have the same number of values, as multipliers.
        """
        return self.together((name,), t, q, u)[0]

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, by one function a part; see `__call__`."""
        way = -1.0 if self.starts[-1] < self.starts[0] else 1.0
        starts, along = way * self.starts, way * t
        place = np.maximum(np.searchsorted(starts, along, side="right") - 1, 0)
        before = np.flatnonzero((t[:-1] == t[1:]) & np.isin(t[:-1], self.starts[1:]))
        place[before] = np.maximum(np.searchsorted(starts, along[before], side="left") - 1, 0)
        whole: dict[str, Floats] = {}
        for k in np.unique(place):
            inside = place == k
            computed = _outputs(self.parts[k], names, t[inside], q[:, inside], u[:, inside])
            for name, values in zip(names, computed, strict=True):
                shape = values.shape[:-1]
                array = whole.setdefault(name, np.empty((*shape, t.size)))
                if array.shape[:-1] != shape:
                    raise changing_shape(name)
                array[..., inside] = values + self.work[k] if name == "work" else values
        return [whole.get(name, np.empty((0,))) for name in names]


def _outputs(part: Evaluate, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
    if isinstance(part, EvaluateTogether):
        return part.together(names, t, q, u)
    return [part(name, t, q, u) for name in names]


def concatenate(
    parts: Sequence[Trajectory],
    events: Sequence[Occurrence],
    jumps: Mapping[int, float],
    modes: Sequence[tuple[int, ...]] = (),
) -> Trajectory:
    """Return parts of one motion, each starting where the one before ends, with the verdict of the last.

    Parameters
    ----------
    jumps : mapping of place to float
        By how much the energy jumps before a part [J]: that counts as work.
    modes : sequence of modes
        Of each part.
    """
    last = parts[-1]
    done = [jumps.get(0, 0.0)]
    for k, part in enumerate(parts[:-1], start=1):
        done.append(done[-1] + _work_at_end(part) + jumps.get(k, 0.0))
    works = [part.stored["work"] + before for part, before in zip(parts, done, strict=True)]
    evaluate = [part.evaluate for part in parts if part.evaluate is not None]
    starts = np.array([part.dense_output.breaks[0] if part.dense_output else part.t[0] for part in parts])
    return replace(
        last,
        t=np.concatenate([part.t for part in parts]),
        q=np.concatenate([part.q for part in parts], axis=1),
        s=np.concatenate([part.s for part in parts], axis=1),
        u=np.concatenate([part.u for part in parts], axis=1),
        statistics=_total([part.statistics for part in parts]),
        evaluate=Piecewise(starts, tuple(evaluate), np.array(done), tuple(modes)),
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


def _work_at_end(part: Trajectory) -> float:
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
    return Statistics(
        sum(s.accepted for s in spent),
        sum(rejected) if len(rejected) == len(spent) else None,
        sum(s.evaluations for s in spent),
        sum(s.loop_seconds for s in spent),
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


def changing_shape(name: str) -> UsageError:
    """Return the error for an output whose number of values changes with the equations."""
    return UsageError(
        Problem("trajectory.changing_shape", repr(name), f"the number of values of {name} changes during "
            f"the motion",
                "joints that stick and ropes that are taut add constraints",
                "read single values, or a reaction")
    )  # fmt: skip
