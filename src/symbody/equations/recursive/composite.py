"""The mass matrix by composite bodies, and its factors with the zeros of the tree kept.

Walker & Orin (1982): column j is what the links outward of a joint, as one rigid body, need for a unit
acceleration of it. Featherstone (2008), section 6.5: eliminated from the leaves inward, ``M = L^T D L`` has
an entry only where one speed carries the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from symbody.equations.recursive.links import GROUND, Tree
from symbody.equations.recursive.newton_euler import Carried
from symbody.expr.expression import Expr

# The entries of a symmetric matrix at and left of the diagonal, row by row in the order of the tree.
Rows = list[dict[int, Expr]]


class Factors(NamedTuple):
    """``M = L^T D L``: what is left of the diagonal of each row of L, the inverse pivots, and the pivots."""

    lower: Rows
    inverse: list[Expr]
    pivots: list[Expr]


def column_places(tree: Tree, speeds: Iterable[int]) -> dict[int, int]:
    """Return the place of each speed: in the order of the tree, then those that move no link."""
    carried = [column.speed for link in tree.links for column in link.motion.columns]
    return {speed: k for k, speed in enumerate(dict.fromkeys((*carried, *speeds)))}


def mass_rows(tree: Tree, place: Mapping[int, int], rotors: Mapping[tuple[int, int], Expr]) -> Rows:
    """Return the mass matrix.

    Parameters
    ----------
    place : mapping of speed to int
        Its row, by `column_places`.
    rotors : mapping of (speed, speed) to Expr
        What rotors add, both ways.
    """
    whole = [link.inertia for link in tree.links]
    for k in reversed(range(len(tree.links))):
        link = tree.links[k]
        if link.parent != GROUND:
            whole[link.parent] = whole[link.parent].plus(whole[k].moved(link.steps, link.arm))
    rows: Rows = [{} for _ in place]
    for k, link in enumerate(tree.links):
        for c, column in enumerate(link.motion.columns):
            row = rows[place[column.speed]]
            wrench = Carried(*whole[k].wrench(column.turn, column.slide))
            for other in link.motion.columns[: c + 1]:
                row[place[other.speed]] = wrench.work(other.turn, other.slide)
            inner = link
            while inner.parent != GROUND:
                wrench, inner = wrench.moved(inner), tree.links[inner.parent]
                for other in inner.motion.columns:
                    row[place[other.speed]] = wrench.work(other.turn, other.slide)
    for (one, two), inertia in rotors.items():
        i, j = place[one], place[two]
        if j <= i:
            rows[i][j] = rows[i].get(j, inertia * 0) + inertia
    return rows


def factors(rows: Rows) -> Factors:
    """Return the factors of a positive definite matrix; a pivot that is the constant 0 counts as 1."""
    left = [dict(row) for row in rows]
    lower: Rows = [{} for _ in rows]
    inverse: list[Expr] = []
    pivots: list[Expr] = []
    for k in reversed(range(len(rows))):
        pivot = left[k].pop(k)
        pivots.append(pivot)
        inverse.append(1 / pivot if not pivot.is_zero else pivot + 1)
        carrying = sorted((i for i, entry in left[k].items() if not entry.is_zero), reverse=True)
        for i in carrying:
            factor = left[k][i] * inverse[-1]
            lower[k][i] = factor
            for j in carrying:
                if j <= i:
                    gone = factor * left[k][j]
                    left[i][j] = left[i][j] - gone if j in left[i] else -gone
    return Factors(lower, inverse[::-1], pivots[::-1])


def solved(found: Factors, right: Sequence[Expr]) -> list[Expr]:
    """Return x with ``M x = right``, both in the order of the tree."""
    x = list(right)
    for k in reversed(range(len(x))):
        for i, factor in found.lower[k].items():
            x[i] = x[i] - factor * x[k]
    for k, row in enumerate(found.lower):
        x[k] = x[k] * found.inverse[k]
        for i in sorted(row):  # what was found last is waited for last
            x[k] = x[k] - row[i] * x[i]
    return x
