"""Pairs of loop equations turned into other axes, in which they are shorter.

The closing vector of a planar loop has two components, in the axes of whatever link it was measured in. Along
other axes they are ``a cos + b sin`` and ``b cos - a sin`` of the angle between, which vanish together, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import sympy as sp
from sympy.simplify.fu import TR8


def shortest_rows(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """Return equations with the same solutions, each pair of which stands in its shortest axes."""
    rows = [sp.expand(equation) for equation in equations]
    for i, j in combinations(range(len(rows)), 2):
        pairs = [(rows[i], rows[j]), *_rotate_rows(rows[i], rows[j], set(unknowns))]
        rows[i], rows[j] = min(pairs, key=_length)
    return rows


def _rotate_rows(a: sp.Expr, b: sp.Expr, unknowns: set[sp.Symbol]) -> Iterator[tuple[sp.Expr, sp.Expr]]:
    """Yield two equations in all axes that an unknown angle in them leads to."""
    functions = sorted(a.atoms(sp.sin, sp.cos) | b.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    angles = dict.fromkeys(f.args[0] for f in functions if f.args[0].free_symbols & unknowns)
    for angle in angles:
        for c, s in ((sp.cos(angle), sp.sin(angle)), (sp.cos(angle), -sp.sin(angle))):
            # Products of sines and cosines as sums of such: what cancels is seen by expanding.
            first, second = (TR8(sp.expand(row)) for row in (a * c + b * s, b * c - a * s))
            yield sp.expand(first), sp.expand(second)


def _length(pair: tuple[sp.Expr, sp.Expr]) -> int:
    return sum(len(sp.Add.make_args(row)) + len(row.atoms(sp.sin, sp.cos)) for row in pair)
