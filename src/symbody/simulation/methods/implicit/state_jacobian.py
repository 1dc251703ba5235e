"""Derivatives of the rates of states by states, as an output that can be compiled like any other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from symbody.analysis.derivatives import laws_key, partial_derivatives, with_laws, with_outputs
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.equations.equation_set import EquationSet
from symbody.expr.graph import Symbol
from symbody.expr.sequences.sequence import Roots

STATE_RATES: Final = "state rates"
STATE_JACOBIAN: Final = "state jacobian"
CALLBACK_JACOBIAN: Final = "callbacks jacobian"


def drop_idle_rows(eqs: EquationSet, parameters: Mapping[str, Value]) -> EquationSet:
    """Return the equations without constraints that are fulfilled whatever moves, for these parameters."""
    if not eqs.multiplier_names:
        return eqs
    chosen = parameter_set(eqs, parameters).eqs
    without: EquationSet = chosen.plans.get("without idle rows", lambda: _without_idle_rows(chosen))
    return without


def _without_idle_rows(eqs: EquationSet) -> EquationSet:
    formed = eqs.formed
    moving = [any(not slope.is_zero for slope in row.jacobian.values()) for row in formed.rows]
    kept = [k for k, is_moving in enumerate(moving) if is_moving]
    return EquationSet(eqs.model, formed.with_independent(kept), eqs.notes)


def with_state_jacobian(
    eqs: EquationSet, laws: Mapping[str, Value], callbacks: Iterable[str] = ()
) -> EquationSet:
    """Return the equations with the outputs `STATE_RATES`, x' in the order (u, q, s), and `STATE_JACOBIAN`.

    With them is `CALLBACK_JACOBIAN`, the derivatives of the same by the inputs in `callbacks`.
    """
    names = tuple(callbacks)
    key = "state jacobian", laws_key(laws), names
    wider: EquationSet = eqs.variants.get(key, lambda: _with_state_jacobian(eqs, laws, names))
    return wider


def _with_state_jacobian(
    eqs: EquationSet, laws: Mapping[str, Value], callbacks: Iterable[str]
) -> EquationSet:
    rates = with_laws(eqs, eqs.roots("xdot").nodes, laws)
    by = (*eqs.formed.u, *eqs.formed.q, *eqs.formed.signal_states)
    derivatives = partial_derivatives(eqs, STATE_JACOBIAN, rates, by)
    by_callbacks = partial_derivatives(eqs, CALLBACK_JACOBIAN, rates, input_symbols(eqs, callbacks))
    return with_outputs(eqs, [Roots(STATE_RATES, (len(rates),), tuple(rates)), derivatives, by_callbacks])


def input_symbols(eqs: EquationSet, names: Iterable[str]) -> list[Symbol]:
    """Return the symbols of inputs."""
    known = {symbol.name: symbol for symbol in eqs.formed.inputs}
    return [known[name] for name in names]
