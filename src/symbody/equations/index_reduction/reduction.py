"""`reduce_index`: from equations with constraints to ordinary differential equations.

Each round parts the equations that determine derivatives from hidden constraints and differentiates these;
the rounds are counted by the index (Hairer & Wanner 1996, section VII.1). For the equations of a mechanism
the structure is known, and nothing has to be searched.
"""

from __future__ import annotations

from collections.abc import Sequence

from symbody.arguments import checked_arguments
from symbody.equations.equation_set import EquationSet
from symbody.equations.index_reduction.mechanism_reduction import IndexReduction, reduce_mechanism
from symbody.equations.index_reduction.separation import derivative_nodes, separate, to_readable_sympy
from symbody.errors import FormulationError, Problem
from symbody.expr.graph import Graph
from symbody.expr.sympy.sympy_bridge import (
    SympyEquation,
    SympyExpr,
    nodes_from_equations,
    time_derivatives,
)


@checked_arguments
def reduce_index(
    equations: EquationSet | Sequence[SympyExpr | SympyEquation],
    unknowns: Sequence[SympyExpr] | None = None,
) -> IndexReduction:
    """Return ordinary differential equations and hidden constraints.

    Parameters
    ----------
    equations : EquationSet or sequence of SymPy equations
        Of first order and linear in the derivatives, where they are given as SymPy's; an expression stands
        for an equation with 0.
    unknowns : sequence of SymPy functions of time
        With SymPy's equations: all of them, reactions and multipliers among them.

    Returns
    -------
    IndexReduction
        Of an EquationSet the hidden constraints are ``Phi``, ``J u + b`` and ``J u' - gamma``; the ordinary
        equations are ``q' = N u + nu``, where it is not trivial, and the time derivatives of
        ``M u' = F + J^T lambda`` and ``J u' = gamma``, in u'' and lambda'.

    Raises
    ------
    FormulationError
        If the equations do not determine the unknowns, contradict each other, or are not linear in the
        derivatives.

    Examples
    --------
    >>> import sympy as sp
    >>> import symbody as sb
    >>> t = sp.Symbol("t")
    >>> x, y, z = (sp.Function(name)(t) for name in "xyz")
    >>> result = sb.reduce_index([x.diff(t) - y, x - sp.sin(t)], [x, y])
    >>> result.ode
    [-y(t) + Derivative(x(t), t), sin(t) + Derivative(y(t), t)]
    >>> result.algebraic
    ([x(t) - sin(t)], [y(t) - cos(t)])
    """
    if isinstance(equations, EquationSet):
        return reduce_mechanism(equations.formed)
    if unknowns is None:
        raise FormulationError(
            Problem("reduction.unknowns", "unknowns", "unknowns= is missing",
                    "a list of equations does not show which functions are inputs and which are unknowns",
                    "give unknowns=[...], all functions of time that are to be determined")
        )  # fmt: skip
    return _of_equations(equations, tuple(unknowns))


def _of_equations(
    equations: Sequence[SympyExpr | SympyEquation], unknowns: tuple[SympyExpr, ...]
) -> IndexReduction:
    graph = Graph()
    rows = nodes_from_equations(equations, graph)
    rates = derivative_nodes(graph, time_derivatives(unknowns))
    _check_number(len(rows), unknowns)
    levels: list[list[int]] = []
    pivots: dict[int, None] = {}
    while True:
        parted = separate(graph, rows, rates)
        pivots.update(dict.fromkeys(parted.pivots))
        if parted.dropped:
            raise FormulationError(_undetermined_problem(parted.dropped, len(levels), unknowns))
        if not parted.algebraic:
            break
        levels.append(parted.algebraic)
        rows = [*parted.differential, *parted.rates]
        if len(levels) > len(unknowns):  # no regular system has a higher index [Hairer & Wanner 1996]
            raise FormulationError(_undetermined_problem((), len(levels), unknowns))
    shown, definitions = to_readable_sympy(
        graph, [*rows, *(node for level in levels for node in level), *pivots]
    )
    pieces = iter(shown)
    ode = [next(pieces) for _ in rows]
    algebraic = tuple([next(pieces) for _ in level] for level in levels)
    return IndexReduction(unknowns, ode, algebraic, tuple(pieces), tuple(definitions))


def _check_number(count: int, unknowns: Sequence[SympyExpr]) -> None:
    if count == len(unknowns):
        return
    few = count < len(unknowns)
    raise FormulationError(
        Problem(
            "reduction.number", "equations", f"there are {count} equations for {len(unknowns)} unknowns",
            "some unknowns have no equation" if few else "some equations have no unknown",
            "add equations: constraints, forces, rates v = x'" if few
            else "name all unknowns, including multipliers and reactions, or leave out equations",
        )
    )  # fmt: skip


def _undetermined_problem(dropped: Sequence[int], rounds: int, unknowns: Sequence[SympyExpr]) -> Problem:
    listed = ", ".join(map(str, dropped))
    what = f"equation {listed} follows from the others" if dropped else "differentiation does not end"
    if rounds and dropped:
        what = f"after {rounds} differentiations an equation follows from the others"
    names = ", ".join(map(str, unknowns[:6])) + (", ..." if len(unknowns) > 6 else "")
    return Problem(
        "reduction.undetermined", "equations", f"{what}: {names} are not all determined",
        "a constraint is redundant, a mass is zero, or an unknown appears in no equation",
        "leave out constraints that others imply and their multipliers, and give every body its mass",
    )  # fmt: skip
