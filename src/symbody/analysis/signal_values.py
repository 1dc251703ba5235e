"""Values of the states of signals at the start: those of the model, or what a user gives by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import constant_values
from symbody.equations.equation_set import EquationSet

Floats = NDArray[np.float64]
_NOTHING: Mapping[str, Value] = {}


def signal_values(
    eqs: EquationSet, given: Mapping[str, Value] = _NOTHING, parameters: Mapping[str, Value] | None = None
) -> Floats:
    """Return the states of signals (n_s,): those `given`, the others as the model has them.

    Raises
    ------
    CompileError, ExpressionError
        If a parameter has no value, or a formula reads something else than parameters.
    """
    names = eqs.signal_state_names
    if not names:
        return np.zeros(0)
    initial = {signal.name: signal.initial for signal in eqs.model.signals if signal.is_state}
    formulas = {name: given.get(name, initial[name]) for name in names}
    return np.array(list(constant_values(eqs, formulas, parameters).values()), dtype=np.float64)


def split_signals(
    eqs: EquationSet,
    fixed: Mapping[str, Value] | None,
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
) -> tuple[Floats, dict[str, Value], dict[str, Value]]:
    """Return the states of signals (n_s,), and what is fixed and guessed of all else."""
    signals = signal_values(eqs, {**(guess or {}), **(fixed or {})}, parameters)
    return signals, without_signals(eqs, fixed or {}), without_signals(eqs, guess or {})


def without_signals(eqs: EquationSet, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is given by name without the states of signals."""
    states = set(eqs.signal_state_names)
    return {name: value for name, value in given.items() if name not in states}


def signals_by_name(eqs: EquationSet, values: Floats) -> dict[str, float]:
    """Return the states of signals by name."""
    return dict(zip(eqs.signal_state_names, values.tolist(), strict=True))
