"""The factorization behind `solve_saddle`: scaling, rank and null space of J, reduced mass matrix.

Rows of J and coordinates of the null space are exchanged in place, so that every index follows from the
sizes. Where these are known when a kernel is compiled, all numbers can stay in registers.

Sources: [GVL] Golub and Van Loan, Matrix Computations, 4th ed.; [H] Higham, Accuracy and Stability of
Numerical Algorithms, 2nd ed.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import INFINITY, Reals, exponent, half, power_of_two, sqrt

EPSILON: Final = 2.0**-52
CUT_FACTOR: Final = 1000.0  # of both cuts, in units of size * EPSILON; the derivation gives the measured gap
PIVOT_SHARE: Final = 0.0625  # an earlier row goes first if its squared sine exceeds this share of the largest
LIGHTEST: Final = 2.0**-40  # entries of diag(M) below this share of the largest no longer set the scale


def count_massless(n: int, M: Reals) -> int:
    """Return how many coordinates have no mass."""
    count = 0
    for j in range(n):
        if not M[j * n + j] > 0.0:
            count = count + 1
    return count


def choose_scales(
    n: int, m: int, massless: int, M: Reals, J: Reals, d: Reals, r: Reals, floors: Reals, tops: Reals
) -> None:
    """Choose powers of two d, r: diag(M) and the largest entries of the rows of J become about 1.

    With a diagonal of ones M is conditioned nearly as well as diagonal scaling can make it [H section 7.3].
    Massless columns get the scale of what they are coupled to. `floors` (n,) and `tops` (m,) are scratch.
    """
    heaviest = 0.0
    for j in range(n):
        heaviest = max(heaviest, M[j * n + j])
    for j in range(n):
        mass = M[j * n + j]
        if not mass > 0.0:
            mass = heaviest
        elif mass < LIGHTEST * heaviest:
            mass = LIGHTEST * heaviest
        d[j] = power_of_two(-half(exponent(mass)))
    scale_rows(n, m, J, d, r)
    if massless > 0:
        scale_massless(n, m, massless, heaviest, M, J, d, r, floors, tops)
        scale_rows(n, m, J, d, r)
        for j in range(n):
            if not M[j * n + j] > 0.0:
                d[j] = d[j] * power_of_two(-exponent(largest_in_column(n, m, j, J, r) * d[j]))


def scale_rows(n: int, m: int, J: Reals, d: Reals, r: Reals) -> None:
    """Choose r for columns that are scaled by d."""
    for i in range(m):
        top = 0.0
        for j in range(n):
            top = max(top, abs(J[i * n + j]) * d[j])
        r[i] = power_of_two(-exponent(top))


def largest_in_column(n: int, m: int, j: int, J: Reals, r: Reals) -> float:
    """Return the largest entry of a column of J, with rows scaled by r."""
    top = 0.0
    for i in range(m):
        top = max(top, abs(J[i * n + j]) * r[i])
    return top


def scale_massless(
    n: int, m: int, massless: int, heaviest: float, M: Reals, J: Reals, d: Reals, r: Reals,
    floors: Reals, tops: Reals,
) -> None:  # fmt: skip
    """Choose d of massless columns: those that share a row of J with others first, then their neighbors.

    Columns that are coupled to none with mass keep the scale of the heaviest one. Entries of J below the
    share LIGHTEST of the largest of their column, with rows scaled by r, count as rounding of zeros.
    """
    for j in range(n):
        floors[j] = LIGHTEST * largest_in_column(n, m, j, J, r)
        if not M[j * n + j] > 0.0:
            d[j] = 0.0
    stop = massless
    for turn in range(n):
        if turn < stop:
            chosen = scale_neighbors(n, m, J, d, r, floors, tops)
            if chosen == 0:
                stop = 0
    for j in range(n):
        if not d[j] > 0.0:
            d[j] = power_of_two(-half(exponent(heaviest)))


def scale_neighbors(n: int, m: int, J: Reals, d: Reals, r: Reals, floors: Reals, tops: Reals) -> int:
    """Choose d of columns that share a row with one that has a scale; return how many there were.

    A speed of such a column is as large as those that it is coupled to if d is the quotient of their scaled
    entry and its own one. Of several rows the middle between the smallest and the largest quotient counts,
    since either may come from a row that is about to vanish.
    """
    for i in range(m):
        tops[i] = 0.0
        for j in range(n):
            entry = abs(J[i * n + j])
            if entry * r[i] > floors[j]:
                tops[i] = max(tops[i], entry * d[j])
    count = 0
    for j in range(n):
        if not d[j] > 0.0:
            least = INFINITY
            most = 0.0
            for i in range(m):
                entry = abs(J[i * n + j])
                if entry * r[i] > floors[j]:
                    if tops[i] > 0.0:
                        least = min(least, tops[i] / entry)
                        most = max(most, tops[i] / entry)
            if most > 0.0:
                d[j] = power_of_two(half(exponent(least * most)))
                count = count + 1
    return count


def scale_matrices(
    n: int, m: int, massless: int, M: Reals, J: Reals, d: Reals, r: Reals, floors: Reals, tops: Reals,
    A: Reals, B: Reals,
) -> None:  # fmt: skip
    """Choose scales, and set A (m, n) to the scaled J and B (n, n) to the scaled M; others are scratch."""
    choose_scales(n, m, massless, M, J, d, r, floors, tops)
    for i in range(m):
        for j in range(n):
            A[i * n + j] = J[i * n + j] * r[i] * d[j]
    for i in range(n):
        for j in range(n):
            B[i * n + j] = M[i * n + j] * d[i] * d[j]


# Rank and null space of J


def factor_rows(
    n: int,
    m: int,
    rank_cut: float,
    A: Reals,
    rows: Reals,
    r: Reals,
    inverse: Reals,
    beta: Reals,
    weight: Reals,
    share: Reals,
) -> int:
    """Factor A^T P = Q R by Householder reflections with pivots [GVL 5.2.2, 5.4.2]; return the rank.

    Kept rows move to the front, `r` (m,) with them, and `rows` (m,) names where they were. They become
    columns of R, then the Householder vector; `inverse` (n,) is that of the diagonal of R, a reflection is
    I - beta v v^T. `weight` and `share` (m,) are scratch. Returns -1 if A is not finite.
    """
    status = measure_rows(n, m, A, rows, weight, share)
    if status > 0:
        return -1
    most = n
    if m < n:
        most = m
    for k in range(most):
        pivot = next_row(m, k, rank_cut, share)
        if pivot < 0:
            return k
        if pivot > k:
            move_row(n, m, pivot, k, A, rows, r, weight, share)
        reflect(n, k, A, inverse, beta)
        if k + 1 < n:
            for i in range(k + 1, m):
                eliminate(n, k, i, A, beta)
                share[i] = tail_product(n, A, i, i, k + 1) * weight[i]
    return most


def measure_rows(n: int, m: int, A: Reals, rows: Reals, weight: Reals, share: Reals) -> int:
    """Set `rows` to 0, 1, ... and `weight` to 1 over squared lengths; return 1 if one is not finite.

    `share` is the squared sine of the angle to the span of the rows taken. Rows of zeros have no weight and
    no share, and are never taken.
    """
    for i in range(m):
        rows[i] = float(i)
        weight[i] = 0.0
        share[i] = 0.0
        square = tail_product(n, A, i, i, 0)
        if not square < INFINITY:
            return 1
        if square > 0.0:
            weight[i] = 1.0 / square
            share[i] = 1.0
    return 0


def eliminate(n: int, k: int, i: int, A: Reals, beta: Reals) -> None:
    """Apply the reflection of row k to row i."""
    factor = tail_product(n, A, k, i, k) * beta[k]
    for j in range(k, n):
        A[i * n + j] = A[i * n + j] - factor * A[k * n + j]


def tail_product(n: int, A: Reals, first: int, second: int, start: int) -> float:
    """Return the inner product of two rows of A from column `start` on, which there is unless n is 0."""
    if n == 0:
        return 0.0
    total = A[first * n + start] * A[second * n + start]
    for j in range(start + 1, n):
        total = total + A[first * n + j] * A[second * n + j]
    return total


def next_row(m: int, k: int, rank_cut: float, share: Reals) -> int:
    """Return the earliest row, from row k on, that is far enough from the span of the k rows taken, or -1."""
    best = 0.0
    for i in range(k, m):
        best = max(best, share[i])
    if best > rank_cut * rank_cut:
        for i in range(k, m):
            if share[i] > PIVOT_SHARE * best:
                return i
    return -1


def move_row(
    n: int, m: int, start: int, k: int, A: Reals, rows: Reals, r: Reals, weight: Reals, share: Reals
) -> None:
    """Move row `start` up to row k; the rows between keep their order."""
    for i in range(m - 1, k, -1):
        if i <= start:
            for j in range(n):
                exchange(A, i * n + j, i * n - n + j)
            exchange(rows, i, i - 1)
            exchange(r, i, i - 1)
            exchange(weight, i, i - 1)
            exchange(share, i, i - 1)


def exchange(x: Reals, i: int, j: int) -> None:
    """Exchange two entries."""
    kept = x[i]
    x[i] = x[j]
    x[j] = kept


def reflect(n: int, k: int, A: Reals, inverse: Reals, beta: Reals) -> None:
    """Turn row k into R[k, k] and a Householder vector, without cancellation [GVL 5.1.3]."""
    square = tail_product(n, A, k, k, k)
    length = sqrt(square)
    head = A[k * n + k]
    beta[k] = 1.0 / (square + length * abs(head))
    if head < 0.0:
        inverse[k] = 1.0 / length
        A[k * n + k] = head - length
    else:
        inverse[k] = -1.0 / length
        A[k * n + k] = head + length


def apply_reflection(n: int, k: int, A: Reals, beta: Reals, x: Reals) -> None:
    """Overwrite x (n,) with its reflection number k."""
    total = A[k * n + k] * x[k]
    for j in range(k + 1, n):
        total = total + A[k * n + j] * x[j]
    total = total * beta[k]
    for j in range(k, n):
        x[j] = x[j] - total * A[k * n + j]


def multiply_q(n: int, rank: int, A: Reals, beta: Reals, x: Reals) -> None:
    """Overwrite x (n,) with Q x; the columns of Q from `rank` on span the null space of the scaled J."""
    for k in range(rank - 1, -1, -1):
        apply_reflection(n, k, A, beta, x)


# Mass matrix on the null space


def rotate_mass(n: int, rank: int, A: Reals, beta: Reals, B: Reals, p: Reals) -> None:
    """Replace B by Q^T B Q, one symmetric change of rank two a reflection [GVL 8.3.1]; p is scratch."""
    for k in range(rank):
        multiply_mass(n, k, A, beta, B, p)
        total = p[k] * A[k * n + k]
        for j in range(k + 1, n):
            total = total + p[j] * A[k * n + j]
        share = 0.5 * (total * beta[k])
        for j in range(k, n):
            p[j] = p[j] - share * A[k * n + j]
        for i in range(k):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - p[i] * A[k * n + j]
                B[j * n + i] = B[i * n + j]
        for i in range(k, n):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - (p[i] * A[k * n + j] + A[k * n + i] * p[j])


def multiply_mass(n: int, k: int, A: Reals, beta: Reals, B: Reals, p: Reals) -> None:
    """Set p (n,) to beta B v of reflection number k; B is symmetric, so its rows serve as columns."""
    for i in range(n):
        p[i] = B[k * n + i] * A[k * n + k]
    for j in range(k + 1, n):
        for i in range(n):
            p[i] = p[i] + B[j * n + i] * A[k * n + j]
    for i in range(n):
        p[i] = p[i] * beta[k]


def factor_mass(n: int, rank: int, B: Reals, columns: Reals, inverse: Reals) -> int:
    """Factor the trailing block as L D L^T with diagonal pivots [GVL 4.1, 4.2.8]; return how far that went.

    Rows of D L^T take the place of the upper half of B, whose other entries are no longer of use from row
    `rank` on; `inverse` (n,) gets those of D, `columns` (n,) the exchanges, from `rank` on.
    """
    floor = CUT_FACTOR * n * EPSILON  # absolute, since diag(M) is about 1 after scaling
    for k in range(rank, n):
        columns[k] = float(k)
    for k in range(rank, n):
        best = largest_pivot(n, k, B)
        columns[k] = float(best)
        if best > k:
            for c in range(k + 1, n):
                if c == best:
                    exchange_coordinates(n, k, c, B)
        if not B[k * n + k] > floor:
            return k
        inverse[k] = 1.0 / B[k * n + k]
        for i in range(k + 1, n):
            factor = B[k * n + i] * inverse[k]
            for j in range(i, n):
                B[i * n + j] = B[i * n + j] - factor * B[k * n + j]
    return n


def largest_pivot(n: int, k: int, B: Reals) -> int:
    """Return the first of the largest entries of the diagonal from k on."""
    best = k
    top = B[k * n + k]
    for c in range(k + 1, n):
        if B[c * n + c] > top:
            best = c
            top = B[c * n + c]
    return best


def exchange_coordinates(n: int, k: int, c: int, B: Reals) -> None:
    """Exchange coordinates k and c > k of a symmetric matrix, of which the upper half is stored."""
    for j in range(k):
        exchange(B, j * n + k, j * n + c)
    exchange(B, k * n + k, c * n + c)
    for j in range(k + 1, c):
        exchange(B, k * n + j, j * n + c)
    for j in range(c + 1, n):
        exchange(B, k * n + j, c * n + j)


def permute(n: int, rank: int, columns: Reals, x: Reals) -> None:
    """Exchange the entries of x (n,) from `rank` on as `factor_mass` exchanged coordinates."""
    for k in range(rank, n):
        if columns[k] > float(k):
            for c in range(k + 1, n):
                if columns[k] == float(c):
                    exchange(x, k, c)


def permute_back(n: int, rank: int, columns: Reals, x: Reals) -> None:
    """Undo `permute`."""
    for k in range(n - 1, rank - 1, -1):
        if columns[k] > float(k):
            for c in range(k + 1, n):
                if columns[k] == float(c):
                    exchange(x, k, c)
