"""The process that solves: a pickled question on standard input, a pickled answer on standard output."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Sequence

import sympy as sp

from symbody.expr.solving.triangular import solve_triangular
from symbody.expr.solving.turned_rows import shortest_rows


def solutions(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return all solutions found for the unknowns, each with a value for every one of them."""
    solved = solve_triangular(equations, unknowns)
    if solved is None:
        solved = solve_triangular(shortest_rows(equations, unknowns), unknowns)
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


if __name__ == "__main__":
    main()
