"""`MoreauJean`: steps over impacts, for tens to hundreds of rigid contacts; `run_moreau_jean` runs it.

The loop is `kernels.impulses.impulse_machine`.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import checked_fields
from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.equations.outputs.output_roots import OF_STEPS
from symbody.equations.solving.impulsive_equations import GAPS, RESPONSES
from symbody.errors import Problem, UsageError
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.simulation.events.event_watch import EventWatch
from symbody.simulation.inputs.input_laws import called_laws
from symbody.simulation.methods.explicit import NOTHING_TO_PROJECT, make_goal
from symbody.simulation.motion import Motion, StateProjector
from symbody.simulation.native.blocks import make_block
from symbody.simulation.native.description import Record, Watch
from symbody.simulation.native.run import (
    EVENT_SAMPLES,
    RawRun,
    begin_again,
    fresh_record,
    run_loop,
    show_room,
)
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.single_flight import once

if TYPE_CHECKING:
    from symbody.simulation.hybrid.impulsive_contacts import ImpulsiveContacts

Floats = NDArray[np.float64]


@checked_fields
@dataclass(frozen=True, slots=True)
class MoreauJean:
    """The method of Moreau and Jean: steps of one length over impacts, for many rigid contacts.

    No impact is located: gaps that a step would leave negative get impulses at its end, all together, by
    Newton's law of impacts and Coulomb's cone in each point. Where nothing touches it is the midpoint rule,
    of order 2; impacts are of order 1 in the step.

    Attributes
    ----------
    step : float
        Length of the steps [s].
    tolerance : float
        By how much the impulses of a step may miss their laws, as a share of the fastest rate of a gap or a
        slip in it. The greatest is in ``run.statistics.residual``.
    sweeps : int
        So many sweeps over all points a step may take to reach it; a note reports those that do not.

    Raises
    ------
    UsageError
        A value that is not positive.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z")
    >>> floor = sb.Stop("floor", "z", restitution=0.5)
    >>> eqs = sb.form_equations(sb.Model("ball", [rail, floor], gravity=(0, 0, -9.81), initial={"z": 1}))
    >>> run = sb.simulate(eqs, 3.0, integrator=sb.MoreauJean(step=1e-3))
    >>> run.success, bool(abs(run["z"][-1]) < 1e-5)
    (True, True)
    """

    step: float
    tolerance: float = 1e-10
    sweeps: int = 1000

    def __post_init__(self) -> None:
        problems = [
            Problem("simulation.moreau_jean", name, f"{name} = {value!r} is not a positive number", "",
                    f"give a positive number, such as {name}={example}")
            for name, value, example in (
                ("step", self.step, "1e-3"), ("tolerance", self.tolerance, "1e-10"),
                ("sweeps", self.sweeps, "1000"),
            )
            if not (value > 0 and math.isfinite(value))
        ]  # fmt: skip
        if problems:
            raise UsageError(*problems)


# What the loop reads of it: slopes at both ends of steps of one length, and the cubic through them.
METHOD: Final = Tableau(
    order=2, stages=1, A=((), (1.0,)), c=(0.0, 1.0), error=((), ()), dense=(), exponent=1.0 / 3.0,
    memory=0.0, shrink=1.0, growth=1.0, stiff_bound=1.0,
)  # fmt: skip
_POINTER: Final = ctypes.c_void_p


def run_moreau_jean(
    motion: Motion, method: MoreauJean, closing: StateProjector | None, watch: EventWatch | None
) -> tuple[RawRun, tuple[str, ...]]:
    """Return the run of the compiled loop, and what to note about it.

    Raises
    ------
    SimulationError
        If the law of an input fails.
    """
    impulses = motion.impulses
    if impulses is None:
        raise LookupError("a motion by impulses has their equations")
    problem = impulses.free_problem(motion.problem)
    functions = [problem.compile_outputs(name) for name in (OF_STEPS, "qdot", GAPS, RESPONSES)]
    slopes, rates, gaps, responses = functions
    impulses.begin(problem, (gaps, responses, rates), method.tolerance, method.sweeps)
    with called_laws(functions, problem.laws) as addresses:
        run = ImpulseRun((motion, impulses), method, problem, slopes, addresses, closing)
        record = fresh_record(run, _times(motion), True, 0 if watch is None else EVENT_SAMPLES)
        raw = run_loop(run, record, motion.progress, watch)
    impulses.record.note(impulses.step)
    return replace(raw, statistics=replace(raw.statistics, residual=impulses.step.worst)), ()


class ImpulseRun:
    """The run of `kernels.impulses.impulse_machine`; see `native.run.CompiledRun`."""

    jumps = None

    def __init__(
        self, moving: tuple[Motion, ImpulsiveContacts], method: MoreauJean, problem: SimulationProblem,
        slopes: CompiledFunction, addresses: Sequence[int], closing: StateProjector | None,
    ) -> None:  # fmt: skip
        motion, self._impulses = moving
        f, k, e, d = addresses
        projector = NOTHING_TO_PROJECT if closing is None else closing.projector._replace(limit=math.inf)
        tolerances = np.append(motion.tolerances, 1.0)
        bounds = motion.breakpoints.jumps_alone()
        goal = make_goal(motion.span, motion.rtol, tolerances, method.step, bounds)
        goal = goal._replace(max_trials=int(motion.max_steps))
        rhs = problem.numbers(slopes)
        self.block = make_block(rhs, projector, METHOD, goal, motion.x0, motion.span[0], method.step)
        self._functions = (f, k, e, d, projector.address)

    def begin(self, record: Record) -> int:
        """Compute what a run begins with; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        self._impulses.record.cut(Run(self.block).time, self._impulses.step)
        self._impulses.step.begins = 0.0
        places = (self.block, record.wanted, record.t, record.x, record.breaks)
        return _kernels()[0](self._functions[0], *map(address, places))

    def advance(self, record: Record, trials: int, watch: Watch | None = None) -> int:
        """Try up to so many steps; return a code of `symbody.kernels.block`."""
        show_room(self.block, record)
        if watch is None:
            return self._take_steps(record, trials)
        code = at.RUNNING
        for _ in range(trials):
            if record.every_step and Run(self.block).counts.samples + EVENT_SAMPLES > record.t.size:
                return at.FULL
            code = watch.process(self.block, record, self._take_steps(record, 1))
            if code == at.RESTARTED:
                code = begin_again(self, record)
            if code != at.RUNNING:
                break
        return code

    def _take_steps(self, record: Record, trials: int) -> int:
        impulses, code = self._impulses, at.NO_MODE_ROOM
        while code == at.NO_MODE_ROOM:
            impulses.make_room()
            kept = impulses.record
            arrays = (self.block, impulses.array, *record.arrays, kept.starts, kept.entries)
            code = _kernels()[1](*self._functions, *map(address, arrays), trials)
        return code


def _times(motion: Motion) -> Floats | None:
    return None if motion.times is None else np.asarray(motion.times, dtype=np.float64)


@once
def _kernels() -> tuple[Callable[..., int], Callable[..., int]]:
    """Return what begins a run and what takes steps, ready to be called."""
    integer = ctypes.c_int64
    kinds: dict[str, list[Any]] = {
        "begin_impulses": [_POINTER] * 6,
        "advance_impulses": [*[_POINTER] * 14, integer],
    }
    places = load_kernels("impulse_machine", tuple(kinds), features=())
    first, second = (ctypes.CFUNCTYPE(integer, *kinds[name])(places[name]) for name in kinds)
    return first, second
