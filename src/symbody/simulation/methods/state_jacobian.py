"""Derivatives of equations by states, as further outputs that can be compiled like any other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from symbody.codegen.compile import Value, constant_values
from symbody.equations.equation_set import EquationSet
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import substitute
from symbody.expr.sequence import Roots

STATE_RATES: Final = "state rates"
STATE_JACOBIAN: Final = "state jacobian"


def without_idle_rows(eqs: EquationSet, parameters: Mapping[str, Value]) -> EquationSet:
    """Return the equations without constraints that are fulfilled whatever moves, for these parameters."""
    if not eqs.multiplier_names:
        return eqs
    values = constant_values(eqs, {name: name for name in eqs.parameter_names}, parameters)
    formed = eqs.for_values(values).formed
    rows = tuple(row for row in formed.rows if any(not slope.is_zero for slope in row.slopes.values()))
    return EquationSet(eqs.model, formed.with_rows(rows), eqs.notes)


def with_outputs(
    eqs: EquationSet, outputs: Iterable[Roots], arguments: Mapping[str, Symbol] | None = None
) -> EquationSet:
    """Return the equations with more outputs; the symbols in `arguments` become further inputs."""
    formed, given = eqs.formed, arguments or {}
    symbols = {name: Expr(formed.graph, formed.graph.symbol(symbol)) for name, symbol in given.items()}
    inputs = (*formed.inputs, *(Symbol(name, symbol.kind) for name, symbol in given.items()))
    wider = replace(formed, names=formed.names.with_values(symbols), inputs=inputs)
    return EquationSet(eqs.model, wider, eqs.notes, {roots.name: roots for roots in outputs})


def with_laws(eqs: EquationSet, nodes: Sequence[int], laws: Mapping[str, Value]) -> list[int]:
    """Return nodes with the inputs replaced by their laws, so that derivatives see what these read."""
    names = eqs.formed.names
    replaced = {
        names.value(name).index: names.expression(Formula.of(law, where=f"input {name}")).index
        for name, law in laws.items()
    }
    return substitute(eqs.formed.graph, nodes, replaced)


def partial_derivatives(eqs: EquationSet, name: str, nodes: Sequence[int], by: Sequence[Symbol]) -> Roots:
    """Return the matrix of derivatives of `nodes` by symbols as an output."""
    graph = eqs.formed.graph
    rows = jacobian(graph, nodes, [graph.symbol(symbol) for symbol in by])
    return Roots(name, (len(nodes), len(by)), tuple(entry for row in rows for entry in row))


def with_state_jacobian(eqs: EquationSet, laws: Mapping[str, Value]) -> EquationSet:
    """Return the equations with the outputs `STATE_RATES`, x' in the order (u, q), and `STATE_JACOBIAN`."""
    rates = with_laws(eqs, eqs.roots("xdot").nodes, laws)
    by = (*eqs.formed.u, *eqs.formed.q)
    derivatives = partial_derivatives(eqs, STATE_JACOBIAN, rates, by)
    return with_outputs(eqs, [Roots(STATE_RATES, (len(rates),), tuple(rates)), derivatives])
