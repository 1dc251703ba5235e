"""Ranks of constraint Jacobians, and rows or columns that span the others.

Rows are compared at unit length (columns in units of their sizes), so that no choice of units decides a rank.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.manifold.tolerances import RANK, VANISHING

Floats = NDArray[np.float64]


def unit_rows(rows: Floats) -> Floats:
    """Return rows of length 1; rows that are rounding beside 1 or the longest become zeros."""
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    counts = lengths > VANISHING * lengths.max(initial=1.0)
    return np.asarray(np.where(counts, rows, 0.0) / np.where(counts, lengths, 1.0))


def singular_values(rows: Floats) -> Floats:
    """Return the singular values of unit rows, the largest first."""
    if not rows.size:
        return np.zeros(0)
    return np.asarray(np.linalg.svd(unit_rows(rows), compute_uv=False))


def rank(rows: ArrayLike) -> int:
    """Return the number of independent rows; 0 where they are not finite."""
    matrix = np.asarray(rows, dtype=np.float64)
    if not np.isfinite(matrix).all():
        return 0
    values = singular_values(matrix)
    return int((values > RANK * values.max(initial=0.0)).sum()) if values.any() else 0


def null_space(rows: Floats) -> Floats:
    """Return an orthonormal basis (n, d) of the directions along which no row changes."""
    if not rows.size or not rows.any():
        return np.eye(rows.shape[1])
    return np.asarray(np.linalg.svd(unit_rows(rows))[2][rank(rows) :].T)


def independent_rows(rows: Floats, order: Sequence[int] | None = None) -> list[int]:
    """Return rows that span all others, the first of an order preferred (Gram-Schmidt, done twice)."""
    unit = unit_rows(rows)
    basis = np.zeros((0, rows.shape[1]))
    kept: list[int] = []
    for k in range(len(rows)) if order is None else order:
        row = unit[k]
        for _ in range(2):  # twice is enough (Golub & Van Loan 2013, section 5.2.9)
            row = row - basis.T @ (basis @ row)
        length = float(np.linalg.norm(row))
        if length > RANK:
            basis = np.vstack([basis, row / length])
            kept.append(k)
    return kept


def independent_columns(rows: ArrayLike) -> list[int]:
    """Return columns that determine all others: the earliest possible."""
    matrix = unit_rows(np.asarray(rows, dtype=np.float64))
    n = matrix.shape[1]
    dependent = independent_rows(matrix.T, list(reversed(range(n))))
    return [k for k in range(n) if k not in dependent]
