"""Minimal coordinates by partition: `Partition` integrates independent ones, the others follow from Phi.

Wehage and Haug, Generalized coordinate partitioning for dimension reduction in analysis of constrained
dynamic systems, J. Mech. Design 104 (1982). The compiled loop carries the others along: to choose the step by
them too, which alone do it where all motion is prescribed, and to start Newton's method from them, so that it
stays on the branch of the motion. See `kernels.configurations.chart`.

Near change points no chart is good. There the loop goes on with rates from `PartitionStates`, in Python.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.kernel_library import load_entries
from symbody.errors import Problem, SimulationError, UsageError
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.configurations.chart_record import Chart
from symbody.kernels.pack import pack
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.hybrid.passed_jumps import PassedJumps
from symbody.simulation.inputs.input_laws import CallbackFunction, NativeCallback
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR
from symbody.simulation.methods.closed_loops.partition_states import PartitionStates
from symbody.simulation.methods.constraints import ROUNDED_PER_COORDINATE, Projection
from symbody.simulation.motion import Motion
from symbody.simulation.native.blocks import function_numbers, state_of
from symbody.simulation.native.closing import POSED
from symbody.simulation.native.description import Projector, Record, RightHandSide, Watch
from symbody.simulation.native.run import SLICE_SECONDS, NativeRun
from symbody.single_flight import once
from symbody.tolerances import EXACT

Floats = NDArray[np.float64]

_OPEN: Final = (
    "the start is a change point, where the mechanism can move along several branches, and the velocities "
    "do not select one: start slightly away from it, or give other velocities"
)
_NOTHING: Final = np.zeros(0)
_LIMIT: Final = Projection().limit
# Newton's method ends with a step of this share of rtol: its speeds are off by as much.
_SETTLED: Final = 1e-3
# Python takes over where the least singular value is below the first, and hands back above the second.
_ENTER: Final = 2.0 * NEAR
_LEAVE: Final = 3.0 * NEAR
_MOST_TRIALS: Final = 1 << 20  # of one call
# Faults of one evaluation that a shorter step may avoid.
_MENDABLE: Final = ("simulation.partition", "numerics.singular_mass")


@checked_fields
@dataclass(frozen=True, slots=True)
class Partition:
    """Only independent coordinates and speeds are integrated; constraints hold to rounding at every stage.

    Attributes
    ----------
    worst : float
        Other coordinates are chosen when the pivots of the dependent ones have shrunk to this share of the
        best so far, between 0 and 1.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> run = sb.simulate(sb.form_equations(ladder), 1.0, {"x_dot": 1}, constraints=sb.Partition())
    >>> run.success, bool(run.constraint_violation.max() < 1e-9)
    (True, True)
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


@once
def _entries() -> tuple[int, int]:
    """Return the addresses of rates and moves on a chart."""
    found = load_entries("chart", ("chart_rates", "chart_moves"))
    return found["chart_rates"], found["chart_moves"]


class _PassageFunction(NativeCallback):
    """A function of the loop near a change point: Python computes its values from time and state."""

    def __init__(self, values: Callable[[float, Floats], Floats], size: int) -> None:
        super().__init__()
        self._values, self._x = values, ctypes.c_double * size

    def answer(self, t: int, q: int, u: int, r: int, p: int, c: int, out: int, work: int) -> int:
        """Store the values; where there are none a shorter step is tried."""
        try:
            values = self._values(ctypes.c_double.from_address(t).value, np.array(self._x.from_address(u)))
        except SimulationError as error:
            if error.problems[0].code not in _MENDABLE:
                raise
            return at.OUT_OF_REACH
        ctypes.memmove(out, address(values), values.nbytes)
        return 0


class ChartRun:
    """A run of the compiled loop that goes from chart to chart; see `native.run.CompiledRun`."""

    def __init__(self, motion: Motion, method: Partition) -> None:
        self._motion, self._worst = motion, method.worst
        self._states = PartitionStates(motion)
        self._is_open = not self._states.is_on_branch(motion.span[0], motion.state)
        self._posed = motion.problem.compile_outputs(POSED)
        self._laws: dict[int, CallbackFunction] = {}
        size = motion.x0.size
        self._passage = _PassageFunction(self._states.rates, size)
        self._passage_moves = _PassageFunction(self._moves, size)
        self._closed = np.zeros(size)
        self._changes, self._share = 0, method.worst

    @property
    def notes(self) -> tuple[str, ...]:
        """What to say about the motion."""
        count = self._changes
        more = (f"other independent coordinates were chosen {count} times",) if count else ()
        return (*more, *((_OPEN,) if self._is_open else ()))

    @property
    def block(self) -> Floats:
        """See `symbody.kernels.block`."""
        return self._native.block

    @property
    def jumps(self) -> PassedJumps | None:
        """See `native.run.CompiledRun`."""
        return self._native.jumps

    def interruptible(self) -> AbstractContextManager[None]:
        """Let Ctrl-C end the loop from within."""
        return self._passage.interruptible()

    def start(self, rhs: RightHandSide, make: Callable[[RightHandSide, Projector], NativeRun]) -> ChartRun:
        """Take the place of a run with a right-hand side; `make` makes one with other functions."""
        loops, count = self._states.loops, self._states.positions.rows.size
        n_u, n_q = loops.speed_sizes.size, loops.sizes.size
        projector = Projector(
            1, n_u, rhs.inputs.copy(), np.zeros(2), _NOTHING, 0, n_q, np.full(count, EXACT), _LIMIT,
            loops.sizes, ROUNDED_PER_COORDINATE * n_q * EPSILON / EXACT, count + n_q + n_u,
        )  # fmt: skip
        plain = rhs._replace(parameters=np.zeros(3), constants=_NOTHING, work_size=0)
        self._native = make(plain, projector)
        t, q = self._place()
        self._is_passing = self._states.share(t, q) < _ENTER
        if self._is_passing:
            self._enter_passage()
        else:
            self._states.choose(t, q)
            self._enter_chart()
        return self

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        code = self._native.begin(record)
        self._raise_fault()
        return at.SINGULAR if self._is_open else code

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        code, began = at.RUNNING, time.perf_counter()
        while code == at.RUNNING and time.perf_counter() - began < SLICE_SECONDS:
            code = self._native.advance(record, 1 if self._is_passing else min(trials, _MOST_TRIALS), watch)
            self._raise_fault()
            t, q = self._place()
            self._states.accept(t, state_of(self.block).copy())
            if self._is_passing:
                self._pass_on(t, q)
            elif code != at.CHART_ENDS:
                break
            else:
                self._end_chart(t, q)
                code = at.RUNNING
        return code

    def _place(self) -> tuple[float, Floats]:
        """Return time and coordinates at present."""
        return Run(self.block).time, state_of(self.block)[self._states.loops.places].copy()

    def _end_chart(self, t: float, q: Floats) -> None:
        """Choose anew; where this gives the same again, steps may lead farther before it is worn."""
        self._is_passing = self._states.share(t, q) < _ENTER
        if not self._is_passing:
            is_new = self._states.choose(t, q)
            self._changes += is_new
            self._share = self._worst * (1.0 if is_new else self._share)
            self._is_passing = self._share < NEAR
        if self._is_passing:
            self._enter_passage()
        else:
            self._enter_chart()

    def _pass_on(self, t: float, q: Floats) -> None:
        """Go back to a chart behind a change point; where there is none, choose what is best."""
        if not self._states.is_near_change_point(t, q):
            self._changes += self._states.choose(t, q)
        if self._states.share(t, q) > _LEAVE:
            self._is_passing, self._share = False, self._worst
            self._enter_chart()

    def _enter_passage(self) -> None:
        """Let Python compute. What it interpolates differs from what was closed before."""
        self._native = self._native._replace(rhs=self._passage.address, projector=self._passage_moves.address)
        Run(self.block).projection.limit = np.inf

    def _enter_chart(self) -> None:
        """Make the chart of the present choice."""
        rates = self._states.function(self._states.speeds)
        entry = rates.address
        if self._motion.problem.laws.need_python:
            entry = self._laws.setdefault(entry, CallbackFunction(rates, self._motion.problem.laws)).address
        self._chart = self._make_chart(rates)
        places = entry, self._posed.address, address(self._chart)
        run = Run(self.block)
        for function, given in ((run, places), (run.projection, places[1:])):
            np.asarray(function.numbers.parameters).view(np.int64)[:] = given
        run.projection.limit = _LIMIT
        self._native = self._native._replace(rhs=_entries()[0], projector=_entries()[1])

    def _make_chart(self, rates: CompiledFunction) -> Floats:
        """Return the array of a `Chart`."""
        motion, loops = self._motion, self._states.loops
        positions, speeds = self._states.positions, self._states.speeds
        sizes = [len(output.values) for output in self._posed.outputs]
        k = max(positions.rows.size, speeds.rows.size)
        numbers, rate_numbers = (
            function_numbers(
                RightHandSide(0, motion.n_u, _NOTHING, _NOTHING, each.constants(), each.work_size)
            )
            for each in (self._posed, rates)
        )
        return pack(
            Chart, states=motion.x0.size, speeds=motion.n_u, coordinates=loops.sizes.size,
            conditions=sizes[0], rows=sizes[2], out_size=sum(sizes),
            dependent_positions=positions.rows.size, dependent_speeds=speeds.rows.size,
            quaternion_count=len(loops.quaternions), settled=_SETTLED * motion.rtol, share=self._share,
            position_rows=positions.rows, position_places=positions.dependent, speed_rows=speeds.rows,
            speed_places=speeds.dependent, quaternion_places=np.ravel(loops.quaternions), sizes=loops.sizes,
            speed_sizes=loops.speed_sizes, scales=motion.problem.scales.constraints(motion.eqs),
            matrix=np.zeros(k * k), move=np.zeros(k), pivots=np.zeros(k), numbers=numbers,
            rate_numbers=rate_numbers,
        )  # fmt: skip

    def _moves(self, t: float, x: Floats) -> Floats:
        """Return what `projection` reads: residuals, moves of all coordinates, moves of all speeds.

        It moves a state, then asks whether that is closed.
        """
        places = self._states.loops.places
        if not (x[places] == self._closed[places]).all():
            self._closed = self._states.state(t, x)
        moves = self._closed - x
        residuals = np.full(self._states.positions.rows.size, float(moves[places].any()))
        return np.concatenate([residuals, moves[places], moves[: places.start]])

    def _raise_fault(self) -> None:
        """Raise what ended the loop from within."""
        for each in (self._passage, self._passage_moves, *self._laws.values()):
            if each.error is not None:
                raise each.error
