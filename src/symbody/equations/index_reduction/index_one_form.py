"""Equations of index 1 as ``A (derivatives, reactions) = b`` on the graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.index_reduction.separation import coefficients, derivative_nodes
from symbody.errors import FormulationError, Problem
from symbody.expr.canonical import neg
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.expr.sympy.sympy_bridge import SympyEquation, SympyExpr, nodes_from_equations, nodes_from_sympy


@dataclass(frozen=True, slots=True)
class IndexOneForm:
    """``matrix (derivatives, reactions) = right`` in symbols of the state, parameters and time.

    Attributes
    ----------
    derivatives : tuple of Symbol
        The highest of each unknown.
    state : tuple of node
        What they are the rates of, then all lower derivatives down to the unknowns themselves.
    lower : list of int
        The places in the state of the rates of its later entries.
    parameters : mapping of name to node
        What needs a value.
    """

    graph: Graph
    matrix: list[list[int]]
    right: list[int]
    derivatives: tuple[Symbol, ...]
    reaction_names: tuple[str, ...]
    state: tuple[int, ...]
    state_names: tuple[str, ...]
    lower: list[int]
    parameters: Mapping[str, int]

    @property
    def unknown_names(self) -> tuple[str, ...]:
        """Names of the columns of the matrix."""
        return tuple(symbol.label for symbol in self.derivatives) + self.reaction_names


def index_one_form(
    equations: Sequence[SympyExpr | SympyEquation],
    derivatives: Sequence[SympyExpr],
    reactions: Sequence[SympyExpr],
) -> IndexOneForm:
    """Return equations, linear in derivatives and reactions, as a linear system.

    Raises
    ------
    FormulationError
        If they are not linear or not as many as the unknowns, if an unknown cannot be determined by them,
        or if they hold functions of time that are neither state nor reaction.
    """
    graph = Graph()
    rows = nodes_from_equations(equations, graph)
    rates = derivative_nodes(graph, derivatives)
    free = nodes_from_sympy(reactions, graph)
    if len(rows) != len(rates) + len(free):
        raise FormulationError(
            Problem("index_1.number", "equations",
                    f"there are {len(rows)} equations for {len(rates)} derivatives and {len(free)} reactions",
                    "one linear system can only determine as many unknowns as it has equations",
                    "add constraints differentiated twice, or name all unknowns")
        )  # fmt: skip
    highest = tuple(graph.symbols[graph.left[node]] for node in rates)
    state = _state(highest)
    nodes = tuple(graph.symbol(symbol) for symbol in state)
    matrix, rest = coefficients(graph, rows, [*rates, *free])
    names = tuple(graph.symbols[graph.left[node]].label for node in free)
    _check_columns(graph, matrix, tuple(symbol.label for symbol in highest) + names)
    parameters = _parameters(graph, [*(entry for row in matrix for entry in row), *rest], nodes)
    place = {symbol: k for k, symbol in enumerate(state)}
    lower = [place[symbol.derivative] for symbol in state[len(highest) :]]
    return IndexOneForm(
        graph, matrix, [neg(graph, node) for node in rest], highest, names, nodes,
        tuple(symbol.label for symbol in state), lower, parameters,
    )  # fmt: skip


def _state(highest: Sequence[Symbol]) -> list[Symbol]:
    """Return what each derivative is the rate of, then what these are the rates of, and so on."""
    state: list[Symbol] = []
    level = list(highest)
    while level:
        level = [Symbol(symbol.name, symbol.kind, symbol.order - 1) for symbol in level if symbol.order]
        state += level
    return state


def _check_columns(graph: Graph, matrix: Sequence[Sequence[int]], names: Sequence[str]) -> None:
    """Refuse unknowns that stand in no equation: the system is singular at every state."""
    missing = [name for k, name in enumerate(names) if all(find_zeros(graph, [row[k] for row in matrix]))]
    if missing:
        raise FormulationError(
            Problem("index_1.open", "equations", f"{', '.join(missing)} appear in no equation",
                    "the equations are of higher index than 1, or an unknown has no equation",
                    "differentiate constraints until they contain the highest derivatives")
        )  # fmt: skip


def _parameters(graph: Graph, nodes: Sequence[int], state: Sequence[int]) -> dict[str, int]:
    """Return the parameters; functions of time that are neither state nor unknown are refused."""
    parameters, strange = {}, []
    for node in symbols_of(graph, nodes):
        symbol = graph.symbols[graph.left[node]]
        if symbol.kind == SymbolKind.PARAMETER:
            parameters[symbol.name] = node
        elif symbol.kind != SymbolKind.TIME and node not in state:
            strange.append(symbol.label)
    if strange:
        raise FormulationError(
            Problem("index_1.unknowns", "equations",
                    f"{', '.join(strange)} are neither among the unknowns nor in the state",
                    "inputs have no value here, and every unknown must appear with its derivative or be a "
                    "reaction",
                    "substitute a formula for each input, and name all unknowns")
        )  # fmt: skip
    return parameters
