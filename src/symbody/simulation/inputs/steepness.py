"""Whether samples of functions of time may hide something between them.

Operands are polynomials to a good approximation, so all values that they take between samples are known. What
a steep operation makes of these is compared with its samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from symbody.expr import opcodes as op
from symbody.simulation.inputs.time_functions import TimeFunctions

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Bounds = tuple[Floats, Floats]

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
_COUNT: Final = 33
FINE: Final[Floats] = chebvander(-np.cos(np.pi * np.arange(_COUNT) / (_COUNT - 1)), DEGREE) @ TO_COEFFICIENTS
# What may lie beyond the samples: shares of the variation in the piece and in the span, and rounding.
_LOCALLY: Final = 0.1
_GLOBALLY: Final = 1e-4
_ROUNDED: Final = 1e-12
_TOUCHING: Final = 1e-14


def _monotonic(least: float, most: float, function: Callable[[Floats], Floats]) -> Callable[[Bounds], Bounds]:
    """Return what a function that rises or falls throughout makes of bounds, where it is defined."""

    def bounds(given: Bounds) -> Bounds:
        ends = [function(np.clip(end, least, most)) for end in given]
        return np.minimum(*ends), np.maximum(*ends)

    return bounds


def _cosh(given: Bounds) -> Bounds:
    ends = np.cosh(given[0]), np.cosh(given[1])
    return np.where(given[0] * given[1] < 0.0, 1.0, np.minimum(*ends)), np.maximum(*ends)


def _tangent(given: Bounds) -> Bounds:
    same = np.floor(given[0] / np.pi + 0.5) == np.floor(given[1] / np.pi + 0.5)
    return np.where(same, np.tan(given[0]), -np.inf), np.where(same, np.tan(given[1]), np.inf)


def _reciprocal(given: Bounds) -> Bounds:
    ends = 1.0 / given[0], 1.0 / given[1]
    passes = given[0] * given[1] <= 0.0
    return np.where(passes, -np.inf, np.minimum(*ends)), np.where(passes, np.inf, np.maximum(*ends))


_STEEP: Final[Mapping[int, Callable[[Bounds], Bounds]]] = MappingProxyType(
    {
        op.EXP: _monotonic(-np.inf, np.inf, np.exp), op.SINH: _monotonic(-np.inf, np.inf, np.sinh),
        op.TANH: _monotonic(-np.inf, np.inf, np.tanh), op.ATAN: _monotonic(-np.inf, np.inf, np.arctan),
        op.LOG: _monotonic(0.0, np.inf, np.log), op.SQRT: _monotonic(0.0, np.inf, np.sqrt),
        op.ASIN: _monotonic(-1.0, 1.0, np.arcsin), op.ACOS: _monotonic(-1.0, 1.0, np.arccos),
        op.COSH: _cosh, op.TAN: _tangent,
    }
)  # fmt: skip

_DOMAINS: Final[Mapping[int, tuple[float, float]]] = MappingProxyType(
    {op.LOG: (0.0, np.inf), op.SQRT: (0.0, np.inf), op.ASIN: (-1.0, 1.0), op.ACOS: (-1.0, 1.0)}
)


def may_hide_features(functions: TimeFunctions, values: Floats, whole: Floats, ends: Bounds) -> Flags:
    """Return in which pieces (N,) something may lie between the samples.

    Parameters
    ----------
    values : (rows, N, nodes) array
        Samples of all values, and of the differences of the switches looked at, at `chebyshev.NODES`.
    whole : (rows, N) array
        How much each varies over the span.
    ends : two (N,) arrays
        Where the pieces begin and end [s].
    """
    hides = np.zeros(values.shape[1], dtype=np.bool_)
    for k in functions.steep:
        hides |= _steep_may_hide(functions, int(k), values, whole[k], ends)
    first = len(functions.operations)
    counts = functions.counts(functions.open_switches)
    for row, d in enumerate(values[first:]):
        low, high = hull(d)
        slight = _TOUCHING * np.maximum(whole[first + row], np.abs(d).max(axis=1))
        if counts[row]:
            hides |= (low < np.floor(d.min(axis=1)) - slight) | (
                high > np.floor(d.max(axis=1)) + 1.0 + slight
            )
        else:
            hides |= ((d.min(axis=1) >= 0.0) & (low < -slight)) | ((d.max(axis=1) <= 0.0) & (high > slight))
    return hides


def _exceeds(bounds: Bounds, samples: Floats, whole: Floats) -> Flags:
    """Return where bounds lie beyond samples; bounds that are not numbers do."""
    least, most = samples.min(axis=1), samples.max(axis=1)
    allowed = (
        _LOCALLY * (most - least) + _GLOBALLY * whole + _ROUNDED * np.maximum(np.abs(least), np.abs(most))
    )
    return np.asarray(~((bounds[0] >= least - allowed) & (bounds[1] <= most + allowed)), dtype=np.bool_)


def hull(samples: Floats) -> Bounds:
    """Return bounds (N,) of smooth functions from their samples (N, nodes)."""
    fine = samples @ FINE.T
    rows = np.arange(len(fine))
    bounds = []
    for sign in (-1.0, 1.0):
        top = np.argmax(sign * fine, axis=1)
        beside = [
            np.abs(fine[rows, np.clip(top + step, 0, _COUNT - 1)] - fine[rows, top]) for step in (-1, 1)
        ]
        inside = (top > 0) & (top < _COUNT - 1)
        bounds.append(fine[rows, top] + sign * np.where(inside, np.maximum(*beside), 0.0))
    return np.minimum(bounds[0], samples.min(axis=1)), np.maximum(bounds[1], samples.max(axis=1))


def _steep_may_hide(functions: TimeFunctions, k: int, values: Floats, whole: Floats, ends: Bounds) -> Flags:
    """Return in which pieces a value of `TimeFunctions.steep` may be something else between its samples."""
    code, operands, datum = functions.operations[k]
    if code == op.SYMBOL:
        table = functions.tables[functions.names[datum][1]]
        return _exceeds(table.bounds(*ends), values[k] @ FINE.T, whole)
    if code == op.DIV:  # by a value; what is divided shows itself
        divisor = values[operands[1]]
        return _exceeds(_reciprocal(hull(divisor)), 1.0 / divisor, np.zeros(1))
    first = hull(values[operands[0]])
    if code in _STEEP:
        least, most = _DOMAINS.get(code, (-np.inf, np.inf))
        is_defined = (first[1] > least) & (first[0] < most)  # where it is nowhere, nothing is hidden
        return _exceeds(_STEEP[code](first), values[k], whole) & is_defined
    is_fixed = not functions.moves[operands[1]]
    second = (values[operands[1], :, 0],) * 2 if is_fixed else hull(values[operands[1]])
    if code == op.ATAN2:
        passes = [(low <= 0.0) & (high >= 0.0) for low, high in (first, second)]
        return np.asarray(passes[0] & passes[1], dtype=np.bool_)
    corners = [np.power(a, b) for a in first for b in second]
    at_zero = np.where(second[0] < 0.0, np.inf, 0.0)
    corners.append(np.where(first[0] * first[1] <= 0.0, at_zero, corners[0]))
    return _exceeds((np.min(corners, axis=0), np.max(corners, axis=0)), values[k], whole)
