"""States that are found in other equations of the same mechanism, those in which it is closed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.configurations.closed_gaps import with_closed_gaps
from symbody.analysis.constraint_evaluator import constraint_evaluator
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.equations.closing_equations import closing_equations, follower_names, follower_outputs
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements

Floats = NDArray[np.float64]


def substituted_state(eqs: EquationSet, whole: State, scales: Mapping[str, float] | None) -> State:
    """Return a state of `closing_equations` in the equations that they close."""
    taut = unilateral_elements(whole.eqs.formed)
    own = with_closed_gaps(eqs, taut) if len(taut) < len(unilateral_elements(eqs.formed)) else eqs
    mechanism = mechanism_scales(own, whole.parameters, scales, {**whole.q, **whole.u})
    signals = np.array([whole.s[name] for name in own.signal_state_names])
    evaluator = constraint_evaluator(own, whole.parameters, whole.inputs, whole.t, mechanism, signals=signals)
    q = np.array([whole.q[name] for name in own.coordinate_names])
    u = np.array([whole.u[name] for name in own.speed_names])

    def others() -> Iterator[State]:
        return (substituted_state(eqs, other, scales) for other in whole.branches)

    state = complete_state(evaluator, q, u, q, {}, others)
    return replace(state, moved=whole.moved)


def with_followers(
    eqs: EquationSet, near: Mapping[str, float], parameters: Mapping[str, Value]
) -> dict[str, float]:
    """Return states with the substituted coordinates, where all others are there, and so with their rates."""
    if closing_equations(eqs) is eqs:
        return dict(near)
    names = follower_names(eqs)
    half = len(names) // 2
    given = dict.fromkeys(names[:half], near.keys() >= {*eqs.coordinate_names})
    given |= dict.fromkeys(names[half:], near.keys() >= {*eqs.speed_names})
    if not any(given.values()):
        return dict(near)
    function = bound_function(
        eqs, follower_outputs(eqs), parameters, (), dict.fromkeys(eqs.input_names, 0), quick=True
    )
    q, u = (
        np.array([near.get(name, 0.0) for name in group]) for group in (eqs.coordinate_names, eqs.speed_names)
    )
    values = zip(names, np.ravel(function(0.0, q, u)).tolist(), strict=True)
    return {name: value for name, value in values if given[name]} | dict(near)
