"""One Runge-Kutta step as part of the compiled loop: stages, local error, dense output.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after
one. Sections are those of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed.
"""

from __future__ import annotations

import numpy as np

from symbody.simulation.native.interface import Floats, Goal, Memory, Method, RightHandSide, call, inline
from symbody.simulation.native.layout import (
    ERROR_1,
    ERROR_2,
    EVALUATIONS,
    KERNEL,
    NOTHING,
    STAGE,
    STATE_NEW,
    STATE_OLD,
)
from symbody.simulation.native.simd import WIDTH, everywhere, four, plus, put, times


@inline
def evaluate(rhs: RightHandSide, memory: Memory, t: float, source: int, target: int) -> None:
    """Write the derivative at vectors[source] to K[target], and a fault of the function to its counter."""
    rhs.clock[0] = t
    memory.counts[EVALUATIONS] += 1
    n = memory.K.shape[1]
    code = call(rhs, memory.vectors, source * n, memory.K, target * n)
    if code != 0:
        memory.counts[KERNEL] = code


@inline
def four_states(block: int, n: int) -> tuple[np.uintp, np.uintp, np.uintp, np.uintp]:
    """Return the places of four states from `block` on; at the end some stand for states before.

    Loops take four states at a time, whose sums stay in registers; what is computed twice gets the same value
    twice. Unsigned places spare numba a look whether they count from the end.
    """
    first = max(min(block, n - 4), 0)
    second, third, fourth = min(first + 1, n - 1), min(first + 2, n - 1), min(first + 3, n - 1)
    return np.uintp(first), np.uintp(second), np.uintp(third), np.uintp(fourth)


@inline
def _sums(
    method: Method, row: int, K: Floats, i: np.uintp, j: np.uintp, k: np.uintp, m: np.uintp
) -> tuple[float, float, float, float]:
    """Return a row of the tableau times K, for four states."""
    a = b = c = d = 0.0
    for entry in range(method.first[row], method.first[row + 1]):
        stage, weight = method.columns[entry], method.weights[entry]
        a += weight * K[stage, i]
        b += weight * K[stage, j]
        c += weight * K[stage, k]
        d += weight * K[stage, m]
    return a, b, c, d


@inline
def _combine(method: Method, row: int, memory: Memory, factor: float, base: int, target: int) -> None:
    """Set vectors[target] to vectors[base] plus `factor` times a row of the tableau times K."""
    vectors, K, n = memory.vectors, memory.K, memory.K.shape[1]
    if n >= WIDTH:
        for block in range(0, n, WIDTH):
            first = min(block, n - WIDTH)  # the last four may have been computed before, to the same values
            total = everywhere(0.0)
            for entry in range(method.first[row], method.first[row + 1]):
                slopes = four(K, method.columns[entry] * n + first)
                total = plus(total, times(everywhere(method.weights[entry]), slopes))
            moved = plus(four(vectors, base * n + first), times(everywhere(factor), total))
            put(vectors, target * n + first, moved)
        return
    for block in range(0, n, 4):
        i, j, k, m = four_states(block, n)
        a, b, c, d = _sums(method, row, K, i, j, k, m)
        vectors[target, i] = vectors[base, i] + factor * a
        vectors[target, j] = vectors[base, j] + factor * b
        vectors[target, k] = vectors[base, k] + factor * c
        vectors[target, m] = vectors[base, m] + factor * d


@inline
def _copy(memory: Memory, first: int, stop: int, source: int, target: int) -> None:
    """Copy some states of one vector to another."""
    for i in range(first, stop):
        memory.vectors[target, i] = memory.vectors[source, i]


@inline
def row_is_finite(array: Floats, row: int) -> bool:
    """Return whether a row holds no infinity and no NaN."""
    for i in range(array.shape[1]):
        if not np.isfinite(array[row, i]):
            return False
    return True


@inline
def scale(goal: Goal, memory: Memory, i: int) -> float:
    """Return how large a local error of state i may be."""
    vectors = memory.vectors
    scale: float = goal.atol[i] + goal.rtol * max(abs(vectors[STATE_OLD, i]), abs(vectors[STATE_NEW, i]))
    return scale


@inline
def _error_norm(method: Method, goal: Goal, memory: Memory, h: float) -> float:
    """Return the local error over its tolerance: section II.4."""
    vectors = memory.vectors
    row = memory.K.shape[0]
    _combine(method, row, memory, 1.0, NOTHING, ERROR_1)
    _combine(method, row + 1, memory, 1.0, NOTHING, ERROR_2)
    first = 0.0
    second = 0.0
    for i in range(vectors.shape[1]):
        share = 1.0 / scale(goal, memory, i)
        first += (vectors[ERROR_1, i] * share) ** 2
        second += (vectors[ERROR_2, i] * share) ** 2
    return error_size(first, second, h, vectors.shape[1])


@inline
def error_size(first: float, second: float, h: float, n: int) -> float:
    """Return the local error from the sums of squares of both estimates: section II.10."""
    if first == 0.0:
        return 0.0
    error: float = abs(h) * first / np.sqrt((first + 0.01 * second) * n)
    return error


@inline
def attempt(rhs: RightHandSide, method: Method, goal: Goal, memory: Memory, t: float, h: float) -> float:
    """Compute the stages of one step and the new state; return the error norm, infinite if not finite."""
    memory.counts[KERNEL] = 0
    end = method.stages
    for k in range(1, end):
        _combine(method, k, memory, h, STATE_OLD, STAGE)
        if method.split:
            _copy(memory, rhs.n_u, memory.K.shape[1], STATE_OLD, STAGE)
        evaluate(rhs, memory, t + method.c[k] * h, STAGE, k)
    _combine(method, end, memory, h, STATE_OLD, STATE_NEW)
    if method.split:
        _copy(memory, 0, rhs.n_u, STAGE, STATE_NEW)
    if method.error_reads_end:
        evaluate(rhs, memory, t + h, STATE_NEW, end)
    error = _error_norm(method, goal, memory, h)
    if error <= 1.0 and not method.error_reads_end:
        evaluate(rhs, memory, t + h, STATE_NEW, end)
    if np.isnan(error) or memory.counts[KERNEL] != 0:
        return np.inf
    return error if error > 1.0 or row_is_finite(memory.K, end) else np.inf


@inline
def _dense_row(method: Method, K: Floats, h: float, F: Floats, piece: int, row: int) -> bool:
    """Set F[piece, row] to h times its row of the tableau times K; return whether it is finite."""
    n = K.shape[1]
    zero = 0.0  # becomes NaN
    for block in range(0, n, 4):
        i, j, k, m = four_states(block, n)
        a, b, c, d = _sums(method, K.shape[0] + 2 + row - 4, K, i, j, k, m)
        F[piece, row, i] = h * a
        F[piece, row, j] = h * b
        F[piece, row, k] = h * c
        F[piece, row, m] = h * d
        zero += 0.0 * (h * a) + 0.0 * (h * b) + 0.0 * (h * c) + 0.0 * (h * d)
    return zero == 0.0


@inline
def form_dense_output(
    rhs: RightHandSide, method: Method, memory: Memory, t: float, h: float, F: Floats, piece: int
) -> bool:
    """Fill F[piece] for the step just tried; return whether all of it is finite."""
    vectors, K = memory.vectors, memory.K
    end = method.stages
    for k in range(end + 1, K.shape[0]):
        _combine(method, k, memory, h, STATE_OLD, ERROR_1)  # STAGE is still needed to judge stiffness
        evaluate(rhs, memory, t + method.c[k] * h, ERROR_1, k)
    for i in range(K.shape[1]):
        move = vectors[STATE_NEW, i] - vectors[STATE_OLD, i]
        F[piece, 0, i] = vectors[STATE_OLD, i]
        F[piece, 1, i] = move
        F[piece, 2, i] = h * K[0, i] - move
        F[piece, 3, i] = 2.0 * move - h * (K[0, i] + K[end, i])
    finite = True
    for row in range(4, F.shape[1]):
        finite = _dense_row(method, K, h, F, piece, row) and finite
    return finite
