"""`HeldSignals`: all held values of a mechanism in one motion, those that move it apart from the others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.formation.values import constant_values
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import switches
from symbody.errors import Problem, UsageError
from symbody.model.model import Model
from symbody.model.signals.signal import Signal
from symbody.simulation.events.events import Event
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.held_law import HeldLaw, HeldRecord, join_records
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.sampling.sampled_loop import SampledLoop
from symbody.simulation.sampling.sampler import HeldValue, Sampler
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]

# Sample times below this share of the times of a motion are lost in rounding.
_SHORTEST: Final = 1e-13
_NOTHING: Final = Sampler((), 0.0, 0)


class HeldSignals:
    """All held values of a mechanism in one motion; none for most.

    Those that nothing in the motion reads change nothing in it: they are sampled from its steps afterwards.
    Beside FMUs all are sampled on the way, before an FMU at the same instant computes its inputs anew.

    Parameters
    ----------
    eqs : EquationSet
        Whose model has held values.
    values : sequence of HeldValue
        In the order of the model.
    start : float
        When samples are counted from [s].
    fmus : sequence of FmuInput
        Laws of inputs. The first samples wait for what FMUs compute first, unless these read held values.
    """

    def __init__(
        self, eqs: EquationSet, values: Sequence[HeldValue], start: float, *, fmus: Sequence[FmuInput] = ()
    ) -> None:
        self._eqs = eqs
        self._fmus = tuple(fmus)
        self._start = start
        self._values = tuple(values)
        self.active = self._make_sampler(self._values) if values else _NOTHING
        self.passive: tuple[Sampler, ...] = ()

    def _make_sampler(self, values: Sequence[HeldValue]) -> Sampler:
        return Sampler(values, self._start, len(self._eqs.speed_names))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the values, in the order of the model."""
        return tuple(value.name for value in self._values)

    @property
    def laws(self) -> dict[str, HeldLaw]:
        """The values as inputs."""
        return {name: HeldLaw(self, name) for name in self.names}

    @property
    def record(self) -> HeldRecord | None:
        """What was sampled."""
        if not self._values:
            return None
        samplers = [sampler for sampler in (self.active, *self.passive) if sampler.values]
        return join_records([sampler.samples for sampler in samplers], self.names)

    def others(self, given: Mapping[str, Value] | None) -> dict[str, Value]:
        """Return what is given by name without held values."""
        return {name: value for name, value in (given or {}).items() if name not in self.names}

    def current(self, name: str) -> float:
        """Return a value at present."""
        return self._sampler(name).current(name)

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at times (N,) that the motion has passed."""
        return self._sampler(name).values_at(name, t)

    def _sampler(self, name: str) -> Sampler:
        return next(sampler for sampler in (self.active, *self.passive) if name in sampler.names)

    def pose(self, problem: SimulationProblem, events: Sequence[Event] = ()) -> SimulationProblem:
        """Return the problem with what samples the values that the motion reads, directly or through others.

        Where the equations may change on the way, it is taken to read all.
        """
        if not self._values:
            return problem
        self.place(problem.laws)
        changes = switches(problem.eqs.formed) or may_jump(problem.eqs) or bool(self._fmus)
        read = set(self.names) if changes else self._values_read(problem, events)
        self.active = self._make_sampler([value for value in self._values if value.name in read])
        runs = groupby(self._values, lambda value: value.name in read)
        self.passive = tuple(self._make_sampler(list(run)) for is_read, run in runs if not is_read)
        return self._sample_first(replace(problem, sampler=self.active)) if read else problem

    def _sample_first(self, problem: SimulationProblem) -> SimulationProblem:
        """Return the problem after the first samples: what follows from a state follows from them too."""
        first = problem.first
        if first is not None and (not self._fmus or self._read_by_fmus(problem)):
            x = np.array([*first.u.values(), *first.q.values(), *first.s.values(), 0.0])
            SampledLoop(problem, self.active).take(first.t, x)
        return problem

    def _read_by_fmus(self, problem: SimulationProblem) -> bool:
        """Return whether what an FMU reads depends on held values."""
        outputs = {output for law in self._fmus for output in law.reads.values()}
        return bool(outputs) and bool(inputs_read(problem.compile_outputs(sorted(outputs))) & set(self.names))

    def place(self, laws: InputLaws) -> None:
        """Find the values among the inputs that compiled functions take; the motion may read all."""
        slots = {name: place for place, name in enumerate(laws.callbacks)}
        self._values = tuple(replace(value, slot=slots[value.name]) for value in self._values)
        self.active = self._make_sampler(self._values)

    def _values_read(self, problem: SimulationProblem, events: Sequence[Event]) -> set[str]:
        functions = [problem.compile_outputs(("xdot", "power"))]
        if events:
            functions.append(problem.compile_outputs([str(event.expression) for event in events]))
        formulas = [str(value) for event in events for value in event.mapping.values()]
        if formulas:
            functions.append(problem.compile_outputs(["energy", *formulas]))
        read = {name for function in functions for name in inputs_read(function)} & set(self.names)
        return self._sources_of(read, problem) if read else read

    def _sources_of(self, names: Iterable[str], problem: SimulationProblem) -> set[str]:
        """Return the values from which some are computed, through others too."""
        model = self._eqs.model
        signals = {signal.name: signal for signal in (*model.signals, *model.held_signals)}
        needed: set[str] = set()
        waiting = list(names)
        while waiting:
            signal = signals.get(waiting.pop())
            if signal is None or signal.name in needed:
                continue
            needed.add(signal.name)
            formulas = [formula for formula in (signal.value, signal.rate) if formula is not None]
            if signal.output is not None or any("'" in formula.text for formula in formulas):
                waiting += self.names  # an output may depend on any
            waiting += [name for formula in formulas for name in formula.names]
        return needed & set(self.names)


def inputs_read(function: CompiledFunction) -> set[str]:
    """Return the inputs that a function depends on."""
    return {entry.name for entry in function.shared_sequence.inputs if entry.group == "r"}


def held_signals(
    eqs: EquationSet,
    span: tuple[float, float],
    parameters: Mapping[str, Value] | None,
    initial: Mapping[str, Value] | None,
    inputs: Mapping[str, object],
) -> HeldSignals:
    """Return the held values of a motion.

    Parameters
    ----------
    initial : mapping of name to number or formula
        Values before the first sample, among others; by default those of the model.
    inputs : mapping of name to law
        Held values are not inputs of the caller.

    Raises
    ------
    UsageError
        If sample times are not positive, the motion runs backwards, or a held value is given as an input.
    """
    signals = eqs.model.held_signals if isinstance(eqs.model, Model) else ()
    if not signals:
        return HeldSignals(eqs, (), span[0])
    _check_direction(signals, span)
    _check_inputs(signals, inputs)
    parameter_set(eqs, parameters).require_possible()
    given = initial or {}
    steps = constant_values(eqs, {s.name: s.sample for s in signals if s.sample is not None}, parameters)
    starts = constant_values(eqs, {s.name: given.get(s.name, s.initial) for s in signals}, parameters)
    _check_steps(signals, steps, span)
    values = [HeldValue(s.name, s.output or str(s.value), 0, steps[s.name], starts[s.name]) for s in signals]
    fmus = [law for law in inputs.values() if isinstance(law, FmuInput)]
    return HeldSignals(eqs, values, span[0], fmus=fmus)


def _check_inputs(signals: Sequence[Signal], inputs: Mapping[str, object]) -> None:
    problems = [
        Problem("signal.held_input", f"input {signal.name}", f"{signal.name} is a sampled signal",
                "its value is computed from the motion",
                "leave it out, or give the model an input of another name")
        for signal in signals if signal.name in inputs
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def _check_direction(signals: Sequence[Signal], span: tuple[float, float]) -> None:
    if span[1] < span[0]:
        listed = ", ".join(signal.name for signal in signals)
        raise UsageError(
            Problem("signal.backwards", "t_end", f"time runs backward, but these values are sampled: "
                                                 f"{listed}",
                    "a sampled value depends on the motion before",
                    "simulate forward in time, or form the equations of sb.without_sampling(model)")
        )  # fmt: skip


def _check_steps(signals: Sequence[Signal], steps: Mapping[str, float], span: tuple[float, float]) -> None:
    shortest = _SHORTEST * max(abs(span[0]), abs(span[1]))
    problems = [
        Problem("signal.sample", f"signal {signal.name}, sample",
                f"the time between samples is {steps[signal.name]:.6g} s",
                "samples are taken at the start and after every such time" if not steps[signal.name] > 0.0
                else f"times as large as {max(map(abs, span)):.6g} s cannot be represented that accurately",
                "give seconds, such as sample = 0.01")
        for signal in signals if not steps[signal.name] > shortest
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def sample_later(held: HeldSignals, problem: SimulationProblem, motion: DenseOutput | None) -> None:
    """Sample what a motion did not read, in the order of the model, from its steps.

    Raises
    ------
    FormulationError, UsageError
        If a formula of a value has no meaning, or is not a number.
    SimulationError
        If a function fails.
    """
    if not held.passive or motion is None:
        return
    loops = [SampledLoop(problem, sampler) for sampler in held.passive]
    last = float(motion.breaks[-1])
    t = _next_due(held)
    while t <= last or any(sampler.is_due(last) for sampler in held.passive):
        t = min(t, last)
        x = np.ascontiguousarray(motion(np.array([t]))[:, 0])
        for loop in loops:
            if loop.sampler.is_due(t):
                others = list(_values_of_others(held, loop.sampler, t))
                if others:
                    slots, values = zip(*others, strict=True)
                    loop.show_inputs(np.array(slots), np.array(values, dtype=np.float64))
                loop.take(t, x)
        t = _next_due(held)


def _next_due(held: HeldSignals) -> float:
    return min(sampler.next_due for sampler in held.passive)


def _values_of_others(held: HeldSignals, own: Sampler, t: float) -> Iterator[tuple[int, float]]:
    """Yield places among the inputs and values of all that another sampler holds.

    What comes first in the model is new already where both are sampled at the time.
    """
    first = held.names.index(own.names[0])
    for sampler in (held.active, *held.passive):
        if sampler is own:
            continue
        for value in sampler.values:
            if sampler is not held.active:
                yield value.slot, sampler.current(value.name)
            elif held.names.index(value.name) < first:
                yield value.slot, float(sampler.values_at(value.name, np.array([t]))[0])
            else:
                yield value.slot, sampler.value_before(value.name, t)
