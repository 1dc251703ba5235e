"""The times at which a motion is drawn: so close that no peak is cut off, and twice where something jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import SymbodyError
from symbody.simulation.results.trajectory import Trajectory

Floats = NDArray[np.float64]

SMOOTH: Final = 1000  # points a curve gets at least where the motion between its samples is known
TOLERANCE: Final = 3e-4  # how far a line may be from its curve, of the curve's range
_MOST: Final = 20_000  # points that refinement does not exceed
_ROUNDS: Final = 12
_CLOSEST: Final = 1e-6  # of the whole time: no interval shorter than twice this is halved
_STEEP: Final = 1e-12  # of the whole time: two times closer than this are the sides of a jump
_NOISE: Final = 1e-12  # of the largest value: a range below this is rounding


def is_continuous(run: Trajectory, name: str) -> bool:
    """Return whether an output is known between the samples."""
    if run.dense_output is None or run.t.ndim == 0 or run.t.size < 2 or not _is_monotonic(run.t):
        return False
    if name not in run.stored:
        return True
    try:
        run.at(float(run.t[0]))[name]
    except SymbodyError:  # what was stored beside the motion, or loaded with it
        return False
    return True


def smooth_motion(run: Trajectory, names: Sequence[str]) -> Trajectory:
    """Return the motion at times between which straight lines do for all of some outputs.

    Each step of the integrator begins and ends at its own side of a possible jump: a state, a reaction or
    an input that jumps there has both values, one after the other. In between, intervals are halved until
    the lines differ from the curves by less than `TOLERANCE` of the range.

    Parameters
    ----------
    names : sequence of str
        Outputs that are known between the samples.
    """
    t = _step_times(run)
    span = abs(float(t[-1] - t[0]))
    for _ in range(_ROUNDS):
        motion = run.at(t)
        if t.size >= _MOST:
            return motion
        rough = np.zeros(t.size - 1, dtype=bool)
        for name in names:
            for values in motion[name].reshape(-1, t.size):
                rough |= _rough_intervals(t, values)
        rough &= np.abs(np.diff(t)) > 2.0 * _CLOSEST * span
        if not rough.any():
            return motion
        places = np.flatnonzero(rough)[: _MOST - t.size]
        t = np.insert(t, places + 1, (t[places] + t[places + 1]) / 2.0)
    return run.at(t)


def _is_monotonic(t: Floats) -> bool:
    steps = np.diff(t)
    return bool((steps >= 0.0).all() or (steps <= 0.0).all()) and t[0] != t[-1]


def _step_times(run: Trajectory) -> Floats:
    """Return times within the steps; an inner end of a step has a time just before it, too."""
    assert run.dense_output is not None
    first, last = float(run.t[0]), float(run.t[-1])
    breaks = run.dense_output.breaks
    inner = np.unique(breaks[(breaks > min(first, last)) & (breaks < max(first, last))])
    inner = inner if last > first else inner[::-1]
    starts, ends = np.append(first, inner), np.append(inner, last)
    count = starts.size
    pieces = max(8 if count <= SMOOTH else 4 if count <= 10 * SMOOTH else 2, math.ceil(SMOOTH / count))
    shares = np.arange(pieces + 1) / pieces
    times = starts[:, np.newaxis] + (ends - starts)[:, np.newaxis] * shares
    times[:, -1] = np.append(np.nextafter(inner, first), last)
    # The samples themselves are drawn, too.
    own = np.unique(np.concatenate([times.ravel(), run.t]))
    return own if last > first else own[::-1]


def _rough_intervals(t: Floats, values: Floats) -> NDArray[np.bool_]:
    """Return between which neighbours the curve leaves its chord, by the curvature at their ends."""
    rough = np.zeros(t.size - 1, dtype=bool)
    finite = values[np.isfinite(values)]
    reach = float(np.ptp(finite)) if finite.size else 0.0
    if reach <= _NOISE * float(np.abs(finite).max(initial=0.0)):
        return rough
    gaps = np.abs(np.diff(t))
    left, right = gaps[:-1], gaps[1:]
    is_smooth = np.minimum(left, right) > _STEEP * abs(t[-1] - t[0])
    left, right = np.where(is_smooth, left, 1.0), np.where(is_smooth, right, 1.0)
    with np.errstate(invalid="ignore"):
        chord = values[:-2] + (values[2:] - values[:-2]) * left / (left + right)
        distance = np.where(is_smooth, np.abs(values[1:-1] - chord), 0.0)
        # a parabola through three points leaves its chords by these parts of the distance
        rough[:-1] |= distance * left / (4.0 * right) > TOLERANCE * reach
        rough[1:] |= distance * right / (4.0 * left) > TOLERANCE * reach
    return rough
