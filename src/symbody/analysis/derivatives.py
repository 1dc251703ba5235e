"""Derivatives of equations by states and inputs, as further outputs that can be compiled like any other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.input_formulas import input_law_nodes
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.sequence import Roots


def with_outputs(
    eqs: EquationSet, outputs: Iterable[Roots], arguments: Mapping[str, Symbol] | None = None
) -> EquationSet:
    """Return the equations with more outputs; the symbols in `arguments` become further inputs."""
    formed, given = eqs.formed, arguments or {}
    symbols = {name: Expr(formed.graph, formed.graph.symbol(symbol)) for name, symbol in given.items()}
    inputs = [Symbol(name, symbol.kind) for name, symbol in given.items()]
    wider = formed.with_names(symbols, inputs)
    return EquationSet(eqs.model, wider, eqs.notes, {roots.name: roots for roots in outputs})


def laws_key(laws: Mapping[str, Value | None]) -> tuple[tuple[str, str], ...]:
    """Return what tells laws of inputs from others, as part of a key of plans."""
    return tuple([(name, str(law)) for name, law in laws.items()])


def with_laws(eqs: EquationSet, nodes: Sequence[int], laws: Mapping[str, Value]) -> list[int]:
    """Return nodes with the inputs replaced by their laws, so that derivatives see what these read."""
    names = eqs.formed.names
    replaced = {names.value(name).index: node for name, node in input_law_nodes(eqs.formed, laws).items()}
    return substitute(eqs.formed.graph, nodes, replaced)


def partial_derivatives(eqs: EquationSet, name: str, nodes: Sequence[int], by: Sequence[Symbol]) -> Roots:
    """Return the matrix of derivatives of `nodes` by symbols as an output."""
    graph = eqs.formed.graph
    rows = jacobian(graph, nodes, [graph.symbol(symbol) for symbol in by])
    return Roots(name, (len(nodes), len(by)), tuple(entry for row in rows for entry in row))
