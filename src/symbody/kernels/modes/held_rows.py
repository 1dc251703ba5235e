"""Efforts of rows that hold: those that keep their accelerations zero, of least norm where several do.

The responses of rows to each other are symmetric and positive semidefinite. Their factor L with ``A = L L^T``
is found by Cholesky's method with pivots [GVL 4.2.8]; where rows depend on each other it has fewer columns.
Norms are those of efforts times sizes, which are works, so that units do not matter.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Reals, sqrt
from symbody.kernels.linear.cholesky import solve_lower
from symbody.kernels.modes.mode_problem import ModeProblem

# A row depends on others if the square of its distance from them, over its own, is rounding: L is found from
# products, which keep half of the digits of a distance.
DEPENDENT: Final = 1e-11
# Of the largest response: less is rounding of a row that cannot move.
IMMOVABLE: Final = 1e-12
# The square of the part of a unit effort that accelerates nothing: less is rounding.
SHARED: Final = 1e-9
# Of the accelerations of rows that hold: more cannot be held.
UNHELD: Final = 1e-7


def factor_held(problem: ModeProblem) -> None:
    """Factor the responses of the rows that hold, whose order follows the pivots."""
    n = problem.held_count
    rows = problem.rows
    held = problem.held
    sizes = problem.sizes
    A = problem.responses
    L = problem.factor
    diagonal = problem.room
    largest = 0.0
    for i in range(n):
        a = int(held[i])
        for j in range(n):
            b = int(held[j])
            L[i * n + j] = 0.5 * (A[a * rows + b] + A[b * rows + a]) / (sizes[a] * sizes[b])
        diagonal[i] = L[i * n + i]
        largest = max(largest, diagonal[i])
    rank = 0
    for k in range(n):
        best = farthest_row(n, k, largest, L, diagonal)
        if best < 0:
            break
        exchange_held(n, k, best, L, diagonal, held)
        L[k * n + k] = sqrt(L[k * n + k])
        for i in range(k + 1, n):
            L[i * n + k] = L[i * n + k] / L[k * n + k]
        for i in range(k + 1, n):
            for j in range(k + 1, n):
                L[i * n + j] = L[i * n + j] - L[i * n + k] * L[j * n + k]
        rank = rank + 1
    problem.rank = rank
    if rank < n:
        factor_gram(n, rank, L, problem.gram)


def farthest_row(n: int, start: int, largest: float, L: Reals, diagonal: Reals) -> int:
    """Return the row that is farthest from those before, over its own length; -1 if all depend on them."""
    best = -1
    top = DEPENDENT
    for i in range(start, n):
        if diagonal[i] > IMMOVABLE * largest:
            share = L[i * n + i] / diagonal[i]
            if share > top:
                top = share
                best = i
    return best


def exchange_held(n: int, a: int, b: int, L: Reals, diagonal: Reals, held: Reals) -> None:
    """Exchange two rows that hold."""
    for j in range(n):
        kept = L[a * n + j]
        L[a * n + j] = L[b * n + j]
        L[b * n + j] = kept
    for i in range(n):
        other = L[i * n + a]
        L[i * n + a] = L[i * n + b]
        L[i * n + b] = other
    size = diagonal[a]
    diagonal[a] = diagonal[b]
    diagonal[b] = size
    row = held[a]
    held[a] = held[b]
    held[b] = row


def factor_gram(n: int, rank: int, L: Reals, G: Reals) -> None:
    """Set the lower half of G (rank, rank) to the Cholesky factor of ``L^T L``."""
    for i in range(rank):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, n):
                total = total + L[k * n + i] * L[k * n + j]
            for k in range(j):
                total = total - G[i * rank + k] * G[j * rank + k]
            if i == j:
                G[i * rank + i] = sqrt(total)
            else:
                G[i * rank + j] = total / G[j * rank + j]


def shares_effort(problem: ModeProblem, i: int, y: Reals) -> int:
    """Return 1 if others of the rows that hold can take over some effort of the one at place i, else 0.

    That is so unless it is orthogonal to all efforts that accelerate nothing; y is scratch.
    """
    n = problem.held_count
    rank = problem.rank
    L = problem.factor
    G = problem.gram
    if rank == n:
        return 0
    own = 0.0
    for a in range(rank):
        total = 0.0
        if a <= i:
            total = L[i * n + a]
        for b in range(a):
            total = total - G[a * rank + b] * y[b]
        y[a] = total / G[a * rank + a]
        own = own + y[a] * y[a]
    if 1.0 - own > SHARED:
        return 1
    return 0


def multiply_transposed(n: int, rank: int, L: Reals, x: Reals, y: Reals) -> None:
    """Set y (rank,) to ``L^T x``."""
    for j in range(rank):
        total = 0.0
        for i in range(j, n):
            total = total + L[i * n + j] * x[i]
        y[j] = total


def multiply_factor(n: int, rank: int, L: Reals, y: Reals, x: Reals) -> None:
    """Set x (n,) to ``L y``."""
    for i in range(n):
        total = 0.0
        for j in range(min(i + 1, rank)):
            total = total + L[i * n + j] * y[j]
        x[i] = total


def solve_held(problem: ModeProblem, x: Reals, y: Reals) -> int:
    """Overwrite x, accelerations in the order of `held` times -1 over sizes, by works of least norm.

    Returns 0, or 1 if none hold the rows; y is scratch.
    """
    n = problem.held_count
    rank = problem.rank
    L = problem.factor
    if rank == n:
        solve_lower(n, n, L, x)
        return 0
    multiply_transposed(n, rank, L, x, y)
    solve_lower(rank, rank, problem.gram, y)
    status = 0
    largest = 0.0
    for i in range(rank):
        largest = max(largest, abs(x[i]))
    for i in range(rank, n):
        total = x[i]
        for j in range(rank):
            total = total - L[i * n + j] * y[j]
        if abs(total) > UNHELD * largest + problem.room[7 * problem.rows + int(problem.held[i])]:
            status = 1
    solve_lower(rank, rank, problem.gram, y)
    multiply_factor(n, rank, L, y, x)
    return status
