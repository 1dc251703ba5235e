"""Conditions one after the other: what each has of its own beside those before it."""

from __future__ import annotations

from symbody.kernels.language import Reals, part, sqrt


def add_row(n: int, size: int, row: Reals, basis: Reals, cut: float) -> float:
    """Add what a row (n,) of length 1 has of its own to an orthonormal basis of `size` rows.

    Returns its length, or 0 where that does not exceed the cut and nothing is added.
    """
    remainder = part(basis, size * n, n)
    for i in range(n):
        remainder[i] = row[i]
    for _turn in range(2):  # twice is enough (Golub & Van Loan 2013, section 5.2.9)
        for k in range(size):
            share = dot(n, part(basis, k * n, n), remainder)
            for i in range(n):
                remainder[i] = remainder[i] - share * basis[k * n + i]
    length = sqrt(dot(n, remainder, remainder))
    if not length > cut:
        return 0.0
    for i in range(n):
        remainder[i] = remainder[i] / length
    return length


def dot(n: int, a: Reals, b: Reals) -> float:
    """Return the product of two rows."""
    total = 0.0
    for i in range(n):
        total = total + a[i] * b[i]
    return total


def fulfil(n: int, size: int, row: Reals, basis: Reals, length: float, value: float, v: Reals) -> None:
    """Change v by row number `size` of the basis so that the product with the row has a value."""
    share = (value - dot(n, row, v)) / length
    for i in range(n):
        v[i] = v[i] + share * basis[size * n + i]
