"""Random systems for `solve_saddle`, and their solution by Gauss elimination with 50 digits."""

from __future__ import annotations

import random
from dataclasses import dataclass

import mpmath
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DIGITS = 50
WORST_CONDITION = 1e12  # beyond, the inverse that enters the tolerance is itself in doubt
WEAKEST_ROW = 1e-8  # smallest singular value for which nobody can dispute the rank


@dataclass(frozen=True, slots=True, eq=False)
class System:
    """One system; `J` has the rows of `independent`, and others that depend on them, in any order."""

    M: Array
    J: Array
    F: Array
    gamma: Array
    independent: Array
    gamma_independent: Array
    places: tuple[int, ...]  # of the independent rows in J

    @property
    def arguments(self) -> tuple[list[float], list[float], list[float], list[float]]:
        """M, J, F, gamma as flat lists."""
        return self.M.ravel().tolist(), self.J.ravel().tolist(), self.F.tolist(), self.gamma.tolist()


def systems(seed: int, number: int) -> list[System]:
    """Return systems that have a solution and an undisputed rank."""
    rng = random.Random(seed)
    found: list[System] = []
    while len(found) < number:
        system = _system(rng)
        if _undisputed(system):
            found.append(system)
    return found


def _normal(rng: random.Random, *shape: int) -> Array:
    size = int(np.prod(shape))
    return np.array([rng.gauss(0, 1) for _ in range(size)], dtype=float).reshape(shape)


def _spread(rng: random.Random, size: int, decades: float) -> Array:
    return np.array([10 ** rng.uniform(-decades / 2, decades / 2) for _ in range(size)], dtype=float)


def _system(rng: random.Random) -> System:
    n = rng.randint(1, 20)
    kept = rng.randint(0, n)
    units = _spread(rng, n, rng.choice([0, 3]))
    M = _mass_matrix(rng, n, massless=rng.randint(0, kept) if rng.random() < 0.5 else 0)
    M = M * np.outer(units, units)
    sparse = np.array([rng.random() < 0.7 for _ in range(kept * n)]).reshape(kept, n)
    independent = _normal(rng, kept, n) * sparse * units * _spread(rng, kept, rng.choice([0, 6]))[:, None]
    gamma = _normal(rng, kept) * np.abs(independent).max(axis=1, initial=1e-300)
    rows = list(zip(independent, gamma, range(kept), strict=True))
    for _ in range(rng.randint(1, 4) if rng.random() < 0.6 else 0):
        row, value = _dependent(rng, independent, gamma)
        scale = 10 ** rng.uniform(-3, 3)
        rows.insert(rng.randint(0, len(rows)), (row * scale, value * scale, -1))
    J = np.array([row for row, _, _ in rows]).reshape(len(rows), n)
    places = [0] * kept
    for place, (_, _, which) in enumerate(rows):
        if which >= 0:
            places[which] = place
    F = _normal(rng, n) * (np.sqrt(np.diag(M)) if rng.random() < 0.5 else 1.0)
    values = np.array([value for _, value, _ in rows], dtype=float)
    return System((M + M.T) / 2, J, F, values, independent, gamma, tuple(places))


def _mass_matrix(rng: random.Random, n: int, massless: int) -> Array:
    """Six decades: separate bodies, bodies behind coordinates of a tree, or coupled neighbours."""
    masses = _spread(rng, n, rng.choice([0, 3, 6, 6]))
    kind = rng.randrange(3)
    if kind == 0:
        M = np.diag(masses)
    elif kind == 1:
        motion = _normal(rng, n, n)
        M = motion.T @ np.diag(masses) @ motion
    else:
        coupling = _normal(rng, n, n)
        M = (coupling.T @ coupling / n + 0.1 * np.eye(n)) * np.sqrt(np.outer(masses, masses))
    for j in rng.sample(range(n), massless):
        M[j, :] = M[:, j] = 0.0
    return M


def _dependent(rng: random.Random, independent: Array, gamma: Array) -> tuple[Array, float]:
    """A zero row, a copy in other units, or a linear combination."""
    kept, n = independent.shape
    kind = rng.randrange(3)
    if kept == 0 or kind == 0:
        return np.zeros(n), 0.0
    if kind == 1:
        i, factor = rng.randrange(kept), rng.choice([1.0, -1.0, 3.0, 0.1])
        return independent[i] * factor, float(gamma[i]) * factor
    weights = _normal(rng, kept) / np.abs(independent).max(axis=1, initial=1e-300)
    weights *= [rng.random() < 0.6 for _ in range(kept)]
    return weights @ independent, float(weights @ gamma)


def saddle_matrix(M: Array, J: Array) -> Array:
    """[[M, -J^T], [J, 0]]"""
    m = J.shape[0]
    return np.block([[M, -J.T], [J, np.zeros((m, m))]])


def scale_factors(M: Array, J: Array) -> Array:
    """Factors that bring diag(M) and the rows of J to one; not those of the kernel."""
    mass = np.diag(M)
    columns = np.where(mass > 0, 1 / np.sqrt(np.where(mass > 0, mass, 1.0)), 1.0)
    massless = np.abs(J).max(axis=0, initial=0.0)
    columns = np.where((mass <= 0) & (massless > 0), 1 / np.where(massless > 0, massless, 1.0), columns)
    rows = np.abs(J * columns).max(axis=1, initial=0.0)
    return np.concatenate([columns, 1 / np.where(rows > 0, rows, 1.0)])


def _undisputed(system: System) -> bool:
    M, J = system.M, system.independent
    scale = scale_factors(M, J)
    n = M.shape[0]
    scaled = saddle_matrix(M, J) * np.outer(scale, scale)
    singular = np.linalg.svd(scaled[n:, :n], compute_uv=False)
    return bool(singular.min(initial=1.0) > WEAKEST_ROW and np.linalg.cond(scaled) < WORST_CONDITION)


def exact_solution(system: System) -> list[mpmath.mpf]:
    """Return (udot, lambda of the independent rows) with 50 digits."""
    matrix = saddle_matrix(system.M, system.independent)
    right = np.concatenate([system.F, system.gamma_independent])
    with mpmath.workdps(DIGITS):
        return gauss([[mpmath.mpf(x) for x in row] for row in matrix.tolist()], right.tolist())


def gauss(matrix: list[list[mpmath.mpf]], right: list[float]) -> list[mpmath.mpf]:
    """Solve by elimination with row pivots."""
    size = len(right)
    rows = [[*row, mpmath.mpf(x)] for row, x in zip(matrix, right, strict=True)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, size):
            if rows[i][k] != 0:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    x = [mpmath.mpf(0)] * size
    for k in reversed(range(size)):
        known = sum((rows[k][j] * x[j] for j in range(k + 1, size)), mpmath.mpf(0))
        x[k] = (rows[k][size] - known) / rows[k][k]
    return x


def sensitivity(system: System, solution: list[mpmath.mpf]) -> Array:
    """Return |K^-1| (|K| |x| + |b|), the change of x when all data change by one relative unit."""
    scale = scale_factors(system.M, system.independent)
    K = saddle_matrix(system.M, system.independent) * np.outer(scale, scale)
    x = np.array([float(value) for value in solution]) / scale
    b = np.concatenate([system.F, system.gamma_independent]) * scale
    change: Array = (np.abs(np.linalg.inv(K)) @ (np.abs(K) @ np.abs(x) + np.abs(b))) * scale
    return change
