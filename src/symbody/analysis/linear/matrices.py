"""Linear equations at one state as numbers, with the size of the terms that they are sums of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.linear.independence import Basis, Selection
from symbody.analysis.linear.slopes import Slopes

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Matrices:
    """``x' = affine + A x + B r``, ``y = C x + D r`` for all independent states, cyclic ones too."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    affine: Floats


def matrices(slopes: Slopes, space: Basis) -> Matrices:
    """Return the linear equations at a state."""
    n = len(slopes.rates)
    A = space.back @ slopes.of_rates @ space.out + space.turning
    B, D = space.back @ slopes.by_input[:n], slopes.by_input[n : n + slopes.outputs].copy()
    return Matrices(A, B, slopes.of_outputs @ space.out, D, space.back @ slopes.rates)


def term_sizes(slopes: Slopes, space: Basis) -> Matrices:
    """Return the sums of absolute terms in place of the sums."""
    n, back, out = len(slopes.rates), np.abs(space.back), np.abs(space.out)
    A = back @ np.abs(slopes.of_rates) @ out + np.abs(space.turning)
    B, D = back @ np.abs(slopes.by_input[:n]), np.abs(slopes.by_input[n : n + slopes.outputs])
    return Matrices(A, B, np.abs(slopes.of_outputs) @ out, D, back @ np.abs(slopes.rates))


def scale_matrices(given: Matrices, selection: Selection) -> Matrices:
    """Return matrices for states in units of their sizes."""
    s = selection.sizes
    return Matrices(
        given.A * s / s[:, np.newaxis], given.B / s[:, np.newaxis], given.C * s, given.D, given.affine / s
    )  # fmt: skip


def relative_error(slopes: Slopes, space: Basis, selection: Selection) -> float:
    """Return the relative error of A in eps: the condition of M on the admissible speeds, scaled."""
    mass = space.out[: len(slopes.mass_matrix), : len(selection.speeds.independent)]
    projected = mass.T @ slopes.mass_matrix @ mass
    if not projected.size:
        return 1.0
    scale = np.sqrt(np.abs(np.diag(projected)))
    scale[scale == 0.0] = 1.0
    return max(float(np.linalg.cond(projected / np.outer(scale, scale))), 1.0) * 10.0
