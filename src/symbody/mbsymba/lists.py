"""Lists of equations: derivatives, first order, linear about a point, as matrices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from symbody.equations.by_hand.linear import (
    coefficient_matrix,
    first_order_system,
    linearize_at,
    state_matrices,
)
from symbody.equations.index_reduction.separation import Separation, separate_derivatives
from symbody.errors import Problem, UsageError
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.opcodes import SYMBOL
from symbody.expr.sympy.sympy_writer import (
    SympyEquation,
    SympyExpr,
    SympyMatrix,
    nodes_from_equations,
    symbol_to_sympy,
    sympy_derivative,
)
from symbody.mbsymba.workplace import WORKPLACE, function_names, to_expressions, to_sympy_expressions

Equation = SympyExpr | SympyEquation


def diff(expressions: object, *variables: SympyExpr) -> object:
    """Return the derivative of an expression, or of each in a list, tuple, dict of values or matrix."""
    if isinstance(expressions, Mapping):
        return {diff(key, *variables): diff(value, *variables) for key, value in expressions.items()}
    if isinstance(expressions, list | tuple):
        return [diff(item, *variables) for item in expressions]
    derivative = sympy_derivative(expressions, variables)
    if derivative is not None:
        return derivative
    raise UsageError(
        Problem("mbsymba.diff", "diff", f"a {type(expressions).__name__} has no derivative here", "",
                "give SymPy expressions; for points and frames call velocity, angular_velocity")
    )  # fmt: skip


def first_order(
    eqns: Iterable[Equation], variables: Iterable[SympyExpr], t: SympyExpr | None = None, flag: object = None
) -> tuple[list[SympyExpr], list[SympyExpr]]:
    """Return (newvars, equations) of first order: ``x_dot`` for x', behind the equations ``-x_dot + x'``.

    Parameters
    ----------
    eqns : list
        Expressions meant = 0, or equations.
    variables : list of functions of time
        Those with a second derivative in the equations get a rate; it stands behind all variables.
    t, flag
        Accepted as in the scripts, and not used.
    """
    graph = WORKPLACE.graph
    symbols = [Symbol(name, SymbolKind.COORDINATE) for name in function_names(variables, "first_order")]
    symbols_of_first_order, nodes = first_order_system(graph, nodes_from_equations(eqns, graph), symbols)
    return [symbol_to_sympy(symbol) for symbol in symbols_of_first_order], _write(graph, nodes)


def linearize(eqns: Iterable[Equation], point: Mapping[SympyExpr, SympyExpr | float]) -> list[SympyExpr]:
    """Return equations linear about a point: ``f(x0) + f'(x0) (x - x0)``.

    Parameters
    ----------
    eqns : list
        Expressions meant = 0, or equations.
    point : dict
        ``{x: x0}`` for each variable that becomes linear; rates of these are 0 at the point unless they
        are keys too. Where it is an equilibrium or a stationary motion, the constant part vanishes.
    """
    graph = WORKPLACE.graph
    roots = nodes_from_equations(eqns, graph)
    unknowns = _symbol_nodes(graph, point, "linearize")
    values = [value.index for value in to_expressions(point.values())]
    return _write(graph, linearize_at(graph, roots, dict(zip(unknowns, values, strict=True))))


def state_space(
    eqns: Iterable[Equation], t: SympyExpr | None, x: Iterable[SympyExpr]
) -> tuple[SympyMatrix, SympyMatrix, SympyMatrix]:
    """Return aa, bb, cc of the linear equations of first order ``aa x' = bb x - cc``.

    Poles are the eigenvalues of ``aa^-1 bb``.

    Raises
    ------
    FormulationError
        If the equations are not linear in x and x', or hold higher derivatives.
    """
    graph = WORKPLACE.graph
    symbols = [Symbol(name, SymbolKind.COORDINATE) for name in function_names(x, "state_space")]
    left, right, rest = state_matrices(graph, nodes_from_equations(eqns, graph), symbols)
    return _matrix(graph, left), _matrix(graph, right), _column(graph, rest)


def GenerateMatrix(
    eqns: Iterable[Equation], variables: Iterable[SympyExpr]
) -> tuple[SympyMatrix, SympyMatrix]:
    """Return A and b of linear equations ``A x = b``; x are functions of time, their derivatives, or symbols.

    Raises
    ------
    FormulationError
        If the equations are not linear in x.
    """
    graph = WORKPLACE.graph
    matrix, rest = coefficient_matrix(
        graph, nodes_from_equations(eqns, graph), _symbol_nodes(graph, variables, "GenerateMatrix")
    )
    return _matrix(graph, matrix), _column(graph, rest)


def LUMethod(eqns: Iterable[Equation], derivatives: Iterable[SympyExpr]) -> Separation:
    """Return (equations, algebraic): equations of lower index, and the constraints hidden in the given ones.

    Three calls take the equations of motion with constraints, of first order, to ordinary differential
    equations: ``dae1, alg1 = LUMethod(eqns, diff(x, t))``, ``dae2, alg2 = LUMethod(dae1, diff(x, t))``,
    ``ode, alg3 = LUMethod(dae2, diff(x, t))``.

    Parameters
    ----------
    derivatives : list
        ``x.diff(t)`` of every unknown x, the reactions or multipliers among them.

    Raises
    ------
    FormulationError
        If an equation is not linear in the derivatives, or contradicts the others.
    """
    return separate_derivatives(list(eqns), list(derivatives))


def _symbol_nodes(graph: Graph, variables: Iterable[SympyExpr], where: str) -> list[int]:
    items = list(variables)
    nodes = [value.index for value in to_expressions(items)]
    wrong = [str(item) for item, node in zip(items, nodes, strict=True) if graph.ops[node] != SYMBOL]
    if wrong:
        raise UsageError(
            Problem("mbsymba.not_a_variable", where, f"{', '.join(wrong)} is not a variable",
                    "it is neither a symbol, nor a function of time, nor a derivative of one",
                    "give one of these")
        )  # fmt: skip
    return nodes


def _write(graph: Graph, nodes: Sequence[int]) -> list[SympyExpr]:
    return to_sympy_expressions([Expr(graph, node) for node in nodes])


def _matrix(graph: Graph, rows: Sequence[Sequence[int]]) -> SympyMatrix:
    flat = _write(graph, [node for row in rows for node in row])
    return SympyMatrix(len(rows), len(flat) // max(1, len(rows)), flat)


def _column(graph: Graph, nodes: Sequence[int]) -> SympyMatrix:
    return SympyMatrix(len(nodes), 1, _write(graph, nodes))
