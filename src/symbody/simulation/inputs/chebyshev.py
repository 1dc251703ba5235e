"""Samples of functions of time that show whether a polynomial follows them."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEGREE: Final = 8


def chebyshev_nodes(degree: int) -> Floats:
    """Return the shares of an interval at which a Chebyshev polynomial is extreme, (degree + 1,)."""
    angles = np.pi * np.arange(degree + 1) / degree
    return np.asarray((1.0 - np.cos(angles)) / 2.0, dtype=np.float64)


@cache
def to_coefficients(degree: int) -> Floats:
    """Return the matrix from values at the nodes to Chebyshev coefficients."""
    places = 2.0 * chebyshev_nodes(degree) - 1.0
    values = np.polynomial.chebyshev.chebvander(places, degree)
    return np.asarray(np.linalg.inv(values), dtype=np.float64)


NODES: Final = chebyshev_nodes(DEGREE)
TO_COEFFICIENTS: Final = to_coefficients(DEGREE)
