"""Signals of a model: those that blocks consist of too, and rings of formulas without a state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from symbody.errors import Problem
from symbody.model.element import Element
from symbody.model.signals.signal import Signal


def collect_signals(elements: Iterable[Element]) -> tuple[Signal, ...]:
    """Return the signals of a model, in its order, those of blocks and of bristles in their places."""
    return tuple(signal for element in elements for signal in element.signals)


def loop_problems(signals: Iterable[Signal]) -> list[Problem]:
    """Return a problem if values need each other in a ring; states and held values break rings."""
    values = {
        signal.name: signal.value.names
        for signal in signals
        if signal.value is not None and not signal.is_held
    }
    try:
        dependence_order({name: [word for word in names if word in values] for name, names in values.items()})
    except CycleError as error:
        return [loop_problem(error.args[1])]
    return []


def dependence_order(needed: Mapping[str, Iterable[str]]) -> list[str]:
    """Return names so that each stands after those it needs; a CycleError names a ring of them."""
    return list(TopologicalSorter(needed).static_order())


def loop_problem(ring: Iterable[str]) -> Problem:
    """Return what to say about names of which each needs the next, the first repeated at the end."""
    names = list(ring)[::-1]
    what = "signals depend on each other in a cycle: " + " -> ".join(names)
    why = "each is computed from the next at the same instant, and none of them is a state"
    fix = f'make one of them a state, for instance rate = "(.. - {names[0]})/T" with a short time T'
    return Problem("signal.loop", f"signal {names[0]}", what, why, fix)
