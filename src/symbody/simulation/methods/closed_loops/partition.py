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
from abc import abstractmethod
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_entries
from symbody.errors import Problem, SimulationError, UsageError
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.configurations.chart_record import Chart
from symbody.kernels.pack import pack
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.inputs.native_callback import NativeCallback
from symbody.simulation.methods.closed_loops.loop_constraints import NEAR
from symbody.simulation.methods.closed_loops.partition_states import PartitionStates
from symbody.simulation.methods.constraints import ROUNDED_PER_COORDINATE, Projection
from symbody.simulation.motion import Motion
from symbody.simulation.native.blocks import function_numbers, state_of
from symbody.simulation.native.closing import POSED
from symbody.simulation.native.description import Projector, Record, RightHandSide
from symbody.simulation.native.run import SLICE_SECONDS, NativeRun
from symbody.simulation.native.segments import Watch
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
    """A function of the loop near a change point, where Python computes."""

    def __init__(self, states: PartitionStates, size: int) -> None:
        super().__init__()
        self._states = states
        self._x = ctypes.c_double * size

    def answer(self, t: int, q: int, u: int, r: int, p: int, c: int, out: int, work: int) -> int:
        """Store what is computed of time and state; where there is nothing a shorter step is tried."""
        try:
            values = self.values(ctypes.c_double.from_address(t).value, np.array(self._x.from_address(u)))
        except SimulationError as error:
            if error.problems[0].code not in _MENDABLE:
                raise
            return at.OUT_OF_REACH
        ctypes.memmove(out, address(values), values.nbytes)
        return 0

    @abstractmethod
    def values(self, t: float, x: Floats) -> Floats:
        """Return what to store."""


class _PassageRates(_PassageFunction):
    """The slopes of the state that belongs to another one."""

    def values(self, t: float, x: Floats) -> Floats:
        """Return them, and the power."""
        return self._states.rates(t, x)


class _PassageMoves(_PassageFunction):
    """What `projection` reads: it moves a state, then asks whether that is closed."""

    def __init__(self, states: PartitionStates, size: int) -> None:
        super().__init__(states, size)
        self._closed = np.zeros(size)

    def values(self, t: float, x: Floats) -> Floats:
        """Return residuals, moves of all coordinates, moves of all speeds."""
        places = self._states.loops.places
        is_closed = bool((x[places] == self._closed[places]).all())
        if not is_closed:
            self._closed = self._states.state(t, x)
        moves = self._closed - x
        residuals = np.full(self._states.positions.rows.size, float(moves[places].any()))
        return np.concatenate([residuals, moves[places], moves[: places.start]])


class Charts:
    """The charts of one motion, one after the other, and what the compiled loop calls.

    Attributes
    ----------
    changes : int
        How often others became independent.
    """

    def __init__(self, motion: Motion, method: Partition) -> None:
        self.changes = 0
        self.states = PartitionStates(motion)
        self._motion, self._worst = motion, method.worst
        self._is_open = not self.states.is_on_branch(motion.span[0], motion.state)
        self._posed = motion.problem.compile_outputs(POSED)
        self._calls: dict[tuple[int, ...], CallbackFunction] = {}
        self._passage = _PassageRates(self.states, motion.x0.size)
        self._passage_moves = _PassageMoves(self.states, motion.x0.size)
        self._chart = Chart(_NOTHING)
        self._rates = 0

    @property
    def notes(self) -> tuple[str, ...]:
        """What to say about the motion."""
        more = (f"other independent coordinates were chosen {self.changes} times",) if self.changes else ()
        return (*more, *((_OPEN,) if self._is_open else ()))

    @property
    def is_open(self) -> bool:
        """Whether the velocities do not select a branch at the start."""
        return self._is_open

    def interruptible(self) -> AbstractContextManager[None]:
        """Let Ctrl-C end the loop from within."""
        return self._passage.interruptible()

    def right_hand_side(self, right: RightHandSide) -> RightHandSide:
        """Return the right-hand side of the loop, with the laws of another one."""
        return right._replace(address=1, parameters=np.zeros(3), constants=_NOTHING, work_size=0)

    @property
    def projector(self) -> Projector:
        """What brings the ends of steps, and samples, onto the constraints."""
        loops, positions = self.states.loops, self.states.positions
        n_u, n_q, count = loops.speed_sizes.size, loops.sizes.size, positions.rows.size
        return Projector(
            1, n_u, _NOTHING, np.zeros(2), _NOTHING, 0, n_q, np.full(count, EXACT), _LIMIT,
            loops.sizes, ROUNDED_PER_COORDINATE * n_q * EPSILON / EXACT, count + n_q + n_u,
        )  # fmt: skip

    def choose(self, share: float) -> None:
        """Make the chart of the present choice, worn at a share of its best pivots."""
        motion, loops = self._motion, self.states.loops
        positions, speeds = self.states.positions, self.states.speeds
        laws, n_u = motion.problem.laws, motion.n_u
        rates = self.states.function(speeds)
        key = tuple(speeds.rows.tolist())
        self._rates = rates.address
        if laws.need_python:
            if key not in self._calls:
                self._calls[key] = CallbackFunction(rates, laws)
            self._rates = self._calls[key].address
        sizes = [len(output.values) for output in self._posed.outputs]
        k = max(positions.rows.size, speeds.rows.size)
        numbers, rate_numbers = (
            function_numbers(
                RightHandSide(0, n_u, _NOTHING, _NOTHING, function.constants(), function.work_size)
            )
            for function in (self._posed, rates)
        )
        eqs, scales = motion.eqs, motion.problem.scales
        self._chart = Chart(pack(
            Chart, states=motion.x0.size, speeds=n_u, coordinates=loops.sizes.size, conditions=sizes[0],
            rows=sizes[2], out_size=sum(sizes), dependent_positions=positions.rows.size,
            dependent_speeds=speeds.rows.size, quaternion_count=len(eqs.quaternions),
            settled=_SETTLED * motion.rtol, share=share, position_rows=positions.rows,
            position_places=positions.dependent, speed_rows=speeds.rows, speed_places=speeds.dependent,
            quaternion_places=np.ravel(loops.quaternions), sizes=loops.sizes, speed_sizes=loops.speed_sizes,
            scales=scales.constraints(eqs), matrix=np.zeros(k * k), move=np.zeros(k), pivots=np.zeros(k),
            numbers=numbers, rate_numbers=rate_numbers,
        ))  # fmt: skip

    def run(self, native: NativeRun) -> ChartRun:
        """Return the run of the compiled loop, with what it calls."""
        return ChartRun(self, native, self._motion, self._worst)

    def on_chart(self, native: NativeRun) -> NativeRun:
        """Return a run on the present chart."""
        run, chart = Run(native.block), address(np.asarray(self._chart.array))
        rates, moves = (np.asarray(each.numbers.parameters) for each in (run, run.projection))
        rates.view(np.int64)[:] = self._rates, self._posed.address, chart
        moves.view(np.int64)[:] = self._posed.address, chart
        run.projection.limit = _LIMIT
        entries = _entries()
        return native._replace(rhs=entries[0], projector=entries[1])

    def in_passage(self, native: NativeRun) -> NativeRun:
        """Return a run near a change point: what is interpolated differs from what was closed before."""
        Run(native.block).projection.limit = np.inf
        return native._replace(rhs=self._passage.address, projector=self._passage_moves.address)

    def raise_fault(self) -> None:
        """Raise what ended the loop from within."""
        for each in (self._passage, self._passage_moves, *self._calls.values()):
            if each.error is not None:
                raise each.error


class ChartRun:
    """A run of the compiled loop that goes from chart to chart; see `native.run.CompiledRun`."""

    def __init__(self, charts: Charts, native: NativeRun, motion: Motion, worst: float) -> None:
        self.block = native.block
        self._charts, self._native, self._worst = charts, native, worst
        self._share = worst
        self._is_passing = charts.states.share(*self._place) < _ENTER
        if not self._is_passing:
            charts.states.choose(*self._place)
            charts.choose(worst)

    @property
    def _place(self) -> tuple[float, Floats]:
        """Time and coordinates at present."""
        return Run(self.block).time, state_of(self.block)[self._charts.states.loops.places]

    @property
    def _now(self) -> NativeRun:
        charts = self._charts
        return charts.in_passage(self._native) if self._is_passing else charts.on_chart(self._native)

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        code = self._now.begin(record)
        self._charts.raise_fault()
        return at.SINGULAR if self._charts.is_open else code

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        charts, began = self._charts, time.perf_counter()
        code = at.RUNNING
        while code == at.RUNNING and time.perf_counter() - began < SLICE_SECONDS:
            code = self._now.advance(record, 1 if self._is_passing else min(trials, _MOST_TRIALS), watch)
            charts.raise_fault()
            t, x = Run(self.block).time, state_of(self.block).copy()
            charts.states.accept(t, x)
            if self._is_passing:
                self._pass_on(t, x[charts.states.loops.places])
            elif code == at.CHART_ENDS:
                self._end_chart(t, x[charts.states.loops.places])
                code = at.RUNNING
            else:
                break
        return code

    def _end_chart(self, t: float, q: Floats) -> None:
        """Choose anew; where this gives the same again, steps may lead farther before it is worn."""
        states = self._charts.states
        is_near = states.share(t, q) < _ENTER
        if not is_near:
            is_new = states.choose(t, q)
            self._share = self._worst * (1.0 if is_new else self._share)
            self._charts.changes += is_new
        if is_near or self._share < NEAR:
            self._is_passing = True
        else:
            self._charts.choose(self._share)

    def _pass_on(self, t: float, q: Floats) -> None:
        """Go back to a chart behind a change point."""
        states = self._charts.states
        if states.share(t, q) > _LEAVE:
            self._charts.changes += states.choose(t, q)
            self._is_passing, self._share = False, self._worst
            self._charts.choose(self._worst)
        elif states.is_worn(t, q, self._worst):
            self._charts.changes += states.choose(t, q)
