"""Zeros of functions of time along a motion: sampled closely enough to be resolved, then refined.

Each step is sampled at the Chebyshev points of one degree above that of its dense output. Where the highest
coefficients of the polynomial through them are not small, the step is halved: a motion that is slow takes
long steps, but what is watched may depend on time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

import numpy as np
import scipy
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Watched = Callable[[Floats], Floats]  # times (N,) to values (n, N)

DEGREE: Final = 8
_DEEPEST: Final = 12  # halvings of a step
_RESOLVED: Final = 1e-3
_EXACT: Final = 1e-15  # of a time, and of the interval a zero lies in
TOUCHING: Final = 1e-10  # of the largest value so far: an extremum this close to zero touches it
NODES: Final = (1.0 - np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)) / 2.0
# Values at the nodes to Chebyshev coefficients.
TO_COEFFICIENTS: Final = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * NODES - 1.0, DEGREE))


class Crossing(NamedTuple):
    """A zero.

    Attributes
    ----------
    t : float
        When.
    place : int
        Which of the functions.
    direction : int
        1 if it rises as the motion goes on, -1 if it falls, 0 if it touches.
    """

    t: float
    place: int
    direction: int


def samples(watched: Watched, breaks: Floats) -> tuple[Floats, Floats]:
    """Return times (N,) from the first to the last break, and the values (n, N) there."""
    starts, ends = breaks[:-1], breaks[1:]
    times: list[Floats] = []
    values: list[Floats] = []
    for depth in range(_DEEPEST + 1):
        t = starts[:, np.newaxis] + (ends - starts)[:, np.newaxis] * NODES
        t[:, -1] = ends
        g = watched(t.ravel())
        g = g.reshape(g.shape[0], *t.shape)
        coefficients = np.abs(g @ TO_COEFFICIENTS.T)
        rough = (coefficients[..., -2:].max(axis=-1) > _RESOLVED * coefficients.max(axis=-1)).any(axis=0)
        if depth == _DEEPEST:
            rough[:] = False
        times.append(t[~rough])
        values.append(g[:, ~rough])
        if not rough.any():
            break
        middle = t[rough, DEGREE // 2]
        starts, ends = np.concatenate([starts[rough], middle]), np.concatenate([middle, ends[rough]])
    return _in_order(np.concatenate(times), np.concatenate(values, axis=1))


def _in_order(t: Floats, g: Floats) -> tuple[Floats, Floats]:
    """Return the samples of all intervals one after the other, each end once."""
    order = np.argsort(t[:, 0]) if t[0, 0] <= t[0, -1] else np.argsort(-t[:, 0])
    t, g = t[order], g[:, order]
    times = np.append(t[:, :-1].ravel(), t[-1, -1])
    values = np.concatenate([g[:, :, :-1].reshape(g.shape[0], -1), g[:, -1, -1:]], axis=1)
    return times, values


def crossings(watched: Watched, t: Floats, g: Floats, last: int, largest: Floats) -> Iterator[Crossing]:
    """Yield the zeros between samples up to number `last`, in no order.

    Parameters
    ----------
    t, g : (N,), (n, N) arrays
        Samples; a value that is exactly zero at the first has not happened here.
    last : int
        Sample up to which to look; those beyond decide what is an extremum.
    largest : (n,) array
        Largest values so far.
    """
    for place, values in enumerate(g):
        sizes = np.abs(values)
        signs = np.sign(values)
        for k in np.flatnonzero((signs[:last] != 0) & (signs[:last] != signs[1 : last + 1])):
            if signs[k + 1] == 0:
                yield Crossing(float(t[k + 1]), place, direction_behind(signs, int(k)))
            elif not np.isnan(values[k : k + 2]).any():
                root = _root(watched, place, float(t[k]), float(t[k + 1]))
                yield Crossing(root, place, int(signs[k + 1]))
        inner, left, right = sizes[1:-1], sizes[:-2], sizes[2:]
        lowest = (inner <= left) & (inner <= right) & (inner > 0)
        near = inner <= 4.0 * np.maximum(left - inner, right - inner)
        one_side = (signs[1:-1] == signs[:-2]) & (signs[1:-1] == signs[2:])
        scale = np.maximum(np.maximum.accumulate(sizes), largest[place])
        for k in 1 + np.flatnonzero(lowest & near & one_side):
            if k <= last:
                yield from _touches(watched, place, t[k - 1 : k + 2], float(signs[k]), float(scale[k + 1]))


def direction_behind(signs: Floats, k: int) -> int:
    """Return the direction of a zero that a sample hit, the one behind sample `k`."""
    rest = signs[k + 1 :]
    rest = rest[rest != 0]
    after = rest[0] if rest.size else -signs[k]
    return 0 if after == signs[k] else int(after)


def _root(watched: Watched, place: int, a: float, b: float) -> float:
    ends = watched(np.array([a, b]))[place]
    size = float(np.abs(ends).max())
    if np.sign(ends[0]) * np.sign(ends[1]) >= 0.0:  # a sample that was zero up to rounding
        return a if abs(ends[0]) <= abs(ends[1]) else b
    # Products of tiny values would be zero, so the function is looked at in units of its larger end.
    shortest = _EXACT * abs(b - a)
    return float(
        scipy.optimize.brentq(
            lambda t: watched(np.array([t]))[place, 0] / size, a, b, xtol=shortest, rtol=_EXACT
        )
    )


def _touches(watched: Watched, place: int, t: Floats, sign: float, scale: float) -> Iterator[Crossing]:
    """Yield the one or two zeros about an extremum between three samples on one side, if there are any."""
    first, last = sorted((float(t[0]), float(t[2])))
    lowest, value = _extremum(watched, place, first, last, sign)
    if value * sign < -TOUCHING * scale:
        yield Crossing(_root(watched, place, float(t[0]), lowest), place, -int(sign))
        yield Crossing(_root(watched, place, lowest, float(t[2])), place, int(sign))
    elif abs(value) <= TOUCHING * scale:
        yield Crossing(lowest, place, 0)


def _extremum(watched: Watched, place: int, first: float, last: float, sign: float) -> tuple[float, float]:
    """Return time and value of the lowest point of sign times a function, from its smooth interpolant."""
    curve = Chebyshev.interpolate(lambda t: watched(np.asarray(t))[place], 12, [first, last])
    roots = np.asarray(curve.deriv().roots(), dtype=np.complex128)
    real: Floats = roots.real[np.abs(roots.imag) < 1e-6 * (last - first)]
    flat = np.array([first, *real[(real > first) & (real < last)], last])
    values = watched(flat)[place]
    lowest = int(np.argmin(sign * values))
    return float(flat[lowest]), float(values[lowest])


def find_missed_return(watched: Watched, place: int, t: Floats, g: Floats) -> tuple[Crossing, bool] | None:
    """Return the zero between the first two samples of a value that starts at zero, if there is one.

    The slope at the start decides: a value that leaves zero upwards and is below it at the next sample has
    come back in between. The second entry: whether the return stands above rounding.

    Parameters
    ----------
    t, g : arrays (N,)
        Samples of the function, N >= 3.
    """
    first, last = float(t[0]), float(t[1])
    low, high = sorted((first, last))
    curve = Chebyshev.interpolate(lambda times: watched(np.asarray(times))[place], DEGREE, [low, high])
    slope = float(curve.deriv()(first)) * np.sign(last - first)
    noise = 1e-13 * float(np.abs(g[:2]).max()) / (high - low)
    if not abs(slope) > noise or slope * g[1] >= 0.0:
        return None
    sign = float(np.sign(slope))
    top, value = _extremum(watched, place, low, high, -sign)
    if top not in (first, last) and value * sign > 1e-15 * float(np.abs(g).max()):
        return Crossing(_root(watched, place, top, last), place, -int(sign)), True
    return Crossing(first, place, -int(sign)), False
