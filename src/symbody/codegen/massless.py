"""Motions that no mass resists: why accelerations are not determined, in names of coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.errors import Problem

Floats = NDArray[np.float64]

# Shares below which an inertia, or a part of a direction, is rounding.
_ZERO: Final = 1e-10
_NO_INERTIA: Final = 1e-20
_TAKES_PART: Final = 1e-3


def massless_speeds(mass: ArrayLike, rows: ArrayLike) -> list[int]:
    """Return the places of the speeds that take part in motions without kinetic energy.

    Parameters
    ----------
    mass : (n, n) array
        Mass matrix, symmetric.
    rows : (m, n) array
        J of the constraints ``J u + b = 0``; only motions that they allow count.
    """
    matrix = np.asarray(mass, dtype=np.float64)
    n = len(matrix)
    inertia = np.abs(np.diagonal(matrix))
    moving = inertia > _NO_INERTIA * inertia.max(initial=0.0)
    scale = 1.0 / np.sqrt(np.where(moving, inertia, 1.0))
    if not n or not np.isfinite(matrix).all() or not np.isfinite(rows).all():
        return []
    allowed = _null_space(np.asarray(rows, dtype=np.float64).reshape(-1, n) * scale)
    energies, motions = np.linalg.eigh(allowed.T @ (matrix * np.outer(scale, scale)) @ allowed)
    idle = np.abs(allowed @ motions[:, np.abs(energies) < _ZERO]).max(axis=1, initial=0.0)
    return [k for k in range(n) if idle[k] > _TAKES_PART]


def massless_problem(code: str, names: Sequence[str], coordinates: Iterable[str]) -> Problem:
    """Return the problem of speeds that no mass resists, by their names."""
    known = set(coordinates)
    plain = [name.removesuffix("_dot") for name in names]
    words = ", ".join(short if short in known else name for short, name in zip(plain, names, strict=True))
    return Problem(
        code, words, f"the mass matrix is singular: the motion of {words} has no mass or inertia",
        "a body without mass or inertia, or a parameter that is 0, can move freely",
        "give what moves there mass or inertia, or prescribe the motion",
    )  # fmt: skip


def undetermined_problem(code: str, names: Sequence[str]) -> Problem:
    """Return the problem of motions without mass that forces do not determine, by their names."""
    words = ", ".join(names)
    return Problem(
        code, words, f"with these parameters forces do not determine {words}, which has no mass",
        "the damping or stiffness along it is 0",
        "give the damping or stiffness along it another value, or give mass to what moves there; a damper "
        "that does not exist should be removed from the model",
    )  # fmt: skip


def _null_space(rows: Floats) -> Floats:
    """Return an orthonormal basis (n, k) of what all rows are perpendicular to."""
    if rows.shape[0] == 0:
        return np.eye(rows.shape[1])
    _, sizes, right = np.linalg.svd(rows)
    basis: Floats = right[int((sizes > _ZERO * sizes.max(initial=0.0)).sum()) :].T
    return basis
