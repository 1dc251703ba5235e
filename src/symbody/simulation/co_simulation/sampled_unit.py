"""`SampledUnit`: an FMU that computes inputs of a mechanism at its samples, and what it reads there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.function import CompiledFunction
from symbody.errors import Problem, SimulationError, UsageError
from symbody.simulation.co_simulation.fmu_unit import FmuUnit
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]


class SampledUnit:
    """An FMU with the inputs it computes, and when it takes its next sample.

    Attributes
    ----------
    reader : CompiledFunction or None
        What computes the values that it reads.
    period : float
        Seconds between samples.
    """

    def __init__(
        self, inputs: Mapping[str, FmuInput], unit: FmuUnit, reader: CompiledFunction | None, start: float
    ) -> None:
        self.reader = reader
        self.period = next(iter(inputs.values())).period
        self._inputs = inputs
        self._unit = unit
        self._start = start
        self._samples = 0

    @property
    def due(self) -> float:
        """When the next sample is taken [s]."""
        return self._start + self._samples * self.period

    def sample(self, values: Sequence[float]) -> dict[str, float]:
        """Take a step; return the new values of the inputs."""
        laws = self._inputs
        before = {name: self._unit.output(law.output) for name, law in laws.items() if law.is_late}
        self._unit.step(values, self.due, self.period)
        self._samples += 1
        behind = {name: self._unit.output(law.output) for name, law in laws.items() if not law.is_late}
        return before | behind

    @property
    def samples(self) -> int:
        """How many samples were taken."""
        return self._samples

    def save(self) -> bytes:
        """Return the state of the FMU.

        Raises
        ------
        UsageError
            If it keeps none.
        SimulationError
            If the FMU refuses.
        """
        return self._unit.save()

    def restore(self, saved: bytes, samples: int) -> None:
        """Go on from a state of the FMU, after so many samples.

        Raises
        ------
        UsageError, SimulationError
            As `save`.
        """
        self._unit.restore(saved)
        self._samples = samples


def by_instance(inputs: Mapping[str, FmuInput]) -> list[dict[str, FmuInput]]:
    """Return the inputs in groups of one instance."""
    groups: dict[object, dict[str, FmuInput]] = {}
    for name, law in inputs.items():
        groups.setdefault(law.instance, {})[name] = law
    return [*groups.values()]


def make_reader(problem: SimulationProblem, inputs: Mapping[str, FmuInput]) -> CompiledFunction | None:
    """Return what computes the values that an FMU reads.

    Raises
    ------
    UsageError
        If one is no number.
    """
    name, law = next(iter(inputs.items()))
    if not law.reads:
        return None
    function = problem.compile_outputs(tuple(law.reads.values()), quick=True)
    problems = [
        Problem("fmu_input.no_number", f"input {name}, reads", f"{output.name} has shape {output.shape}",
                "a variable of an FMU is a single number", "name one component, such as 'reaction A Fx'")
        for output in function.outputs if output.shape
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return function


def read_values(
    problem: SimulationProblem, reader: CompiledFunction | None, t: float, x: Floats
) -> list[float]:
    """Return what an FMU reads in a state x = (u, q, s).

    Raises
    ------
    SimulationError
        If a value is not finite.
    """
    if reader is None:
        return []
    n_u = len(problem.eqs.speed_names)
    u, q = x[:n_u], x[n_u:]
    inputs = np.array(problem.laws.evaluate(t, q, u))
    computed = reader(t, q, u, inputs)
    values = [float(value) for value in (computed if len(reader.outputs) > 1 else (computed,))]
    faults = list(_not_finite(reader, values))
    if faults:
        what = f"at t = {t:.9g} s {', '.join(faults)}"
        fix = "connect the FMU to outputs that are defined throughout the motion"
        raise SimulationError(Problem("fmu_input.not_finite", "reads", what, "", fix))
    return values


def _not_finite(reader: CompiledFunction, values: Sequence[float]) -> Iterator[str]:
    for output, value in zip(reader.outputs, values, strict=True):
        if not np.isfinite(value):
            yield f"{output.name} is {value}"
