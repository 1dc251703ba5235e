"""Minimal coordinates by partition: `Partition` integrates independent ones, the others follow from Phi.

Wehage and Haug, Generalized coordinate partitioning for dimension reduction in analysis of constrained
dynamic systems, J. Mech. Design 104 (1982). The independent ones are integrated by SciPy's DOP853. It carries
the others along: to choose the step by them too, which alone do it where all motion is prescribed, and to
start Newton's method from them, so that it stays on the branch of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.errors import Problem, SimulationError, UsageError
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.methods.closed_loops.partition_states import PartitionStates
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.implicit.sundials import MonitoredFunction
from symbody.simulation.methods.stepping import NODES, SHARES, Failure, Step, march
from symbody.simulation.motion import Motion
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

NOTE: Final = "independent coordinates are integrated by SciPy's DOP853 in Python: slower than Projection"
_OPEN: Final = (
    "the start is a change point, where the mechanism can move along several branches, and the velocities "
    "do not select one: start slightly away from it, or give other velocities"
)
# A step of so few roundings of the time: near a lock-up what is solved for is rounding, too.
_SHORTEST: Final = 1000.0
# Of the guess of the first step, as in `native.loop`: small sizes, the shortest step, and a slope that is 0.
_SMALL: Final = 1e-5
_TIMID: Final = 1e-6
_LEVEL: Final = 1e-15
# A step whose inside is out of reach is tried again, shorter, so often.
_TRIALS: Final = 30


@checked_fields
@dataclass(frozen=True, slots=True)
class Partition:
    """Only independent coordinates and speeds are integrated; constraints hold to rounding at every stage.

    Attributes
    ----------
    worst : float
        Other coordinates are chosen when the pivots of the dependent ones have shrunk to this share of the
        best choice, between 0 and 1.
    """

    worst: float = 0.1

    def __post_init__(self) -> None:
        if not 0.0 < self.worst < 1.0:
            raise UsageError(
                Problem(
                    "simulation.constraints",
                    "worst",
                    f"worst = {self.worst!r} is not between 0 and 1",
                    "",
                    "leave it out",
                )
            )


def run_partition(
    motion: Motion, method: Partition, explicit: Explicit, events: EventWatch | None
) -> tuple[RawRun, tuple[str, ...]]:
    """Integrate a set of independent coordinates and speeds; return run and notes."""
    stepper = _PartitionStepper(motion, method, explicit)
    states = stepper.states
    raw = march(stepper, motion.course(events, partial(states.loops.project, states.branch)))
    changes = stepper.changes
    more = (f"other independent coordinates were chosen {changes} times",) if changes else ()
    return raw, (NOTE, *more, *((_OPEN,) if stepper.is_open else ()))


def _mean(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


class _PartitionStepper:
    """DOP853 over the independent coordinates, begun anew when they are chosen anew.

    Its `f`, `h_abs`, `max_step` and `n_stages` are not documented by SciPy. With documented arguments alone
    each step would need a solver of its own, whose beginning costs one evaluation in twelve and forgets how
    long the next step may be.
    """

    def __init__(self, motion: Motion, method: Partition, explicit: Explicit) -> None:
        self._integration, self._worst, self._explicit = motion, method.worst, explicit
        self.states = PartitionStates(motion)
        self._x, (self._t, self._end) = motion.state, motion.span
        self._ends = motion.step_ends()
        self._watch = MonitoredFunction(self.states.rates)
        self.changes, self.rejections = 0, 0
        self.is_open = not self.states.is_on_branch(self._t, self._x)
        self._begin(None if explicit.first_step is None else float(explicit.first_step))

    @property
    def evaluations(self) -> int:
        """How often the accelerations were computed."""
        return self._watch.evaluations

    def advance(self) -> Step | Failure:
        """Take one step; the dependent coordinates inside it are solved for."""
        if self.is_open:
            return Failure(Status.SINGULAR)
        begin, stop, end = self._ends(self._t)
        if begin != self._t:  # what depends on time has jumped
            self._begin(None)
        for _ in range(_TRIALS):
            solver, before = self._solver, self._watch.evaluations
            if not np.isfinite(solver.f).all():
                return self._watch.failure(0)
            solver.max_step = min(self._longest, max(abs(stop - solver.t), _SHORTEST * EPSILON * abs(stop)))
            solver.step()
            self.rejections += (self._watch.evaluations - before) // solver.n_stages
            if solver.status == "failed":
                return self._watch.failure(0)
            nodes = self._nodes(solver)
            if nodes is not None:
                self.rejections -= 1
                length = abs(solver.t - self._t)
                self._accept(solver, nodes[-1])
                if length <= _SHORTEST * EPSILON * abs(self._t) and self._t != self._end:
                    return Failure(Status.STEP_COLLAPSE)
                if abs(self._t - stop) < abs(end - stop):  # before a jump
                    self._t = end
                return Step(self._t, nodes)
            self._begin(0.25 * abs(solver.t - self._t))
        return Failure(Status.STEP_COLLAPSE)

    def restart(self, t: float, x: Floats) -> None:
        """Go on from another state."""
        self._t, self._x = t, x
        self._choose(None)

    def _accept(self, solver: scipy.integrate.DOP853, x: Floats) -> None:
        """Go on from the end of a step; what was carried along is brought onto the constraints."""
        self._x, self._t = x, float(solver.t)
        solver.y = x.copy()
        self._watch.accept()
        self.states.accept(self._t, x)
        if self._t != self._end and self.states.is_worn(self._t, x[self.states.loops.places], self._worst):
            self._choose(abs(solver.h_abs))

    def _nodes(self, solver: scipy.integrate.DOP853) -> Floats | None:
        """Return the states inside the step; None if they are out of reach."""
        inside = solver.dense_output()
        nodes = np.empty((NODES, self._x.size))
        nodes[0] = self._x
        for k in range(1, NODES):
            t = self._t + SHARES[k] * (solver.t - self._t) if k < NODES - 1 else float(solver.t)
            try:
                nodes[k] = self.states.state(t, inside(t))
            except SimulationError:
                return None
        return nodes

    def _choose(self, first_step: float | None) -> None:
        """Choose the independent coordinates of the present state and begin with them."""
        q = self._x[self.states.loops.places]
        if not self.states.is_near_change_point(self._t, q):
            self.states.choose(self._t, q)
            self.changes += 1
        self._begin(first_step)

    def _begin(self, first_step: float | None) -> None:
        """Start DOP853 from the present state."""
        longest = self._longest
        begin, _, _ = self._ends(self._t)
        rest = abs(self._end - begin)
        self._solver = solver = scipy.integrate.DOP853(
            self._watch, begin, self._x.copy(), self._end, max_step=longest, rtol=self._integration.rtol,
            atol=self._integration.tolerances, first_step=rest or None,
        )  # fmt: skip
        if rest > 0.0:
            step = self._first_step(begin, solver.f, rest) if first_step is None else first_step
            solver.h_abs = min(step, rest)

    @property
    def _longest(self) -> float:
        return np.inf if self._explicit.max_step is None else float(self._explicit.max_step)

    def _first_step(self, begin: float, rates: Floats, length: float) -> float:
        """Guess a step as `native.loop` does: SciPy's own guess is made for times of about a second."""
        weights = self._integration.tolerances + self._integration.rtol * np.abs(self._x)
        size, slope = _mean(self._x / weights), _mean(rates / weights) * length
        share = min(_TIMID if size < _SMALL or slope < _SMALL else 0.01 * size / slope, 1.0)
        h = share * length * (1.0 if self._end >= begin else -1.0)
        changed = self._watch(begin + h, self._x + h * rates)
        steepest = max(slope, _mean((changed - rates) / weights) * length / share)
        if not np.isfinite(steepest):
            return share * length
        longer = max(_TIMID, 1e-3 * share) if steepest <= _LEVEL else (0.01 / steepest) ** (1.0 / 8.0)
        return float(min(100.0 * share, longer, 1.0) * length)
