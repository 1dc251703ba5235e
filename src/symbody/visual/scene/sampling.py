"""Times at which a motion is stored for the eye: few where little happens, the error between them bounded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.visual.scene.body_poses import Floats, Places, Poses, angle_between, interpolate

LENGTH_SHARE: Final = 1e-3  # of the scene's size: less than a pixel of most screens
ANGLE: Final = float(np.deg2rad(0.2))
CURVE_SHARE: Final = 1 / 300  # of a curve's range: about a pixel of its height

# Shares of the bounds for the two steps: midpoints are computed until they fit, then samples are left out.
# Between a sample and a midpoint that is kept the error is a quarter of what it was at the midpoint.
_HALVING: Final = 1.0
_LEAVING_OUT: Final = 0.7

_ROUNDING: Final = 1e-12  # smaller variations of a curve are rounding
_ROUNDS: Final = 14  # halvings of an interval: a jump is not followed any further
_FEWEST: Final = 16  # intervals at the start


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A motion at some times: poses of bodies, and values (N, K) of curves beside them."""

    times: Floats
    poses: Poses
    values: Floats

    def select(self, places: Places | NDArray[np.bool_]) -> Sampled:
        """Return some of the samples."""
        poses = Poses(self.poses.positions[places], self.poses.quaternions[places])
        return Sampled(self.times[places], poses, self.values[places])

    def merge(self, other: Sampled) -> Sampled:
        """Return the samples of both in the order of time."""
        times = np.concatenate([self.times, other.times])
        poses = Poses(
            np.concatenate([self.poses.positions, other.poses.positions]),
            np.concatenate([self.poses.quaternions, other.poses.quaternions]),
        )
        both = Sampled(times, poses, np.concatenate([self.values, other.values]))
        return both.select(np.argsort(times, kind="stable"))


def sample(compute: Callable[[Floats], Sampled], starts: Floats, size: float, most: int) -> Sampled:
    """Return a motion at so many times that what is interpolated between them stays within the bounds.

    Parameters
    ----------
    compute : callable
        Computes the motion at times.
    starts : (N,) array
        Rising times to begin with, such as the steps of an integrator.
    size : float
        Of the scene [m].
    most : int
        Samples at most; where they do not suffice, the largest errors are reduced first.
    """
    samples = compute(_starts(starts, most))
    intervals = np.arange(samples.times.size - 1)  # intervals whose midpoint has not been computed
    for k in range(_ROUNDS):
        intervals = intervals[: max(2 * most - samples.times.size, 0)]
        middles = (samples.times[intervals] + samples.times[intervals + 1]) / 2.0
        inside = (middles > samples.times[intervals]) & (middles < samples.times[intervals + 1])
        intervals, middles = intervals[inside], middles[inside]
        if intervals.size == 0:
            break
        between = compute(middles)
        errors = _errors(samples, intervals, intervals + 1, between, size)
        # Steps of high order may take half a turn, of which a midpoint alone shows nothing.
        is_large = (errors > _HALVING) | (k == 0 and 4 * samples.times.size < most)
        worst = middles[is_large][np.argsort(-errors[is_large], kind="stable")]
        samples = samples.merge(between)
        places = np.searchsorted(samples.times, worst)
        intervals = np.stack([places - 1, places], axis=1).ravel()
    return thin(samples, size, most)


def thin(samples: Sampled, size: float, most: int) -> Sampled:
    """Return as few of the samples as interpolation needs to give all others within the bounds."""
    count = samples.times.size
    if count < 3:
        return samples
    kept = np.zeros(count, dtype=np.bool_)
    kept[[0, -1]] = True
    waiting = [(np.inf, 0, count - 1)]
    left = most - 2
    while waiting and left > 0:  # the intervals of one round at once would need the memory of all
        following = []
        for _, first, last in sorted(waiting, key=lambda each: -each[0])[:left]:
            place, error = _worst(samples, first, last, size)
            if error > _LEAVING_OUT:
                kept[place] = True
                left -= 1
                following += [(error, first, place), (error, place, last)]
            if left == 0:
                break
        waiting = [each for each in following if each[2] - each[1] > 1]
    return samples.select(kept)


def _starts(times: Floats, most: int) -> Floats:
    """Return times that are not too many, and at least some."""
    distinct = np.unique(times)
    if distinct.size < 2:
        return distinct
    evenly = np.linspace(distinct[0], distinct[-1], _FEWEST + 1)
    if distinct.size > most:
        distinct = distinct[np.linspace(0, distinct.size - 1, most).astype(np.intp)]
    return np.union1d(distinct, evenly) if distinct.size < _FEWEST else distinct


def _worst(samples: Sampled, first: int, last: int, size: float) -> tuple[int, float]:
    """Return the sample between two that interpolation misses most, and its error over the bounds."""
    inner = np.arange(first + 1, last)
    if inner.size == 0:
        return first, 0.0
    errors = _errors(
        samples, np.full_like(inner, first), np.full_like(inner, last), samples.select(inner), size
    )
    k = int(np.argmax(errors))
    return int(inner[k]), float(errors[k])


def _errors(samples: Sampled, before: Places, after: Places, truth: Sampled, size: float) -> Floats:
    """Return how far interpolation between samples is from the truth, over the bounds (M,)."""
    start, end = samples.times[before], samples.times[after]
    shares = (truth.times - start) / (end - start)
    guess = interpolate(samples.poses, before, shares, after)
    away = np.linalg.norm(guess.positions - truth.poses.positions, axis=-1) / (LENGTH_SHARE * size)
    turned = angle_between(guess.quaternions, truth.poses.quaternions) / ANGLE
    s = shares[:, np.newaxis]
    values = samples.values[before] * (1.0 - s) + samples.values[after] * s
    ranges = np.ptp(samples.values, axis=0) if samples.values.size else np.zeros(samples.values.shape[1])
    bounds = np.where(ranges > _ROUNDING, CURVE_SHARE * ranges, np.inf)
    off = np.abs(values - truth.values) / bounds
    parts = [array.max(axis=1, initial=0.0) for array in (away, turned, off)]
    errors: Floats = np.max(parts, axis=0)
    return np.nan_to_num(errors, nan=0.0)  # where a motion broke down there is nothing to follow
