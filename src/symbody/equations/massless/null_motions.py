"""Motions without kinetic energy: the null space of the mass matrix, exactly.

Ranks are taken modulo a prime at a random point (Schwartz 1980), where fingerprints give every entry exactly;
so a motion is found where, and only where, the mass matrix is singular at all configurations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from symbody.equations.dynamics.inertia import Inertia
from symbody.equations.dynamics.linear_solve import LinearSolution, solve_positive_definite
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.expr.expression import Expr, number
from symbody.expr.fingerprints.fingerprint import PRIME, find_zeros, fingerprints
from symbody.expr.graph import Graph

# A motion: coefficients of the speeds, by their places, zeros left out.
Motion = Mapping[int, Expr]

# Coefficients that are written as numbers.
_PLAIN: Final = (1, -1)


def is_light(body: Inertia) -> bool:
    """Return whether a body may move without resistance in some direction."""
    return body.mass.is_zero or body.tensor.isotropic.is_zero


def zero_pivots(formed: EquationsOfMotion, solution: LinearSolution) -> list[int]:
    """Return the places of the speeds of a tree that no mass resists while all outward of them is free."""
    zeros = find_zeros(formed.graph, [pivot.index for pivot in solution.pivots])
    return [k for k, is_zero in enumerate(zeros) if is_zero]


def null_motions(formed: EquationsOfMotion) -> list[Motion]:
    """Return a basis of the motions v with ``M v = 0``, each with a coefficient of 1.

    Parameters
    ----------
    formed : EquationsOfMotion
        In all speeds.
    """
    graph, n = formed.graph, len(formed.u)
    mass = formed.dynamics.mass_matrix
    flat = [mass[max(i, j)][min(i, j)] for i in range(n) for j in range(n)]
    first, second = _values(graph, flat)
    columns = [[first[i * n + j] for i in range(n)] for j in range(n)]
    motions: list[Motion] = []
    for free, residues in _dependent_columns(columns):
        others = _values_at(second, n, sorted(residues), free)
        motions.append(_motion(graph, mass, free, residues, others))
    return motions


def rank(graph: Graph, rows: Sequence[Sequence[Expr]]) -> int:
    """Return the largest rank of a matrix over all values of the symbols in it."""
    width = len(rows[0])
    values = _values(graph, [entry for row in rows for entry in row])[0]
    columns = [[values[i * width + j] for i in range(len(rows))] for j in range(width)]
    return width - len(_dependent_columns(columns))


def _values(graph: Graph, entries: Sequence[Expr]) -> tuple[list[int], list[int]]:
    """Return expressions as residues at two random points."""
    found = fingerprints(graph, list(graph.reachable([entry.index for entry in entries])))
    return [found[x.index][0] for x in entries], [found[x.index][1] for x in entries]


def _dependent_columns(columns: Sequence[Sequence[int]]) -> list[tuple[int, dict[int, int]]]:
    """Return the columns that follow from those after them, with the combination that is zero.

    Returns
    -------
    list of (int, mapping of int to int)
        A column, and the coefficients modulo the prime of all columns in the combination; its own is 1.
    """
    basis: dict[int, tuple[list[int], dict[int, int]]] = {}
    dependent = []
    for k in reversed(range(len(columns))):
        column, shares = [x % PRIME for x in columns[k]], {k: 1}
        for lead, (vector, parts) in basis.items():
            factor = column[lead]
            if factor:
                column = [(a - factor * b) % PRIME for a, b in zip(column, vector, strict=True)]
                for j, part in parts.items():
                    shares[j] = (shares.get(j, 0) - factor * part) % PRIME
        lead = next((i for i, x in enumerate(column) if x), -1)
        if lead < 0:
            dependent.append((k, {j: share for j, share in shares.items() if share}))
            continue
        inverse = pow(column[lead], -1, PRIME)
        basis[lead] = (
            [x * inverse % PRIME for x in column],
            {j: x * inverse % PRIME for j, x in shares.items()},
        )
    return dependent


def _values_at(flat: Sequence[int], n: int, places: Sequence[int], free: int) -> dict[int, int]:
    """Return the same combination at the other point, in columns that do as at the first."""
    columns = [[flat[i * n + j] for i in range(n)] for j in places]
    for k, shares in _dependent_columns(columns):
        if places[k] == free:
            return {places[j]: share for j, share in shares.items()}
    return {}


def _motion(
    graph: Graph,
    mass: Sequence[Sequence[Expr]],
    free: int,
    residues: Mapping[int, int],
    others: Mapping[int, int],
) -> Motion:
    """Return the coefficients of a motion as expressions: as numbers where they are 1 or -1."""
    plain = {
        j: number(graph, value)
        for j, residue in residues.items()
        for value in _PLAIN
        if residue == value % PRIME == others.get(j)
    }
    if len(plain) == len(residues):
        return plain
    places = [j for j in sorted(residues) if j != free]
    inner = [[mass[max(i, j)][min(i, j)] for j in places] for i in places]
    right = [-mass[max(i, free)][min(i, free)] for i in places]
    solution = solve_positive_definite(inner, right, range(len(places))).values
    return {**dict(zip(places, solution, strict=True)), **plain}
