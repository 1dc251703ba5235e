"""The factorization behind `solve_saddle`: scaling, rank and null space of J, reduced mass matrix.

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


def choose_scales(n: int, m: int, M: Reals, J: Reals, d: Reals, r: Reals) -> None:
    """Choose powers of two d, r: diag(M) and the largest entries of the rows of J become about 1.

    With a diagonal of ones M is conditioned nearly as well as diagonal scaling can make it [H section 7.3].
    Massless columns start at the scale of the heaviest one and are then brought up until their largest entry
    in J is about 1: a small entry of J beside larger ones never sets a scale.
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
    for i in range(m):
        top = 0.0
        for j in range(n):
            top = max(top, abs(J[i * n + j]) * d[j])
        r[i] = power_of_two(-exponent(top))
    for j in range(n):
        if not M[j * n + j] > 0.0:
            top = 0.0
            for i in range(m):
                top = max(top, abs(J[i * n + j]) * r[i] * d[j])
            d[j] = d[j] * power_of_two(-exponent(top))


def scale_matrices(n: int, m: int, M: Reals, J: Reals, d: Reals, r: Reals, A: Reals, B: Reals) -> None:
    """Choose scales, and set A (m, n) to the scaled J and B (n, n) to the scaled M."""
    choose_scales(n, m, M, J, d, r)
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
    order: Reals,
    diagonal: Reals,
    beta: Reals,
    size: Reals,
    share: Reals,
) -> int:
    """Factor A^T P = Q R by Householder reflections with pivots [GVL 5.2.2, 5.4.2]; return the rank.

    Rows stay in place, `order` (n,) names them. In kept rows A becomes columns of R, then the Householder
    vector; `diagonal` (n,) is that of R, a reflection is I - beta v v^T. `size` and `share` (m,) are scratch.
    Returns -1 if A is not finite.
    """
    for i in range(m):
        size[i] = tail_product(n, A, i, i, 0)  # squared length of a row; 0 once it is taken
        if not size[i] < INFINITY:
            return -1
    rank = 0
    while rank < n and rank < m:
        pivot = next_row(n, m, rank, rank_cut, A, size, share)
        if pivot < 0:
            break
        order[rank] = float(pivot)
        size[pivot] = 0.0
        reflect(n, pivot, rank, A, diagonal, beta)
        for i in range(m):
            if size[i] > 0.0:
                factor = tail_product(n, A, pivot, i, rank) * beta[rank]
                for j in range(rank, n):
                    A[i * n + j] = A[i * n + j] - factor * A[pivot * n + j]
        rank = rank + 1
    return rank


def tail_product(n: int, A: Reals, first: int, second: int, start: int) -> float:
    """Return the inner product of two rows of A from column `start` on."""
    total = 0.0
    for j in range(start, n):
        total = total + A[first * n + j] * A[second * n + j]
    return total


def next_row(n: int, m: int, k: int, rank_cut: float, A: Reals, size: Reals, share: Reals) -> int:
    """Return the earliest row that is far enough from the span of the k rows taken, or -1.

    `share` becomes the squared sine of each row's angle to that span.
    """
    best = 0.0
    for i in range(m):
        share[i] = 0.0
        if size[i] > 0.0:
            share[i] = tail_product(n, A, i, i, k) / size[i]
            best = max(best, share[i])
    if not best > rank_cut * rank_cut:
        return -1
    row = 0
    while not share[row] > PIVOT_SHARE * best:
        row = row + 1
    return row


def reflect(n: int, i: int, k: int, A: Reals, diagonal: Reals, beta: Reals) -> None:
    """Turn row i into R[k, k] and a Householder vector, without cancellation [GVL 5.1.3]."""
    square = tail_product(n, A, i, i, k)
    length = sqrt(square)
    head = A[i * n + k]
    beta[k] = 1.0 / (square + length * abs(head))
    if head < 0.0:
        diagonal[k] = length
        A[i * n + k] = head - length
    else:
        diagonal[k] = -length
        A[i * n + k] = head + length


def apply_reflection(n: int, k: int, A: Reals, order: Reals, beta: Reals, x: Reals) -> None:
    """Overwrite x (n,) with its reflection number k."""
    v = int(order[k]) * n
    total = 0.0
    for j in range(k, n):
        total = total + A[v + j] * x[j]
    total = total * beta[k]
    for j in range(k, n):
        x[j] = x[j] - total * A[v + j]


def multiply_q(n: int, rank: int, A: Reals, order: Reals, beta: Reals, x: Reals) -> None:
    """Overwrite x (n,) with Q x; the columns of Q from `rank` on span the null space of the scaled J."""
    for k in range(rank - 1, -1, -1):
        apply_reflection(n, k, A, order, beta, x)


# Mass matrix on the null space


def rotate_mass(n: int, rank: int, A: Reals, order: Reals, beta: Reals, B: Reals, p: Reals) -> None:
    """Replace B by Q^T B Q, one symmetric change of rank two a reflection [GVL 8.3.1]; p is scratch."""
    for k in range(rank):
        v = int(order[k]) * n
        for i in range(n):
            total = 0.0
            for j in range(k, n):
                total = total + B[i * n + j] * A[v + j]
            p[i] = total * beta[k]
        total = 0.0
        for j in range(k, n):
            total = total + p[j] * A[v + j]
        share = 0.5 * (total * beta[k])
        for j in range(k, n):
            p[j] = p[j] - share * A[v + j]
        for i in range(k):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - p[i] * A[v + j]
                B[j * n + i] = B[i * n + j]
        for i in range(k, n):
            for j in range(k, n):
                B[i * n + j] = B[i * n + j] - (p[i] * A[v + j] + A[v + i] * p[j])


def factor_mass(n: int, rank: int, B: Reals, order: Reals) -> int:
    """Factor the trailing block by Cholesky with diagonal pivots [GVL 4.2.8]; return how far that went.

    `order` names the pivots from `rank` on.
    """
    floor = CUT_FACTOR * n * EPSILON  # absolute, since diag(M) is about 1 after scaling
    for k in range(rank, n):
        order[k] = float(k)
    for k in range(rank, n):
        best = k
        for c in range(k + 1, n):
            candidate = int(order[c])
            largest = int(order[best])
            if B[candidate * n + candidate] > B[largest * n + largest]:
                best = c
        i = int(order[best])
        order[best] = order[k]
        order[k] = float(i)
        if not B[i * n + i] > floor:
            return k
        B[i * n + i] = sqrt(B[i * n + i])
        for c in range(k + 1, n):
            row = int(order[c]) * n
            B[row + i] = B[row + i] / B[i * n + i]
        for a in range(k + 1, n):
            row = int(order[a]) * n
            for c in range(k + 1, n):
                column = int(order[c])
                B[row + column] = B[row + column] - B[row + i] * B[column * n + i]
    return n
