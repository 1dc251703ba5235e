"""Derivatives of outputs by name: ``d udot/d q`` or ``d udot/dq``, ``d energy/d m``, ``d udot/d(q, u)``."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.recursive.udot_derivatives import columns_of_slopes
from symbody.equations.solving.slopes import acceleration_slopes
from symbody.errors import FormulationError, Problem, nearest
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol
from symbody.expr.opcodes import SYMBOL
from symbody.expr.sequences.sequence import Roots
from symbody.model.output_names import DERIVATIVE_GROUPS, DerivativeRequest


def derivative_roots(
    formed: EquationsOfMotion,
    name: str,
    asked: DerivativeRequest,
    values: Roots,
    *,
    side_by_side: bool = False,
) -> Roots:
    """Return the derivatives of `values`, the roots of the output; the last axis counts the symbols.

    All other symbols are held fixed; components of a quaternion count as independent.

    Parameters
    ----------
    side_by_side : bool
        Whether programs for several columns may be among the nodes: faster as code, but for nothing else.

    Raises
    ------
    FormulationError
        If a word is none of ``q``, ``u``, ``r``, ``s`` and no symbol of the equations, with the nearest ones.
    """
    by = tuple(chain.from_iterable(_symbols(formed, name, word) for word in asked.by))
    rows = differentiate_output(formed, asked.output, values.nodes, by, side_by_side=side_by_side)
    shape = values.shape if asked.alone else (*values.shape, len(by))
    given = values.nodes if side_by_side else ()
    return Roots(name, shape, tuple(entry.index for row in rows for entry in row), given)


def differentiate_output(
    formed: EquationsOfMotion,
    output: str,
    nodes: Sequence[int],
    by: Sequence[Symbol],
    *,
    side_by_side: bool = False,
) -> list[list[Expr]]:
    """Return the derivatives of an output, one row an entry; those of u' by way of the inverse dynamics."""
    graph = formed.graph
    places = [graph.symbol(symbol) for symbol in by]
    if output == "inverse_dynamics":
        columns = columns_of_slopes(graph, nodes, places)
        return [[Expr(graph, column[k]) for column in columns] for k in range(len(nodes))]
    first = len(formed.u) if output in ("udot", "xdot") else 0
    slopes = acceleration_slopes(formed, by, side_by_side=side_by_side) if first else []
    rest = jacobian(graph, nodes[first:], places)
    return [*slopes, *([Expr(graph, entry) for entry in row] for row in rest)]


def _symbols(formed: EquationsOfMotion, name: str, word: str) -> tuple[Symbol, ...]:
    """Return the symbols of a group or of one name; parentheses reach a symbol named like a group."""
    groups = {"q": formed.q, "u": formed.u, "r": formed.inputs, "s": formed.signal_states}
    if word in groups:
        return groups[word]
    graph, inner = formed.graph, word.strip("() ")
    node = formed.names.node(inner)
    if node is not None and graph.ops[node] == SYMBOL:
        return (graph.symbols[graph.left[node]],)
    known = [*DERIVATIVE_GROUPS, *formed.names.symbols]
    what = f"cannot differentiate by {word!r}"
    why = "it is not a symbol of these equations, or is replaced by an expression"
    raise FormulationError(Problem("equations.derivative_by", name, what, why, nearest(inner, known)))
