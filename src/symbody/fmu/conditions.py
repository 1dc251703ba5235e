"""Conditions in the formulas of a model: the branches that stay as they are between events of model exchange.

``if(x > 0, a, b)``, min, max, abs, sign and floor have branches. Each is decided by one number that passes
zero, or by the whole number below a value. An FMU decides in event mode, and keeps to it until the next.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import ModalEquations
from symbody.expr import canonical
from symbody.expr import opcodes as op
from symbody.expr.graph import TIME, Graph
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.sequence import Roots

OUTPUT: Final = "sides of conditions"
_COMPARISONS: Final = frozenset({op.LT, op.LE, op.MIN, op.MAX})
_BRANCHED: Final = _COMPARISONS | {op.ABS, op.SIGN, op.FLOOR}
# A value that is compared with more numbers than this is looked up in a table, which is continuous.
_MOST_BOUNDS: Final = 4


@dataclass(frozen=True, slots=True)
class Condition:
    """What decides a branch.

    Attributes
    ----------
    node : int
        Of the graph: a number whose sign decides, or of which the whole number below does.
    is_floor : bool
        Which of both.
    reads : tuple of str
        The quantities that it depends on, but parameters.
    """

    node: int
    is_floor: bool
    reads: tuple[str, ...]


def find_conditions(modal: ModalEquations) -> tuple[Condition, ...]:
    """Return the conditions in forces, constraints and signals that depend on the state or on inputs.

    Those in time alone are breakpoints of the motion; those that depend on accelerations are left out, and
    modes, which have events of their own.
    """
    eqs, formed = modal.eqs, modal.eqs.formed
    graph = formed.graph
    inputs = {symbol for symbol in formed.inputs if symbol.name not in modal.modes}
    moving = {*formed.u, *formed.q, *formed.signal_states, *inputs}
    usable = moving | {TIME, *formed.parameters}
    nodes = [node for node in graph.reachable(_formula_nodes(eqs)) if graph.ops[node] in _BRANCHED]
    bounds = Counter(graph.operands(node)[0] for node in nodes if _has_bound(graph, node))
    made: dict[tuple[int, bool], Condition] = {}
    for node in nodes:
        decisive, is_floor = _decisive(graph, node), graph.ops[node] == op.FLOOR
        symbols = {graph.symbols[graph.left[k]] for k in symbols_of(graph, [decisive])}
        is_table = _has_bound(graph, node) and bounds[graph.operands(node)[0]] > _MOST_BOUNDS
        if is_table or symbols.isdisjoint(moving) or not symbols <= usable or _is_solved(graph, decisive):
            continue
        if (canonical.neg(graph, decisive), is_floor) not in made:
            reads = tuple(sorted(symbol.label for symbol in symbols.intersection(moving)))
            made.setdefault((decisive, is_floor), Condition(decisive, is_floor, reads))
    return tuple(made.values())


def condition_output(conditions: tuple[Condition, ...]) -> Roots:
    """Return the output that computes what decides."""
    return Roots(OUTPUT, (len(conditions),), tuple(condition.node for condition in conditions))


def _formula_nodes(eqs: EquationSet) -> Iterator[int]:
    formed = eqs.formed
    for force in formed.dynamics.forcing:
        yield force.index
    for row in formed.rows:
        for part in (row.value, row.drift, row.gamma, *row.jacobian.values()):
            yield part.index
    if formed.signal_states:
        yield from eqs.roots("signal_rates").nodes


def _has_bound(graph: Graph, node: int) -> bool:
    """Return whether a value is compared with a number."""
    return graph.ops[node] in (op.LT, op.LE) and graph.number(graph.operands(node)[1]) is not None


def _decisive(graph: Graph, node: int) -> int:
    """Return the number whose sign, or whose whole part, decides."""
    operands = graph.operands(node)
    return canonical.sub(graph, *operands) if graph.ops[node] in _COMPARISONS else operands[0]


def _is_solved(graph: Graph, node: int) -> bool:
    return any(graph.ops[k] == op.SADDLE for k in graph.reachable([node]))
