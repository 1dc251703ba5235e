"""`FmuSteps`: steps whose inputs FMUs compute, each in parts between the samples of these."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.simulation.co_simulation.fmu_unit import open_unit
from symbody.simulation.co_simulation.sampled_unit import (
    SampledUnit,
    by_instance,
    make_reader,
    read_values,
)
from symbody.simulation.events.events import Occurrence
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import Ending, Steps
from symbody.simulation.stepper.hybrid_steps import OTHERWISE
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.step_problem import StepProblem

Floats = NDArray[np.float64]

# Shares of the shortest sample time within which two times are one.
_ONE_INSTANT: Final = 1e-6
_WORD: Final = np.dtype("<u4")  # bytes of FMUs are kept as whole numbers


class _Units:
    """The instances of all FMUs of a stepper; they end with the last stepper that uses them."""

    def __init__(
        self, problem: StepProblem, numbers: StepNumbers, moving: SimulationProblem,
        readers: Iterable[CompiledFunction | None],
    ) -> None:  # fmt: skip
        stack = ExitStack()
        weakref.finalize(self, stack.close)
        start, x = problem.settings.t_start, numbers.x[:-1].copy()
        self.units: list[SampledUnit] = []
        for group, reader in zip(by_instance(problem.settings.fmus), readers, strict=True):
            values = read_values(moving, reader, numbers.t, x)
            unit = stack.enter_context(open_unit(group, start, values))
            self.units.append(SampledUnit(group, unit, reader, start))


class FmuSteps:
    """Steps between which FMUs take theirs; see `compiled_steps.Steps`.

    At each of its samples an FMU computes its inputs from the state there, and they hold until the next.

    Parameters
    ----------
    inner : Steps
        What moves, with these inputs constant.
    problem : StepProblem
        What moves.
    numbers : StepNumbers
        Time, state and inputs.
    """

    def __init__(self, inner: Steps, problem: StepProblem, numbers: StepNumbers) -> None:
        self._inner = inner
        self._problem = problem
        self._numbers = numbers
        groups = by_instance(problem.settings.fmus)
        self._readers = [make_reader(inner.motion_problem, group) for group in groups]
        self._width = _ONE_INSTANT * min(law.period for law in problem.settings.fmus.values())
        names = tuple(problem.problem.laws.callbacks)
        self._slots = {name: names.index(name) for name in problem.settings.fmus}
        self._units: _Units | None = None
        self._ending: Ending | None = None

    @property
    def motion_problem(self) -> SimulationProblem:
        """The equations that move, with all inputs as they are at present."""
        return self._inner.motion_problem

    @property
    def modes(self) -> dict[str, str]:
        """The modes of joints, ropes and stops in which the last step ended."""
        return self._inner.modes

    def at_present(self) -> AbstractContextManager[None]:
        """Let the modes be those of the present state and inputs, while outputs are computed."""
        return self._inner.at_present()

    @property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """What happened in the last step."""
        return self._inner.occurrences

    @occurrences.setter
    def occurrences(self, happened: tuple[Occurrence, ...]) -> None:
        self._inner.occurrences = happened

    def go_on(self) -> int:
        """Take a step, in parts if samples lie inside it; return `at.FINISHED` where it came to its end."""
        units = self._open()
        duration = float(self._numbers.array[stepping.DURATION])
        end = self._numbers.t + duration
        self._ending = None
        self._sample(units)
        if min(unit.due for unit in units) >= end - self._width:
            return self._inner.go_on()
        happened: tuple[Occurrence, ...] = ()
        try:
            while self._ending is None and self._numbers.t < end - self._width:
                self._sample(units)
                self._numbers.set_duration(min([end, *(unit.due for unit in units)]) - self._numbers.t)
                self._ending = self._part()
                happened += self._inner.occurrences
        finally:
            self._numbers.set_duration(duration)
            self._inner.occurrences = happened
        return at.FINISHED if self._ending is None else OTHERWISE

    def check(self) -> None:
        """Refuse a step that must not be taken, before anything moves."""
        self._inner.check()

    def end(self, code: int) -> Ending:
        """Return how the last step ended."""
        return self._inner.end(code) if self._ending is None else self._ending

    def restart(self, initial: Mapping[str, Value]) -> None:
        """Begin anew from time and state at present, with new instances of the FMUs."""
        self._units = self._ending = None
        self._inner.restart(initial)

    def snapshot(self) -> Floats:
        """Return the numbers of the steps, and of each FMU how many samples it took and its state.

        Raises UsageError if an FMU cannot save its state.
        """
        parts = [self._inner.snapshot()]
        for unit in self._open():
            saved = unit.save()
            words = np.frombuffer(saved + bytes(-len(saved) % _WORD.itemsize), dtype=_WORD)
            parts += [words.astype(np.float64), np.array([unit.samples, len(saved)], dtype=np.float64)]
        return np.concatenate(parts)

    def resume(self, kept: Floats) -> None:
        """Go on from numbers that `snapshot` returned."""
        end = kept.size
        for unit in reversed(self._open()):
            samples, size = int(kept[end - 2]), int(kept[end - 1])
            count = (size + _WORD.itemsize - 1) // _WORD.itemsize
            words = kept[end - 2 - count : end - 2]
            unit.restore(words.astype(_WORD).tobytes()[:size], samples)
            end -= 2 + count
        self._inner.resume(kept[:end])

    def follow(self, others: Steps) -> None:
        """Go on with the FMUs of others, which computed with other values of parameters."""
        if isinstance(others, FmuSteps):
            self._units = others._units
            self._inner.follow(others._inner)

    def copy(self, problem: StepProblem, numbers: StepNumbers) -> FmuSteps:
        """Return what goes on from here with other numbers and its own instances of the FMUs."""
        made = FmuSteps(self._inner.copy(problem, numbers), problem, numbers)
        made.resume(self.snapshot())
        return made

    def rebind(self) -> None:
        """Go on with the numbers where they lie now."""
        self._inner.rebind()

    def _open(self) -> list[SampledUnit]:
        """Return the instances, initialized from the state at present where there are none."""
        if self._units is None:
            for slot in self._slots.values():
                if np.isnan(self._numbers.inputs[slot]):
                    self._numbers.inputs[slot] = 0.0
            self._units = _Units(self._problem, self._numbers, self.motion_problem, self._readers)
        return self._units.units

    def _sample(self, units: list[SampledUnit]) -> None:
        """Let those FMUs compute that are due, all from the state and the inputs until now."""
        t, x = self._numbers.t, self._numbers.x[:-1].copy()
        pairs = zip(units, self._readers, strict=True)
        due = [(unit, reader) for unit, reader in pairs if unit.due <= t + self._width]
        with self.at_present():
            values = [read_values(self.motion_problem, reader, t, x) for _, reader in due]
        for (unit, _), given in zip(due, values, strict=True):
            for name, value in unit.sample(given).items():
                self._numbers.inputs[self._slots[name]] = value

    def _part(self) -> Ending | None:
        """Take a part of a step to its end; return how it ended where that is not as usual."""
        code = self._inner.go_on()
        if code == at.FINISHED:
            return None
        ending = self._inner.end(code)
        return None if ending.status is Status.SUCCESS else ending
