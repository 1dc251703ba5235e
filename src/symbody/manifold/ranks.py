"""Ranks of constraint Jacobians, the spaces that their rows span or leave, and rows that span the others.

Columns are in units of their sizes. Where rows may be of any length they are compared at unit length
(`unit_rows`), so that no choice of units decides a rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.tolerances import NEGLIGIBLE, RANK, VANISHING

Floats = NDArray[np.float64]


def unit_rows(rows: Floats) -> Floats:
    """Return rows of length 1; rows that are rounding beside 1 or the longest become zeros."""
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    counts = lengths > VANISHING * lengths.max(initial=1.0)
    return np.asarray(np.where(counts, rows, 0.0) / np.where(counts, lengths, 1.0))


def count_significant(singular: NDArray[np.floating[Any]], cut: float = RANK) -> int:
    """Return the number of singular values above a share of the largest; the most of several matrices."""
    counts = (singular > cut * singular.max(initial=0.0)).sum(axis=-1)
    return int(counts.max(initial=0))


def rank(rows: ArrayLike, cut: float = RANK) -> int:
    """Return the number of independent rows, compared at unit length; 0 where they are not finite."""
    matrix = np.asarray(rows, dtype=np.float64)
    if not matrix.size or not np.isfinite(matrix).all():
        return 0
    return count_significant(np.linalg.svd(unit_rows(matrix), compute_uv=False), cut)


def null_space(rows: ArrayLike, cut: float = RANK) -> Floats:
    """Return an orthonormal basis (n, d) of the directions along which no row changes."""
    matrix = np.asarray(rows, dtype=np.float64)
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, singular, right = np.linalg.svd(matrix)
    return np.asarray(right[count_significant(singular, cut) :].T)


def row_space(rows: Floats, cut: float = RANK) -> Floats:
    """Return orthonormal rows (r, n) that span the rows given."""
    _, singular, right = np.linalg.svd(rows, full_matrices=False)
    return np.asarray(right[: count_significant(singular, cut)])


def least_solution(rows: Floats, right: Floats, cut: float = NEGLIGIBLE) -> Floats:
    """Return the least solution of ``rows x = right``; corrected once, it holds to rounding of its terms."""
    x = np.linalg.lstsq(rows, right, rcond=cut)[0]
    return np.asarray(x + np.linalg.lstsq(rows, right - rows @ x, rcond=cut)[0])


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
