"""One step of an explicit Runge-Kutta method: stages, local error, the length of the next step.

Sections are those of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., and from
IV on of Hairer and Wanner, part II.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    ACCEPTED,
    AFTER_REJECTION,
    C_PLACE,
    CLOCK,
    DIRECTION,
    ENTRIES,
    ERROR,
    ERROR_1,
    ERROR_2,
    ERROR_READS_END,
    EVALUATIONS,
    EXPONENT,
    FUNCTION,
    GROWTH,
    KERNEL,
    MAX_STEP,
    MEMORY,
    METHOD,
    METHOD_SIZE,
    N_U,
    NODES,
    NOTHING,
    OTHER_VOTES,
    P_PLACE,
    R_PLACE,
    REJECTED,
    ROWS,
    RTOL,
    SHRINK,
    SPLIT,
    STAGE,
    STAGE_ROWS,
    STAGES,
    STATE_NEW,
    STATE_OLD,
    STEP,
    STIFF_BOUND,
    STIFF_VOTES,
    TABLES_PLACE,
    TIME,
    TOLERANCES,
    UNJUDGED,
    VECTOR_ROWS,
    VECTORS,
    WORK_PLACE,
    N,
)
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part, sqrt
from symbody.kernels.power import power
from symbody.kernels.tables import read_tables

SAFETY: Final = 0.9


def call(f: Function, n_u: int, numbers: Reals, t: float, x: Reals, out: Reals) -> int:
    """Call a function at a time and a state x = (u, q), with its other numbers; return its status."""
    numbers[CLOCK] = t
    if numbers[TABLES_PLACE] != 0.0:
        read_tables(numbers, t)
    r = part(numbers, R_PLACE, 1)
    p = part(numbers, int(numbers[P_PLACE]), 1)
    c = part(numbers, int(numbers[C_PLACE]), 1)
    work = part(numbers, int(numbers[WORK_PLACE]), 1)
    return f(numbers, part(x, n_u, 1), x, r, p, c, out, work)


def evaluate(f: Function, B: Reals, t: float, source: int, target: int) -> None:
    """Set derivative number `target` to that at vector number `source`, and a fault to its counter."""
    n = int(B[N])
    x = part(B, VECTORS + source * n, n)
    slope = part(B, VECTORS + (VECTOR_ROWS + target) * n, n)
    B[EVALUATIONS] = B[EVALUATIONS] + 1.0
    status = call(f, int(B[N_U]), part(B, int(B[FUNCTION]), 1), t, x, slope)
    if status != 0:
        B[KERNEL] = float(status)


def combine(n: int, row: int, M: Reals, K: Reals, factor: float, base: Reals, target: Reals) -> None:
    """Set `target` to `base` plus `factor` times a row of the method times K, four states at a time.

    Their sums stay in registers; the last four may be computed twice, to the same values.
    """
    if n < 4:
        combine_few(n, row, M, K, factor, base, target)
        return
    first = int(M[ROWS + row])
    stop = int(M[ROWS + row + 1])
    place = 0
    while place < n:
        i = min(place, n - 4)
        a = 0.0
        b = 0.0
        c = 0.0
        d = 0.0
        for entry in range(first, stop):
            at = int(M[ENTRIES + 2 * entry]) + i
            weight = M[ENTRIES + 2 * entry + 1]
            a = a + weight * K[at]
            b = b + weight * K[at + 1]
            c = c + weight * K[at + 2]
            d = d + weight * K[at + 3]
        a = base[i] + factor * a
        b = base[i + 1] + factor * b
        c = base[i + 2] + factor * c
        d = base[i + 3] + factor * d
        target[i] = a
        target[i + 1] = b
        target[i + 2] = c
        target[i + 3] = d
        place = place + 4


def combine_few(n: int, row: int, M: Reals, K: Reals, factor: float, base: Reals, target: Reals) -> None:
    """Do what `combine` does for less than four states; at the end one stands for those that lack."""
    if n == 0:
        return
    j = min(1, n - 1)
    k = min(2, n - 1)
    a = 0.0
    b = 0.0
    c = 0.0
    for entry in range(int(M[ROWS + row]), int(M[ROWS + row + 1])):
        at = int(M[ENTRIES + 2 * entry])
        weight = M[ENTRIES + 2 * entry + 1]
        a = a + weight * K[at]
        b = b + weight * K[at + j]
        c = c + weight * K[at + k]
    target[0] = base[0] + factor * a
    target[j] = base[j] + factor * b
    target[k] = base[k] + factor * c


def copy(n: int, source: Reals, target: Reals) -> None:
    """Copy an array."""
    for i in range(n):
        target[i] = source[i]


def all_finite(n: int, x: Reals) -> int:
    """Return 1 if an array holds no infinity and no NaN, else 0."""
    for i in range(n):
        if not is_finite(x[i]):
            return 0
    return 1


def error_scale(B: Reals, n: int, i: int) -> float:
    """Return how large a local error of state i may be."""
    size = max(abs(B[VECTORS + STATE_OLD * n + i]), abs(B[VECTORS + STATE_NEW * n + i]))
    return B[VECTORS + TOLERANCES * n + i] + B[RTOL] * size


def error_size(first: float, second: float, h: float, n: int) -> float:
    """Return the local error from the sums of squares of both estimates: section II.10."""
    if first == 0.0:
        return 0.0
    return abs(h) * first / sqrt((first + 0.01 * second) * n)


def error_norm(B: Reals, h: float) -> float:
    """Return the local error over its tolerance: section II.4."""
    n = int(B[N])
    M = part(B, METHOD, METHOD_SIZE)
    V = part(B, VECTORS, VECTOR_ROWS * n)
    row = int(M[STAGE_ROWS])
    K = part(B, VECTORS + VECTOR_ROWS * n, row * n)
    zeros = part(V, NOTHING * n, n)
    combine(n, row, M, K, 1.0, zeros, part(V, ERROR_1 * n, n))
    combine(n, row + 1, M, K, 1.0, zeros, part(V, ERROR_2 * n, n))
    rtol = B[RTOL]
    first = 0.0
    second = 0.0
    for i in range(n):
        size = max(abs(V[STATE_OLD * n + i]), abs(V[STATE_NEW * n + i]))
        share = 1.0 / (V[TOLERANCES * n + i] + rtol * size)
        a = V[ERROR_1 * n + i] * share
        b = V[ERROR_2 * n + i] * share
        first = first + a * a
        second = second + b * b
    return error_size(first, second, h, n)


def attempt(f: Function, B: Reals, t: float, h: float) -> float:
    """Compute the stages of one step and the new state; return the error norm, infinite if not finite."""
    n = int(B[N])
    n_u = int(B[N_U])
    M = part(B, METHOD, METHOD_SIZE)
    V = part(B, VECTORS, VECTOR_ROWS * n)
    end = int(M[STAGES])
    K = part(B, VECTORS + VECTOR_ROWS * n, (end + 1) * n)
    old = part(V, STATE_OLD * n, n)
    stage = part(V, STAGE * n, n)
    new = part(V, STATE_NEW * n, n)
    B[KERNEL] = 0.0
    for k in range(1, end):
        combine(n, k, M, K, h, old, stage)
        if M[SPLIT] != 0.0:
            copy(n - n_u, part(old, n_u, n - n_u), part(stage, n_u, n - n_u))
        evaluate(f, B, t + M[NODES + k] * h, STAGE, k)
    combine(n, end, M, K, h, old, new)
    if M[SPLIT] != 0.0:
        copy(n_u, stage, new)
    if M[ERROR_READS_END] != 0.0:
        evaluate(f, B, t + h, STATE_NEW, end)
    error = error_norm(B, h)
    if error <= 1.0 and M[ERROR_READS_END] == 0.0:
        evaluate(f, B, t + h, STATE_NEW, end)
    if error != error or B[KERNEL] != 0.0:
        return INFINITY
    if error <= 1.0:
        if all_finite(n, part(K, end * n, n)) == 0:
            return INFINITY
    return error


def accept(B: Reals, t_new: float, h: float, error: float) -> None:
    """Go on to the end of a step and choose the next one: sections II.4 and IV.2."""
    M = part(B, METHOD, METHOD_SIZE)
    factor = M[GROWTH]
    if error > 0.0:
        factor = SAFETY / power(error, M[EXPONENT])
        if M[MEMORY] != 0.0:
            factor = factor * power(B[ERROR], M[MEMORY])
    factor = min(max(factor, M[SHRINK]), M[GROWTH])
    if B[AFTER_REJECTION] != 0.0:
        factor = min(factor, 1.0)
    B[TIME] = t_new
    B[STEP] = B[DIRECTION] * min(abs(h) * factor, B[MAX_STEP])
    if M[GROWTH] == 1.0:  # steps of one length, whatever a jump took from this one
        B[STEP] = B[DIRECTION] * B[MAX_STEP]
    B[ERROR] = max(error, 1e-4)
    B[ACCEPTED] = B[ACCEPTED] + 1.0
    B[AFTER_REJECTION] = 0.0


def reject(B: Reals, h: float, error: float) -> None:
    """Choose a shorter step."""
    M = part(B, METHOD, METHOD_SIZE)
    factor = M[SHRINK]
    if is_finite(error):
        factor = max(factor, SAFETY / power(error, M[EXPONENT]))
    B[STEP] = h * factor
    B[REJECTED] = B[REJECTED] + 1.0
    B[AFTER_REJECTION] = 1.0


def count_stiff_votes(B: Reals, h: float) -> int:
    """Count steps at the stability bound as section IV.2 does; return 1 if there are too many, else 0."""
    B[UNJUDGED] = B[UNJUDGED] + 1.0
    if B[UNJUDGED] == 1000.0:
        B[UNJUDGED] = 0.0
    elif B[STIFF_VOTES] == 0.0:
        return 0
    n = int(B[N])
    V = part(B, VECTORS, VECTOR_ROWS * n)
    stages = int(B[METHOD + STAGES])
    K = part(B, VECTORS + VECTOR_ROWS * n, (stages + 1) * n)
    slope = 0.0
    distance = 0.0
    for i in range(n):
        a = K[stages * n + i] - K[(stages - 1) * n + i]
        b = V[STATE_NEW * n + i] - V[STAGE * n + i]
        slope = slope + a * a
        distance = distance + b * b
    bound = B[METHOD + STIFF_BOUND] * B[METHOD + STIFF_BOUND]
    if h * h * slope > bound * distance and distance > 0.0:
        B[OTHER_VOTES] = 0.0
        B[STIFF_VOTES] = B[STIFF_VOTES] + 1.0
    else:
        B[OTHER_VOTES] = B[OTHER_VOTES] + 1.0
        if B[OTHER_VOTES] == 6.0:
            B[STIFF_VOTES] = 0.0
            B[OTHER_VOTES] = 0.0
    if B[STIFF_VOTES] >= 15.0:
        return 1
    return 0
