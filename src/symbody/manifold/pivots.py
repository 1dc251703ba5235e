"""Columns that others follow from best, by factorizations with column pivoting.

Golub & Van Loan, Matrix Computations (2013), section 5.4.2; for dependent coordinates Wehage & Haug, J. Mech.
Des. 104 (1982), 247-255.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def pivot_order(rows: ArrayLike) -> tuple[NDArray[np.intp], Floats]:
    """Return the columns, the largest pivots first, and the sizes of these."""
    matrix = np.asarray(rows, dtype=np.float64)
    if not matrix.size:
        return np.arange(matrix.shape[-1]), np.zeros(0)
    triangle, order = scipy.linalg.qr(matrix, mode="r", pivoting=True)
    return order, np.abs(np.diagonal(triangle))


def column_volume(rows: ArrayLike, columns: ArrayLike) -> float:
    """Return the size of the determinant of as many columns as there are rows; at most 1 for unit rows."""
    return abs(
        float(np.linalg.det(np.asarray(rows, dtype=np.float64)[:, np.asarray(columns, dtype=np.intp)]))
    )
