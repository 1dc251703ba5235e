"""Samples of functions of time that show whether a polynomial follows them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEGREE: Final = 8


def chebyshev_nodes(degree: int) -> Floats:
    """Return the shares of an interval at which a Chebyshev polynomial is extreme, (degree + 1,)."""
    shares: Floats = (1.0 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2.0
    return shares


def to_coefficients(degree: int) -> Floats:
    """Return the matrix from values at the nodes to Chebyshev coefficients."""
    places = 2.0 * chebyshev_nodes(degree) - 1.0
    matrix: Floats = np.linalg.inv(np.polynomial.chebyshev.chebvander(places, degree))
    return matrix


NODES: Final = chebyshev_nodes(DEGREE)
TO_COEFFICIENTS: Final = to_coefficients(DEGREE)
