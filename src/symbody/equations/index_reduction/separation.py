"""`separate_derivatives`: equations that determine derivatives, and those hidden among them that do not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from symbody.arguments import checked_arguments
from symbody.equations.index_reduction.rate_elimination import eliminate_rates
from symbody.errors import FormulationError, Problem
from symbody.expr.calculus import gradient, linear_coefficients, time_derivative
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.opcodes import SYMBOL
from symbody.expr.rewrite import symbols_of, tree_size
from symbody.expr.sympy.closed_form import readable
from symbody.expr.sympy.sympy_bridge import (
    SympyExpr,
    nodes_from_equations,
    nodes_from_sympy,
    to_sympy_with_definitions,
)

# Nodes of equations longer than this are given back as they are.
_READABLE: Final = 2_000


@dataclass(frozen=True, slots=True)
class Separated:
    """Equations parted on the graph, each a node that is 0.

    Attributes
    ----------
    differential : list of node
        Those that determine a derivative, as they were given.
    algebraic : list of node
        What the others say when the derivatives are eliminated.
    rates : list of node
        The time derivatives of these.
    pivots : list of node
        What is taken to be nonzero, numbers left out.
    dropped : tuple of int
        Places of the equations that follow from the others.
    """

    differential: list[int]
    algebraic: list[int]
    rates: list[int]
    pivots: list[int]
    dropped: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Separation:
    """Equations separated by whether they determine derivatives; unpacks as ``(equations, algebraic)``.

    Attributes
    ----------
    equations : list of SymPy expressions
        As many as were given less those `dropped`, each equal to 0: those that determine a derivative, then
        the time derivatives of `algebraic`.
    algebraic : list of SymPy expressions
        The hidden constraints, each equal to 0, without the derivatives.
    assumed_nonzero : tuple of SymPy expressions
        The pivots: where one vanishes, the equations may mean something else.
    dropped : tuple of int
        Places of the equations that follow from the others.
    definitions : tuple of (symbol, expression)
        z1, z2, ... in which formulas beyond 20,000 operations are written.

    Examples
    --------
    >>> import sympy as sp
    >>> import symbody as sb
    >>> t = sp.Symbol("t")
    >>> x, y = sp.Function("x")(t), sp.Function("y")(t)
    >>> result = sb.separate_derivatives([x.diff(t) - y, x - sp.sin(t)], [x.diff(t), y.diff(t)])
    >>> result.algebraic
    [x(t) - sin(t)]
    """

    equations: list[SympyExpr]
    algebraic: list[SympyExpr]
    assumed_nonzero: tuple[SympyExpr, ...] = ()
    dropped: tuple[int, ...] = ()
    definitions: tuple[tuple[SympyExpr, SympyExpr], ...] = field(default=(), repr=False)

    def __iter__(self) -> Iterator[list[SympyExpr]]:
        """Return what ``dae, algebraic = ...`` takes."""
        return iter((self.equations, self.algebraic))


@checked_arguments
def separate_derivatives(equations: Sequence[SympyExpr], derivatives: Sequence[SympyExpr]) -> Separation:
    """Split equations that determine derivatives from the constraints hidden among them.

    Parameters
    ----------
    equations : sequence of SymPy expressions or equations
        Linear in the derivatives; an expression stands for an equation with 0.
    derivatives : sequence of SymPy derivatives
        ``x.diff(t)`` of every unknown x, the reactions or multipliers among them.

    Returns
    -------
    Separation
        ``equations`` is what the next call takes: three calls take the equations of a mechanism with
        constraints (index 3) to ordinary differential equations, and give positions, velocities and
        accelerations as hidden constraints.

    Raises
    ------
    FormulationError
        If an equation is not linear in the derivatives, or contradicts the others.

    Examples
    --------
    >>> import sympy as sp
    >>> import symbody as sb
    >>> t = sp.Symbol("t")
    >>> x, y, z = (sp.Function(name)(t) for name in "xyz")
    >>> first = sb.separate_derivatives([x.diff(t) - y, x - sp.sin(t)], [x.diff(t), y.diff(t)])
    >>> first.algebraic
    [x(t) - sin(t)]
    """
    graph = Graph()
    rows = nodes_from_equations(equations, graph)
    rates = derivative_nodes(graph, derivatives)
    parted = separate(graph, rows, rates)
    count = len(parted.differential)
    shown = [*parted.differential, *parted.rates, *parted.algebraic, *parted.pivots]
    found, definitions = to_readable_sympy(graph, shown)
    stop = count + len(parted.rates)
    end = stop + len(parted.algebraic)
    return Separation(found[:stop], found[stop:end], tuple(found[end:]), parted.dropped, tuple(definitions))


def separate(graph: Graph, rows: Sequence[int], rates: Sequence[int]) -> Separated:
    """Part equations on the graph; see `separate_derivatives`."""
    matrix, rest = coefficients(graph, rows, rates)
    found = eliminate_rates(graph, matrix, rest)
    dropped = tuple(i for i, node in found.left.items() if not node)
    algebraic = [node for node in found.left.values() if node]
    _check_consistent(graph, {i: node for i, node in found.left.items() if node})
    pivots = [node for node in found.pivots.values() if graph.number(node) is None]
    return Separated(
        [rows[i] for i in sorted(found.pivots)],
        algebraic,
        time_derivative(graph, algebraic),
        list(dict.fromkeys(pivots)),
        dropped,
    )


def derivative_nodes(graph: Graph, derivatives: Sequence[SympyExpr]) -> list[int]:
    """Return the symbols that derivatives are in the graph.

    Raises
    ------
    FormulationError
        For what is not a time derivative of a function of time, and for doubles.
    """
    nodes = nodes_from_sympy(derivatives, graph)
    problems = []
    for k, (node, given) in enumerate(zip(nodes, derivatives, strict=True)):
        what = "is given twice" if node in nodes[:k] else ""
        if graph.ops[node] != SYMBOL or not graph.symbols[graph.left[node]].order:
            what = "is not the time derivative of an unknown"
        if what:
            problems.append(
                Problem("reduction.derivative", f"derivative {k}", f"{given} {what}", "",
                        "give [x.diff(t) for x in unknowns], each unknown once")
            )  # fmt: skip
    if problems:
        raise FormulationError(*problems)
    return nodes


def to_readable_sympy(
    graph: Graph, nodes: Sequence[int]
) -> tuple[list[SympyExpr], list[tuple[SympyExpr, SympyExpr]]]:
    """Return nodes as SymPy expressions, short ones in the form in which people read them."""
    short = [node for node in dict.fromkeys(nodes) if tree_size(graph, node) <= _READABLE]
    forms = dict(zip(short, readable(graph, short), strict=True))
    return to_sympy_with_definitions(graph, [forms.get(node, node) for node in nodes])


def coefficients(
    graph: Graph, rows: Sequence[int], unknowns: Sequence[int]
) -> tuple[list[list[int]], list[int]]:
    """Return A and b of ``A unknowns + b``.

    Raises
    ------
    FormulationError
        If an equation is not linear in an unknown, naming it.
    """
    try:
        return linear_coefficients(graph, rows, unknowns)
    except FormulationError as error:
        raise FormulationError(
            *(
                Problem("reduction.not_linear", problem.where.replace("row", "equation"),
                        problem.what.replace("expression", "equation"),
                        "only equations that are linear in the derivatives can be split",
                        "write it in first order: add an unknown v = x' for x, and write v instead of x'")
                for problem in error.problems
            )
        ) from error  # fmt: skip


def _check_consistent(graph: Graph, left: Mapping[int, int]) -> None:
    """Refuse rows that say something of parameters, time or numbers alone."""
    found = [(i, node) for i, node in left.items() if _is_free_of_unknowns(graph, node)]
    if not found:
        return
    formulas, _ = to_readable_sympy(graph, [node for _, node in found])
    raise FormulationError(
        *(
            Problem("reduction.inconsistent", f"equation {i}", f"the equations say that {formula} = 0",
                    "an equation contradicts the others: all unknowns cancel from it",
                    "correct or leave out one of the equations that set the same unknowns")
            for (i, _), formula in zip(found, formulas, strict=True)
        )
    )  # fmt: skip


def _is_free_of_unknowns(graph: Graph, node: int) -> bool:
    """Return whether no unknown changes a value: all of them cancel, whatever the formula says."""
    unknowns = [
        k
        for k in symbols_of(graph, [node])
        if graph.symbols[graph.left[k]].kind not in (SymbolKind.PARAMETER, SymbolKind.TIME)
    ]
    return not unknowns or all(find_zeros(graph, gradient(graph, node, unknowns)))
