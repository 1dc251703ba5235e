"""The composite-rigid-body algorithm: the mass matrix.

Featherstone (2008), section 6.2 and table 6.2; Walker & Orin (1982). Column j holds the generalized forces
for a unit acceleration of joint j, which moves the links outward of it as one rigid body.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.equations.dynamics.linear_solve import Rows
from symbody.equations.recursive.links import GROUND, KinematicTree, MotionSubspaceColumn
from symbody.expr.expression import Expr


def row_numbers(tree: KinematicTree, speeds: Iterable[int]) -> dict[int, int]:
    """Return the row of each speed: in the order of the tree, then those that move no link."""
    carried = [column.speed for link in tree.links for column in link.motion.columns]
    return {speed: k for k, speed in enumerate(dict.fromkeys((*carried, *speeds)))}


def mass_rows(tree: KinematicTree, row: Mapping[int, int], rotors: Mapping[tuple[int, int], Expr]) -> Rows:
    """Return the lower half of the mass matrix, ``M_ij = S_i . I_j S_j`` (table 6.2).

    I_j is the inertia of all that joint j carries; joint i is j or one on the way from j to ground. Entries
    of coupled joints add up in the row of the speed they share, ``W^T M W``.

    Parameters
    ----------
    row : mapping of speed to int
        By `row_numbers`.
    rotors : mapping of (speed, speed) to Expr
        Entries of rotors, both ways.
    """
    composite = [link.inertia for link in tree.links]
    for k, link in reversed(list(enumerate(tree.links))):
        if link.parent != GROUND:
            composite[link.parent] = composite[link.parent] + composite[k].to_parent(link.transform)
    M: Rows = [{} for _ in row]
    for k, link in enumerate(tree.links):
        for c, column in enumerate(link.motion.columns):
            force = composite[k] @ column.twist
            for other in link.motion.columns[: c + 1]:
                _add(M, row, (column, other), other.twist.dot(force))
            carrier = link
            while carrier.parent != GROUND:
                force = carrier.transform.wrench_to_parent(force)
                carrier = tree.links[carrier.parent]
                for other in carrier.motion.columns:
                    _add(M, row, (column, other), other.twist.dot(force))
    for (one, two), inertia in rotors.items():
        i, j = row[one], row[two]
        if j <= i:
            M[i][j] = M[i].get(j, inertia * 0) + inertia
    return M


def _add(
    M: Rows, row: Mapping[int, int], pair: tuple[MotionSubspaceColumn, MotionSubspaceColumn], entry: Expr
) -> None:
    """Add the entry of two columns, and of the same two in the other order where they share a speed."""
    one, other = pair
    i, j = row[one.speed], row[other.speed]
    i, j = max(i, j), min(i, j)
    if i == j and one is not other:
        entry = entry * 2
    M[i][j] = M[i][j] + entry if j in M[i] else entry
