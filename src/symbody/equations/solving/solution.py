"""Accelerations and multipliers: the solution of the equations of motion on the graph."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.linear_solve import solve_positive_definite
from symbody.equations.formed import Formed
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr, saddle_entry
from symbody.expr.fingerprint import fingerprints
from symbody.expr.graph import Graph, Kernel
from symbody.expr.rewrite import substitute


def vanishing(graph: Graph, nodes: Sequence[int]) -> list[bool]:
    """Return which nodes are identically zero, by fingerprint."""
    values = fingerprints(graph, list(graph.reachable(nodes)))
    return [values[node] == (0, 0) for node in nodes]


def solve(formed: Formed) -> tuple[list[Expr], list[Expr]]:
    """Return u' and the multipliers.

    Raises
    ------
    FormulationError
        If there are no constraints and no mass resists some speed, naming it.
    """
    if not formed.solved:
        formed.solved.append(_solve_saddle(formed) if formed.rows else (_solve_tree(formed), []))
    return formed.solved[0]


def solved(formed: Formed, values: Sequence[Expr]) -> list[Expr]:
    """Return expressions in q, u, u' and the multipliers with the last two replaced by the solution."""
    graph = formed.graph
    symbols = [*(u.derivative for u in formed.u), *formed.multipliers]
    nodes = {graph.symbol(symbol): k for k, symbol in enumerate(symbols)}
    if nodes.keys().isdisjoint(graph.reachable([value.index for value in values])):
        return list(values)
    udot, multipliers = solve(formed)
    solution = [*udot, *multipliers]
    replacements = {node: solution[k].index for node, k in nodes.items()}
    found = substitute(graph, [value.index for value in values], replacements)
    return [Expr(graph, node) for node in found]


def _solve_tree(formed: Formed) -> list[Expr]:
    projection = formed.projection
    found = solve_positive_definite(projection.mass_matrix, projection.forcing, _outward(formed))
    if any(map(_is_light, formed.bodies)):
        gone = vanishing(formed.graph, [pivot.index for pivot in found.pivots])
        problems = [_massless(formed, k) for k, zero in enumerate(gone) if zero]
        if problems:
            raise FormulationError(*problems)
    return found.values


def _solve_saddle(formed: Formed) -> tuple[list[Expr], list[Expr]]:
    graph, projection, jacobian = formed.graph, formed.projection, formed.jacobian
    n, m = len(formed.u), len(formed.rows)
    operands = [
        *(entry for row in projection.mass_matrix for entry in row),
        *(entry for row in jacobian for entry in row),
        *projection.forcing,
        *(row.gamma for row in formed.rows),
    ]
    nodes = tuple(operand.index for operand in operands)
    kernel = graph.kernel(Kernel(n, m))
    found = [saddle_entry(graph, kernel, nodes, k) for k in range(n + m)]
    return found[:n], found[n:]


def _outward(formed: Formed) -> list[int]:
    """Return the speeds in the order of the branches they belong to, from ground to the leaves."""
    topology = formed.topology
    branches = [*topology.translation.branches, *topology.rotation.branches]
    depth: dict[str, int] = {}
    for branch in branches:
        depth.setdefault(branch.edge.name, len(depth))
    owner = {speed.label: use.joint.name for use in formed.uses for speed in use.speeds}
    return sorted(range(len(formed.u)), key=lambda k: depth[owner[formed.u[k].label]])


def _is_light(body: Inertia) -> bool:
    """Return whether a body may move without resistance in some direction."""
    return body.mass.is_zero or body.tensor.isotropic.is_zero


def _massless(formed: Formed, k: int) -> Problem:
    name = formed.u[k].label
    return Problem(
        "equations.massless", f"speed {name}", f"no mass resists {name} while all outward of it is free",
        "the mass matrix is singular everywhere, so this acceleration is not determined",
        "give mass or inertia to the bodies that move with it, or weld its joint",
    )  # fmt: skip
