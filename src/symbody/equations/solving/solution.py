"""Accelerations and multipliers: the solution of the equations of motion on the graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.loads.friction import Resistance
from symbody.equations.massless.force_balances import UndeterminedMotion, find_balances
from symbody.equations.massless.null_motions import is_light, zero_pivots
from symbody.equations.solving.friction_solution import solve_given, solve_with_friction, unknown_symbols
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr, saddle_entry
from symbody.expr.graph import KernelNode, Symbol, SymbolKind
from symbody.expr.rewrite import Substitution


def solve(formed: EquationsOfMotion) -> tuple[list[Expr], list[Expr]]:
    """Return u' and the multipliers.

    Raises
    ------
    FormulationError
        If there are no constraints and no mass resists some speed, naming it.
    """
    return formed.solution.get(None, partial(_solution, formed))


def _solution(formed: EquationsOfMotion) -> tuple[list[Expr], list[Expr]]:
    if formed.given:
        return solve_given(formed, partial(solve_linear, formed))
    if formed.friction:
        return solve_with_friction(formed, partial(solve_linear, formed))
    accelerations = formed.dynamics.accelerations(formed)
    if accelerations is not None:
        return accelerations
    return solve_linear(formed, formed.dynamics.forcing, [row.gamma for row in formed.rows])


def resistance(formed: EquationsOfMotion) -> Resistance:
    """Return the friction of all joints."""
    if not formed.friction:
        return Resistance([], [], [], [])
    solve(formed)
    return formed.resistances[0]


def substitute_solution(formed: EquationsOfMotion, values: Sequence[Expr]) -> list[Expr]:
    """Return expressions with u', the multipliers and friction efforts replaced by the solution.

    The multipliers of redundant rows are 0; `substitute_shares` puts those of least norm in their place.
    """
    graph, nodes = formed.graph, [value.index for value in values]
    if formed.substitution.peek(None) is None:
        unknowns = _unknown_nodes(formed)
        if unknowns.keys().isdisjoint(graph.reachable(nodes)):  # most inputs are numbers
            return list(values)
    found = formed.substitution.get(None, partial(_replace_unknowns, formed)).roots(nodes)
    return [Expr(graph, node) for node in found]


def _unknown_nodes(formed: EquationsOfMotion) -> dict[int, int]:
    """Return the places of u', multipliers of all rows, redundant ones last, and friction efforts by node."""
    redundant = [Symbol(row.name, SymbolKind.MULTIPLIER) for row in formed.redundant]
    symbols = [*unknown_symbols(formed), *redundant]
    return {formed.graph.symbol(symbol): k for k, symbol in enumerate(symbols)}


def _replace_unknowns(formed: EquationsOfMotion) -> Substitution:
    udot, multipliers = solve(formed)
    idle = [Expr(formed.graph, 0)] * len(formed.redundant)
    solution = [*udot, *multipliers, *resistance(formed).efforts, *idle]
    replacements = {node: solution[k].index for node, k in _unknown_nodes(formed).items()}
    return Substitution(formed.graph, replacements)


def solve_linear(
    formed: EquationsOfMotion, forcing: Sequence[Expr], gamma: Sequence[Expr]
) -> tuple[list[Expr], list[Expr]]:
    """Return u' and the multipliers for a forcing and the right-hand side of the constraints."""
    return _solve_saddle(formed, forcing, gamma) if formed.rows else (_solve_tree(formed, forcing), [])


def _solve_tree(formed: EquationsOfMotion, forcing: Sequence[Expr]) -> list[Expr]:
    solution = formed.dynamics.solve(formed, forcing)
    if any(map(is_light, formed.bodies)):
        places = zero_pivots(formed, solution)
        if places:
            balances = find_balances(formed)
            reason = balances if isinstance(balances, UndeterminedMotion) else None
            raise FormulationError(*(_massless(formed, k, reason) for k in places))
    return solution.values


def _solve_saddle(
    formed: EquationsOfMotion, forcing: Sequence[Expr], gamma: Sequence[Expr]
) -> tuple[list[Expr], list[Expr]]:
    graph, jacobian = formed.graph, formed.jacobian
    n, m = len(formed.u), len(formed.rows)
    operands = [
        *(entry for row in formed.dynamics.mass_matrix for entry in row),
        *(entry for row in jacobian for entry in row),
        *forcing,
        *gamma,
    ]
    nodes = tuple(operand.index for operand in operands)
    kernel = graph.kernel(KernelNode(n, m))
    solution = [saddle_entry(graph, kernel, nodes, k) for k in range(n + m)]
    return solution[:n], solution[n:]


def _massless(formed: EquationsOfMotion, k: int, reason: UndeterminedMotion | None) -> Problem:
    name = formed.u[k].label
    problem = Problem(
        "equations.massless", f"speed {name}", f"{name} has no mass when everything outward of it is free",
        "the mass matrix is singular everywhere, so this acceleration is undetermined",
        "give mass or inertia to the bodies that move with it, or weld its joint",
    )  # fmt: skip
    if reason is None:
        return problem
    more = f", and forces do not determine {reason.speed.label} either: {reason.why}"
    return replace(problem, why=problem.why + more, fix=reason.fix)
