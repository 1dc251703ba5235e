"""Angles of cut joints as they go on along a motion: what is measured of them lies within half a turn."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.results.evaluate import Evaluate

Floats = NDArray[np.float64]

# Points within a step: between two of them the angle and its rate change little, however long the step is.
_INSIDE: Final = 16


def count_turns(
    evaluate: Evaluate, name: str, values: Floats, t: Floats, positions: Floats, speeds: Floats,
    dense: DenseOutput | None = None,
) -> Floats:  # fmt: skip
    """Return the values of an output; the angle of a cut joint goes on from turn to turn.

    Parameters
    ----------
    dense : DenseOutput, optional
        The motion, by which turns are counted from its start; else they are counted from sample to sample.

    Raises
    ------
    UsageError
        If the angle turns by more than half a turn between two samples, which then do not tell by how much.
    """
    symbol = name[1:-1] if name.startswith("(") and name.endswith(")") else name
    if symbol not in getattr(evaluate, "wrapped_angles", ()):
        return values
    angle = evaluate(f"({symbol})", t, positions, speeds)
    if angle.shape != values.shape or not np.array_equal(angle, values, equal_nan=True):
        return values  # a word of outputs, such as "B", that an angle has for a name
    if dense is not None:
        return _turns_along(evaluate, symbol, values, t, dense, len(speeds))
    if t.size < 2:
        return values
    rates = evaluate(f"{symbol}_dot", t, positions, speeds)
    if (np.maximum(np.abs(rates[1:]), np.abs(rates[:-1])) * np.abs(np.diff(t)) > np.pi).any():
        raise UsageError(
            Problem("trajectory.turns", repr(name), f"{name} turns by more than half a turn between samples",
                    "the joint is cut: its angle is measured within half a turn, and counted from sample to "
                    "sample", "request more times, or use `simulate`, whose motion is also known between "
                              "samples")
        )  # fmt: skip
    return _count(values, rates, t)


def _turns_along(
    evaluate: Evaluate, name: str, values: Floats, t: Floats, dense: DenseOutput, n_u: int
) -> Floats:
    """Return a measured angle counted from the start of the motion, whatever its samples are."""
    shares = np.arange(_INSIDE) / _INSIDE
    starts, lengths = dense.breaks[:-1, np.newaxis], np.diff(dense.breaks)[:, np.newaxis]
    times = np.append(starts + shares * lengths, dense.breaks[-1])
    x = dense(times)
    between, rates = (evaluate(each, times, x[n_u:], x[:n_u]) for each in (f"({name})", f"{name}_dot"))
    way = 1.0 if times[-1] >= times[0] else -1.0
    near = np.interp(way * t, way * times, _count(between, rates, times))
    return np.asarray(values + _turns(near - values))


def _count(values: Floats, rates: Floats, t: Floats) -> Floats:
    """Return values to which whole turns are added, so that they change as their rates say."""
    steps = np.diff(values)
    expected = 0.5 * np.diff(t) * (rates[1:] + rates[:-1])
    expected = np.where(np.isfinite(expected), expected, 0.0)  # where the angles themselves are singular
    return np.append(values[:1], values[0] + np.cumsum(steps + _turns(expected - steps)))


def _turns(angle: Floats) -> Floats:
    return np.asarray(2.0 * np.pi * np.round(angle / (2.0 * np.pi)))
