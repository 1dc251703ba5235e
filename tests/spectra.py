"""Spectra compared as sets: rounding decides the order of values that are equal, or of a pair's equal real parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment


def assert_same_spectrum(
    found: ArrayLike, expected: ArrayLike, *, rtol: float = 0.0, atol: float = 0.0
) -> None:
    """Assert that values are the same in any order, by the pairs of least distance in all."""
    one, other = (np.asarray(values, dtype=np.complex128).ravel() for values in (found, expected))
    assert one.size == other.size, (one, other)
    rows, columns = linear_sum_assignment(np.abs(one[:, np.newaxis] - other))
    np.testing.assert_allclose(one[rows], other[columns], rtol=rtol, atol=atol)
