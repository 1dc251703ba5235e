"""One Runge-Kutta step as part of the compiled loop: stages, local error, dense output.

The cache of the compiled loop does not see a change of this file: touch `native_loop.py` after one. Sections
are those of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed.
"""

from __future__ import annotations

import numpy as np

from symbody.simulation.native_interface import Floats, Goal, Memory, Method, RightHandSide, call, inlined
from symbody.simulation.native_places import (
    ERROR_1,
    ERROR_2,
    EVALUATIONS,
    KERNEL,
    STAGE,
    STATE_NEW,
    STATE_OLD,
)


@inlined
def evaluate(rhs: RightHandSide, memory: Memory, t: float, source: int, target: int) -> None:
    """Write the derivative at vectors[source] to K[target], and a fault of the function to its counter."""
    rhs.clock[0] = t
    memory.counts[EVALUATIONS] += 1
    n = memory.K.shape[1]
    code = call(rhs, memory.vectors, source * n, memory.K, target * n)
    if code != 0:
        memory.counts[KERNEL] = code


@inlined
def _combine(weights: Floats, row: int, terms: int, K: Floats, out: Floats, target: int) -> None:
    """Set out[target] to the sum of weights[row, j] K[j] over j < terms."""
    n = K.shape[1]
    for i in range(n):
        out[target, i] = 0.0
    for j in range(terms):
        weight = weights[row, j]
        if weight != 0.0:
            for i in range(n):
                out[target, i] += weight * K[j, i]


@inlined
def _stage(
    rhs: RightHandSide, method: Method, memory: Memory, t: float, h: float, k: int, target: int
) -> None:
    """Set vectors[target] to the state of stage k."""
    vectors = memory.vectors
    _combine(method.A, k, k, memory.K, vectors, target)
    for i in range(vectors.shape[1]):
        vectors[target, i] = vectors[STATE_OLD, i] + h * vectors[target, i]


@inlined
def row_is_finite(array: Floats, row: int) -> bool:
    """Return whether a row holds no infinity and no NaN."""
    for i in range(array.shape[1]):
        if not np.isfinite(array[row, i]):
            return False
    return True


@inlined
def scale(goal: Goal, memory: Memory, i: int) -> float:
    """Return how large a local error of state i may be."""
    vectors = memory.vectors
    scale: float = goal.atol[i] + goal.rtol * max(abs(vectors[STATE_OLD, i]), abs(vectors[STATE_NEW, i]))
    return scale


@inlined
def _error_norm(method: Method, goal: Goal, memory: Memory, h: float) -> float:
    """Return the local error over its tolerance: sections II.4 and II.10."""
    vectors = memory.vectors
    terms = method.stages + 1 if method.error_reads_end else method.stages
    _combine(method.error, 0, terms, memory.K, vectors, ERROR_1)
    _combine(method.error, 1, terms, memory.K, vectors, ERROR_2)
    first = 0.0
    second = 0.0
    n = vectors.shape[1]
    for i in range(n):
        tolerated = scale(goal, memory, i)
        first += (vectors[ERROR_1, i] / tolerated) ** 2
        second += (vectors[ERROR_2, i] / tolerated) ** 2
    if first == 0.0:
        return 0.0
    error: float = abs(h) * first / np.sqrt((first + 0.01 * second) * n)
    return error


@inlined
def attempt(rhs: RightHandSide, method: Method, goal: Goal, memory: Memory, t: float, h: float) -> float:
    """Compute the stages of one step and the new state; return the error norm, infinite if not finite."""
    memory.counts[KERNEL] = 0
    end = method.stages
    for k in range(1, end):
        _stage(rhs, method, memory, t, h, k, STAGE)
        evaluate(rhs, memory, t + method.c[k] * h, STAGE, k)
    _stage(rhs, method, memory, t, h, end, STATE_NEW)
    if method.error_reads_end:
        evaluate(rhs, memory, t + h, STATE_NEW, end)
    error = _error_norm(method, goal, memory, h)
    if error <= 1.0 and not method.error_reads_end:
        evaluate(rhs, memory, t + h, STATE_NEW, end)
    if np.isnan(error) or memory.counts[KERNEL] != 0:
        return np.inf
    return error if error > 1.0 or row_is_finite(memory.K, end) else np.inf


@inlined
def form_dense_output(rhs: RightHandSide, method: Method, memory: Memory, t: float, h: float) -> bool:
    """Fill F for the step just tried; return whether all of it is finite."""
    vectors, K, F = memory.vectors, memory.K, memory.F
    end = method.stages
    for k in range(end + 1, K.shape[0]):
        _stage(rhs, method, memory, t, h, k, ERROR_1)  # STAGE is still needed to judge stiffness
        evaluate(rhs, memory, t + method.c[k] * h, ERROR_1, k)
    for i in range(K.shape[1]):
        move = vectors[STATE_NEW, i] - vectors[STATE_OLD, i]
        F[0, i] = vectors[STATE_OLD, i]
        F[1, i] = move
        F[2, i] = h * K[0, i] - move
        F[3, i] = 2.0 * move - h * (K[0, i] + K[end, i])
    finite = True
    for row in range(4, F.shape[0]):
        _combine(method.dense, row - 4, K.shape[0], K, F, row)
        for i in range(F.shape[1]):
            F[row, i] *= h
        finite = finite and row_is_finite(F, row)
    return finite
