"""`PassedJumps`: the jumps of prescribed rates in a run of the loop; each strikes the mechanism."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.kernels.pack import pack
from symbody.simulation.hybrid.rate_jumps import PlannedJumps, no_speeds, strikes, torn_constraint
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.native.blocks import function_numbers
from symbody.simulation.native.description import Record, Watch
from symbody.simulation.native.strikes import strike_block, strike_equations, strike_outputs
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.single_flight import once

if TYPE_CHECKING:
    from symbody.simulation.hybrid.switching import SwitchingModes

Floats = NDArray[np.float64]

_POINTER: Final = ctypes.c_void_p


class PassedJumps:
    """Jumps of prescribed rates along one run.

    Parameters
    ----------
    problem : SimulationProblem
        What moves.
    planned : PlannedJumps
        When rates jump.
    span : tuple of float
        Of the run [s].
    modes : SwitchingModes, optional
        Those of joints and gaps, which hold nothing at a jump.
    ends_behind : bool
        Whether the run ends just behind each jump, as modes are decided outside.

    Attributes
    ----------
    address : int
        Where the function of a strike lies.
    array : array
        See `kernels.configurations.strike_problem.RateJumps`.
    """

    feature = "JUMPS"

    def __init__(
        self, problem: SimulationProblem, planned: PlannedJumps, span: tuple[float, float],
        modes: SwitchingModes | None = None, *, ends_behind: bool = False,
    ) -> None:  # fmt: skip
        self._problem, self._modes = problem, modes
        eqs = strike_equations(problem.eqs)
        moving = replace(problem, eqs=eqs)
        self._function = moving.compile_outputs(strike_outputs(eqs), quick=True)
        laws = problem.laws
        self._callback = CallbackFunction(self._function, laws) if laws.need_python else None
        self.address = self._function.address if self._callback is None else self._callback.address
        sizes = [len(output.values) for output in self._function.outputs]
        numbers = function_numbers(moving.numbers(self._function))
        self.array = pack(
            RateJumps, count=len(planned.times), t_end=span[1], ends_behind=float(ends_behind),
            jumps=planned.rows(span), problem=strike_block(eqs, problem.scales, sizes, numbers),
        )  # fmt: skip
        self._planned = planned

    @property
    def _record(self) -> RateJumps:
        return RateJumps(self.array)

    @property
    def t_end(self) -> float:
        """When the motion ends behind all jumps [s]."""
        return self._record.t_end

    @property
    def impulses(self) -> tuple[tuple[float, float], ...]:
        """When a speed has jumped [s], and by how much the energy has [J]."""
        jumps = self._record.jumps
        done = [(t, jumps[k]) for k, t in enumerate(self._planned.times[: self._record.next])]
        return tuple((t, jump.gained) for t, jump in done if strikes(self._problem, jump.change))

    def limit_run(self, block: Floats) -> None:
        """Let a run end just before the next jump."""
        _kernels().end_before_jump(address(block), address(self.array))

    @property
    def is_due(self) -> bool:
        """Whether a run that has come to its end goes on behind a jump."""
        return self._record.next < self._record.count

    def has_just_passed(self, block: Floats) -> bool:
        """Return whether a run stands just behind a jump."""
        own = self._record
        return own.next > 0 and own.jumps[own.next - 1].behind == Run(block).time

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return the function of a strike, and when rates jump."""
        self.show_inputs()
        return {"s": self.address, "jumps": self.array}

    def show_inputs(self) -> None:
        """Write the values that inputs have at present where speeds are struck."""
        inputs = np.asarray(self._record.problem.numbers.inputs)
        inputs[:] = self._problem.laws.held_now()
        if self._modes is not None:
            first = self._modes.switch.first_input
            inputs[first : first + self._modes.switch.count] = LOOSE

    def strike(self, block: Floats, record: Record) -> None:
        """Strike the state to which a run has come, and store the samples there.

        Raises
        ------
        UsageError, SimulationError
            See `answer`.
        """
        self.show_inputs()
        places = map(address, (block, self.array, *record.arrays[:4]))
        self.answer(_kernels().strike_state(self.address, *places))
        _kernels().store_behind(*map(address, (block, self.array, *record.arrays[:3])))

    def note_values(self, watch: Watch, block: Floats) -> None:
        """Note where the values of events stand before a jump."""
        own = watch.arguments(block)
        _kernels().values_before(own["e"], address(block), address(watch.array))

    def watch_behind(self, watch: Watch, block: Floats, record: Record) -> None:
        """Let a search for events go on behind a jump."""
        own, places = watch.arguments(block), (block, watch.array, self.array, record.breaks, record.pieces)
        _kernels().watch_struck(own["e"], *map(address, places))

    def answer(self, code: int) -> None:
        """Raise what a code of the kernels says.

        Raises
        ------
        UsageError
            If a position jumps.
        SimulationError
            If no speeds fit the rates, or the law of an input fails.
        """
        if self._callback is not None and self._callback.error is not None:
            raise self._callback.error
        if code not in (at.TORN_MOTION, at.NO_IMPULSE):
            return
        behind = self._record.jumps[self._record.next].behind
        if code == at.TORN_MOTION:
            raise torn_constraint(self._problem.eqs, self._record.problem.torn - 1, behind)
        raise no_speeds(behind)


class _Kernels(NamedTuple):
    """What passes a jump, ready to be called."""

    end_before_jump: Callable[..., None]
    strike_state: Callable[..., int]
    store_behind: Callable[..., None]
    values_before: Callable[..., None]
    watch_struck: Callable[..., None]


@once
def _kernels() -> _Kernels:
    integer = ctypes.c_int64
    kinds: list[list[Any]] = [
        [None, *[_POINTER] * 2],
        [integer, *[_POINTER] * 7],
        [None, *[_POINTER] * 5],
        [None, *[_POINTER] * 3],
        [None, *[_POINTER] * 6],
    ]
    places = load_kernels("struck_motion", _Kernels._fields, light=True)
    functions = [
        ctypes.CFUNCTYPE(*kind)(places[name]) for name, kind in zip(_Kernels._fields, kinds, strict=True)
    ]
    return _Kernels(*functions)
