"""Velocities that fit the constraints and the values given."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.closure import Closure
from symbody.analysis.dependent_speeds import check_pivots
from symbody.errors import AssemblyError, Problem

Floats = NDArray[np.float64]

_CONSISTENT = 1e-9
_INDEPENDENT = 1e-6  # smaller singular values mean that a speed is given already, up to closeness


def consistent_speeds(
    task: Closure, q: Floats, fixed: Mapping[str, float], guess: Mapping[str, float]
) -> Floats:
    """Return u with ``J u + b = 0`` and the fixed rates; independent speeds left take their guess, else 0.

    Speeds and rates with a guess are asked first, in the order of the guesses, also those of cut joints; then
    the other speeds, in their order; eliminated ones too, so that both forms of the equations start alike.

    Raises
    ------
    AssemblyError
        If dependent speeds do not follow from the others, or the fixed rates contradict the constraints or
        each other, naming the smallest set that does.
    """
    check_pivots(task, q)
    rows, right = task.velocity_rows(q, fixed)
    u, error = _solved(rows, right)
    if error > _CONSISTENT * (1.0 + float(np.abs(right).max(initial=0.0))):
        raise AssemblyError(_conflict(task, q, fixed))
    basis = _basis(rows)
    for name in dict.fromkeys([*task.parted(guess)[1], *task.all_speeds]):
        own, value = task.speed_row(q, name, guess.get(name, 0.0))
        left = _outside(basis, own / max(float(np.linalg.norm(own)), 1e-300))
        distance = float(np.linalg.norm(left))
        if distance > _INDEPENDENT:
            rows = np.vstack([rows, own])
            right = np.append(right, value)
            basis = np.vstack([basis, _outside(basis, left / distance)])
    return _solved(rows, right)[0]


def _solved(rows: Floats, right: Floats) -> tuple[Floats, float]:
    """Return the least solution and the largest residual."""
    if rows.shape[0] == 0:
        return np.zeros(rows.shape[1]), 0.0
    scale = np.linalg.norm(rows, axis=1)
    scale[scale == 0.0] = 1.0
    u = np.linalg.lstsq(rows / scale[:, np.newaxis], right / scale, rcond=1e-10)[0]
    return u, float(np.abs(rows @ u - right).max(initial=0.0))


def _basis(rows: Floats) -> Floats:
    """Return orthonormal rows that span the rows given, each of which counts whatever its unit."""
    lengths = np.linalg.norm(rows, axis=1)
    lengths[lengths == 0.0] = 1.0
    sizes, right = np.linalg.svd(rows / lengths[:, np.newaxis], full_matrices=False)[1:]
    return np.asarray(right[sizes > _INDEPENDENT * sizes.max(initial=1e-300)])


def _outside(basis: Floats, row: Floats) -> Floats:
    """Return the part of a row that is perpendicular to the basis."""
    return np.asarray(row - basis.T @ (basis @ row))


def _conflict(task: Closure, q: Floats, fixed: Mapping[str, float]) -> Problem:
    conflict = dict(fixed)
    for name in fixed:
        rest = {key: value for key, value in conflict.items() if key != name}
        rows, right = task.velocity_rows(q, rest)
        if _solved(rows, right)[1] > _CONSISTENT * (1.0 + float(np.abs(right).max(initial=0.0))):
            conflict = rest
    listed = ", ".join(f"{name} = {value:g}" for name, value in conflict.items()) or "the motions in time"
    return Problem(
        "assembly.velocity_conflict", "fixed", f"no motion from this configuration has {listed}",
        "the constraints tie these rates to each other", "leave one of them out",
    )  # fmt: skip
