"""The factorization behind `solve_saddle`: scaling, rank and null space of J, reduced mass matrix.

Plain loops over flat lists, the same in every language; see `saddle` for the sources [GVL] and [H].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

EPSILON: Final = 2.0**-52
CUT_FACTOR: Final = 1000.0  # of both cuts, in units of size * EPSILON; the derivation gives the measured gap
PIVOT_SHARE: Final = 0.0625  # an earlier row goes first if its squared sine exceeds this share of the largest
LIGHTEST: Final = 2.0**-40  # entries of diag(M) below this share of the largest no longer set the scale
EXPONENT_LIMIT: Final = 1022  # so that scale factors and their inverses are normal numbers

SquareRoot = Callable[[float], float]


class Factors(NamedTuple):
    """The scaled system, factored in place."""

    n: int
    m: int
    d: list[float]  # (n,) powers of two: udot = d * v
    r: list[float]  # (m,) powers of two: lambda = r * scaled multipliers
    A: list[float]  # (m, n) scaled J; in kept rows columns of R, then the Householder vector
    B: list[float]  # (n, n) Q^T M Q; its trailing block holds the Cholesky factor
    order: list[int]  # (n,) the kept rows of J, then the pivots of the trailing block
    diagonal: list[float]  # (n,) diagonal of R
    beta: list[float]  # (n,) Householder: I - beta v v^T


def factor(
    n: int, m: int, M: Sequence[float], J: Sequence[float], rank_cut: float, sqrt: SquareRoot
) -> tuple[Factors, int, int]:
    """Scale, factor J, reduce M, factor it.

    Returns the factors, the rank of J, and the pivots of J and M together: n if the system can be solved,
    -1 if J is not finite.
    """
    d, r = _scales(n, m, M, J)
    A = [J[i * n + j] * r[i] * d[j] for i in range(m) for j in range(n)]
    B = [M[i * n + j] * d[i] * d[j] for i in range(n) for j in range(n)]
    factors = Factors(n, m, d, r, A, B, list(range(n)), [0.0] * n, [0.0] * n)
    rank = _factor_rows(factors, rank_cut, sqrt)
    if rank < 0:
        return factors, 0, -1
    _rotate_mass(factors, rank)
    return factors, rank, _factor_mass(factors, rank, sqrt)


def _exponent(x: float) -> int:
    """Return e with 2^(e-1) <= x < 2^e, within the limits; 0 if x is 0 or not finite."""
    y = float(x)
    if not 0.0 < y < math.inf:
        return 0
    return min(max(math.frexp(y)[1], -EXPONENT_LIMIT), EXPONENT_LIMIT)


def _inverse_power(e: int) -> float:
    return math.ldexp(1.0, -e)


def _scales(n: int, m: int, M: Sequence[float], J: Sequence[float]) -> tuple[list[float], list[float]]:
    """Choose powers of two d, r: diag(M) and the largest entries of the rows of J become about 1.

    With a diagonal of ones M is conditioned nearly as well as diagonal scaling can make it [H section 7.3].
    Massless columns start at the scale of the heaviest one and are then brought up until their largest entry
    in J is about 1: a small entry of J beside larger ones never sets a scale.
    """
    d, r = [0.0] * n, [1.0] * m
    heaviest = 0.0
    for j in range(n):
        heaviest = max(heaviest, M[j * n + j])
    for j in range(n):
        mass = M[j * n + j]
        if not mass > 0.0:
            mass = heaviest
        elif mass < LIGHTEST * heaviest:
            mass = LIGHTEST * heaviest
        d[j] = _inverse_power(_exponent(mass) >> 1)
    for i in range(m):
        top = 0.0
        for j in range(n):
            top = max(top, abs(J[i * n + j]) * d[j])
        r[i] = _inverse_power(_exponent(top))
    for j in range(n):
        if not M[j * n + j] > 0.0:
            top = 0.0
            for i in range(m):
                top = max(top, abs(J[i * n + j]) * r[i] * d[j])
            d[j] = d[j] * _inverse_power(_exponent(top))
    return d, r


# Rank and null space of J


def _factor_rows(factors: Factors, rank_cut: float, sqrt: SquareRoot) -> int:
    """Factor A^T P = Q R by Householder reflections with pivots [GVL 5.2.2, 5.4.2]; return the rank.

    Rows stay in place, `order` names them. Returns -1 if A is not finite.
    """
    n, m, A = factors.n, factors.m, factors.A
    size = [0.0] * m  # squared length of a row; 0 once it is taken
    for i in range(m):
        size[i] = _tail_product(factors, i, i, 0)
        if not size[i] < math.inf:
            return -1
    rank = 0
    while rank < n and rank < m:
        i = _next_row(factors, size, rank, rank_cut)
        if i < 0:
            break
        factors.order[rank] = i
        size[i] = 0.0
        _reflect(factors, i, rank, sqrt)
        for other in range(m):
            if size[other] > 0.0:
                factor = _tail_product(factors, i, other, rank) * factors.beta[rank]
                for j in range(rank, n):
                    A[other * n + j] = A[other * n + j] - factor * A[i * n + j]
        rank += 1
    return rank


def _tail_product(factors: Factors, first: int, second: int, start: int) -> float:
    """Return the inner product of two rows of A from column `start` on."""
    n, A = factors.n, factors.A
    total = 0.0
    for j in range(start, n):
        total = total + A[first * n + j] * A[second * n + j]
    return total


def _next_row(factors: Factors, size: list[float], k: int, rank_cut: float) -> int:
    """Return the earliest row that is far enough from the span of the k rows taken, or -1."""
    share = [0.0] * factors.m  # squared sine of the angle to that span
    best = 0.0
    for i in range(factors.m):
        if size[i] > 0.0:
            share[i] = _tail_product(factors, i, i, k) / size[i]
            best = max(best, share[i])
    if not best > rank_cut * rank_cut:
        return -1
    i = 0
    while not share[i] > PIVOT_SHARE * best:
        i += 1
    return i


def _reflect(factors: Factors, i: int, k: int, sqrt: SquareRoot) -> None:
    """Turn row i into R[k, k] and a Householder vector, without cancellation [GVL 5.1.3]."""
    n, A = factors.n, factors.A
    square = _tail_product(factors, i, i, k)
    length = sqrt(square)
    head = A[i * n + k]
    factors.beta[k] = 1.0 / (square + length * abs(head))
    if head < 0.0:
        factors.diagonal[k] = length
        A[i * n + k] = head - length
    else:
        factors.diagonal[k] = -length
        A[i * n + k] = head + length


# Mass matrix on the null space


def _rotate_mass(factors: Factors, rank: int) -> None:
    """Replace B by Q^T B Q, one symmetric change of rank two for each reflection [GVL 8.3.1]."""
    n, A, B = factors.n, factors.A, factors.B
    p = [0.0] * n
    for k in range(rank):
        v = factors.order[k] * n
        for i in range(n):
            total = 0.0
            for j in range(k, n):
                total = total + B[i * n + j] * A[v + j]
            p[i] = total * factors.beta[k]
        total = 0.0
        for j in range(k, n):
            total = total + p[j] * A[v + j]
        half = 0.5 * (total * factors.beta[k])
        for j in range(k, n):
            p[j] = p[j] - half * A[v + j]
        for i in range(k):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - p[i] * A[v + j]
                B[j * n + i] = B[i * n + j]
        for i in range(k, n):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - (p[i] * A[v + j] + A[v + i] * p[j])


def _factor_mass(factors: Factors, rank: int, sqrt: SquareRoot) -> int:
    """Factor the trailing block by Cholesky with diagonal pivots [GVL 4.2.8]; return how far that went."""
    n, B, order = factors.n, factors.B, factors.order
    floor = CUT_FACTOR * n * EPSILON  # absolute, since diag(M) is about 1 after scaling
    for k in range(rank, n):
        order[k] = k
    for k in range(rank, n):
        best = k
        for c in range(k + 1, n):
            if B[order[c] * n + order[c]] > B[order[best] * n + order[best]]:
                best = c
        i = order[best]
        order[best] = order[k]
        order[k] = i
        if not B[i * n + i] > floor:
            return k
        B[i * n + i] = sqrt(B[i * n + i])
        for c in range(k + 1, n):
            B[order[c] * n + i] = B[order[c] * n + i] / B[i * n + i]
        for a in range(k + 1, n):
            for c in range(k + 1, n):
                entry = order[a] * n + order[c]
                B[entry] = B[entry] - B[order[a] * n + i] * B[order[c] * n + i]
    return n


def apply_reflection(factors: Factors, k: int, x: list[float]) -> None:
    """Overwrite x (n,) with its reflection number k."""
    n, A, v = factors.n, factors.A, factors.order[k] * factors.n
    total = 0.0
    for j in range(k, n):
        total = total + A[v + j] * x[j]
    total = total * factors.beta[k]
    for j in range(k, n):
        x[j] = x[j] - total * A[v + j]


def multiply_q(factors: Factors, rank: int, x: list[float]) -> None:
    """Overwrite x (n,) with Q x; the columns of Q from `rank` on span the null space of the scaled J."""
    for k in range(rank - 1, -1, -1):
        apply_reflection(factors, k, x)
