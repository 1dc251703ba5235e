"""Rotations in NumPy, written apart from the package so that they can judge it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Axis = str | tuple[float, float, float]
LETTERS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def unit(axis: Axis) -> Array:
    """The unit vector of a letter or of three components."""
    vector = np.array(LETTERS[axis] if isinstance(axis, str) else axis, dtype=float)
    found: Array = vector / np.linalg.norm(vector)
    return found


def skew(a: Array) -> Array:
    """The matrix of ``a x``."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]], dtype=float)


def turned(axis: Axis, angle: float) -> Array:
    """The matrix of a turn by the formula of Rodrigues."""
    k = skew(unit(axis))
    found: Array = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return found


def of_quaternion(e: Array) -> Array:
    """The matrix of a unit quaternion, scalar first."""
    w, v = e[0], e[1:]
    found: Array = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * skew(v)
    return found


def quaternion(r: Array) -> Array:
    """A unit quaternion of a matrix, from the largest of its four squares (Shepperd 1978)."""
    trace = np.trace(r)
    squares = np.array([trace, r[0, 0], r[1, 1], r[2, 2]])
    k = int(np.argmax(squares))
    if k == 0:
        e = np.array([1 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    else:
        i = k - 1
        j, m = (i + 1) % 3, (i + 2) % 3
        e = np.zeros(4)
        e[0] = r[m, j] - r[j, m]
        e[1 + i] = 1 + 2 * r[i, i] - trace
        e[1 + j] = r[i, j] + r[j, i]
        e[1 + m] = r[i, m] + r[m, i]
    found: Array = e / np.linalg.norm(e)
    return found


def euler_zyx(r: Array) -> tuple[float, float, float]:
    """Angles of R = Rz Ry Rx."""
    second = float(np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0])))
    return float(np.arctan2(r[1, 0], r[0, 0])), second, float(np.arctan2(r[2, 1], r[2, 2]))
