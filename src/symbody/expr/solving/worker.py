"""The process that solves: a pickled question on standard input, a pickled answer on standard output."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterator, Sequence
from itertools import combinations

import sympy as sp
from sympy.simplify.fu import TR8

from symbody.expr.solving.triangular import solve_triangular


def solutions(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return all solutions found for the unknowns, each with a value for every one of them."""
    solved = solve_triangular(equations, unknowns)
    if solved is None:
        solved = solve_triangular(_shortest_rows(equations, unknowns), unknowns)
    if solved is None:
        try:
            solved = sp.solve(equations, unknowns, dict=True)
        except NotImplementedError:  # SymPy has no method for these
            solved = []
    wanted = set(unknowns)
    complete = [
        {x: solution[x] for x in unknowns}
        for solution in solved
        if wanted <= solution.keys()
        and not any(solution[x].free_symbols & wanted or solution[x].has(sp.I) for x in unknowns)
    ]
    return list({tuple(solution.values()): solution for solution in complete}.values())


def main() -> None:
    """Answer one question."""
    equations, unknowns = pickle.load(sys.stdin.buffer)
    pickle.dump(solutions(equations, unknowns), sys.stdout.buffer)


def _shortest_rows(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """Return equations with the same solutions, each pair of which stands in its shortest axes.

    The closing vector of a planar loop has two components, in the axes of whatever link it was measured in.
    Along other axes they are ``a cos + b sin`` and ``b cos - a sin`` of the angle between, which vanish
    together, too.
    """
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


if __name__ == "__main__":
    main()
