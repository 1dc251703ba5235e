"""Held values that a motion did not read: sampled from its steps, when it is over."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.sampling.held_signals import HeldSignals
from symbody.simulation.sampling.sampled_loop import SampledLoop
from symbody.simulation.sampling.sampler import Sampler
from symbody.simulation.simulation_problem import SimulationProblem

Floats = NDArray[np.float64]


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
