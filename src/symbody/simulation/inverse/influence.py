"""How unknown inputs enter the equations of motion: ``F = F0 + B r``, column by column in the graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symbody.equations.dynamics.projection import Projection
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.calculus import derivative
from symbody.expr.expression import Expr
from symbody.expr.rewrite import symbols_of


def influence(eqs: EquationSet, unknowns: Sequence[str]) -> tuple[EquationSet, ...]:
    """Return equations whose forcing is one column of B each, in the order of `unknowns`.

    Raises
    ------
    UsageError
        If an unknown enters otherwise than in first degree, naming it and where.
    """
    formed, graph = eqs.formed, eqs.formed.graph
    forcing = [force.index for force in formed.projection.forcing]
    asked = {formed.names.value(name).index: name for name in unknowns}
    columns = [derivative(graph, forcing, node) for node in asked]
    problems = []
    for name, column in zip(unknowns, columns, strict=True):
        left = {asked[node] for node in symbols_of(graph, column) if node in asked}
        if left:
            places = [eqs.speed_names[k] for k, x in enumerate(column) if not asked.keys().isdisjoint(
                symbols_of(graph, [x]))]  # fmt: skip
            problems.append(
                Problem("inverse.not_affine", f"unknown {name}",
                        f"{name} enters the equation of {', '.join(places)} in higher degree",
                        f"its coefficient depends on {', '.join(sorted(left))}",
                        "take the force or torque itself as the input, and find afterwards what makes it")
            )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    mass = formed.projection.mass_matrix
    equations = []
    for column in columns:
        shares = tuple(Expr(graph, node) for node in column)
        plain = replace(formed, projection=Projection(mass, shares), friction=())
        equations.append(EquationSet(eqs.model, plain.with_rows(formed.rows), eqs.notes))
    return tuple(equations)
