"""Held values of a mechanism in an FMU: discrete variables, computed anew at their samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.model.model import Model
from symbody.simulation.native.description import Floats
from symbody.simulation.sampling.held_signals import held_signals
from symbody.simulation.sampling.sampler import HeldValue, Sampler

_START: Final = 0.0  # of the default experiment [s]


@dataclass(frozen=True, slots=True, eq=False)
class FmuSamples:
    """What is held between samples; empty for most mechanisms.

    Attributes
    ----------
    values : tuple of HeldValue
        In the order of the model; `slot` is the place among the inputs that functions take.
    periods : tuple of str
        The formulas of the sample times, each once.
    groups : tuple of int
        Place in `periods` of the sample time of each value.
    """

    values: tuple[HeldValue, ...] = ()
    periods: tuple[str, ...] = ()
    groups: tuple[int, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the values."""
        return tuple(value.name for value in self.values)

    @property
    def formulas(self) -> tuple[str, ...]:
        """The formulas of new values."""
        return tuple(value.formula for value in self.values)

    def block(self, speed_count: int) -> Floats:
        """Return the array of a `SampleHold`, for a record of one row."""
        if not self.values:
            return np.zeros(SampleHold.size)
        # one group for each formula: parameters may set apart sample times that are the same at first
        pairs = list(zip(self.values, self.groups, strict=True))
        apart = [replace(value, step=float(group)) for value, group in pairs]
        sampler = Sampler(apart, _START, speed_count)
        steps = {group: value.step for value, group in pairs}
        np.asarray(sampler.hold.steps)[:] = [steps[group] for group in dict.fromkeys(self.groups)]
        sampler.hold.room = 1
        return sampler.block


def fmu_samples(
    eqs: EquationSet, initial: Mapping[str, Value], parameters: Mapping[str, Value], span: tuple[float, float]
) -> FmuSamples:
    """Return the held values of a mechanism.

    Raises UsageError if sample times are not positive.

    Parameters
    ----------
    initial : mapping
        Values before the first sample, among others.
    """
    signals = eqs.model.held_signals if isinstance(eqs.model, Model) else ()
    if not signals:
        return FmuSamples()
    held = held_signals(eqs, span, parameters, initial, {})
    places = {name: place for place, name in enumerate(eqs.input_names)}
    values = tuple(replace(value, slot=places[value.name]) for value in held.active.values)
    formulas = [str(signal.sample) for signal in signals]
    periods = tuple(dict.fromkeys(formulas))
    return FmuSamples(values, periods, tuple(periods.index(formula) for formula in formulas))
