"""One Runge-Kutta step in every lane: what `native.stages` does for one motion, operation by operation.

The cache of the compiled loop does not see a change of this file: renew `lane_cases.SOURCES` after one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from symbody.simulation.native.interface import (
    Floats,
    Goal,
    Integers,
    Method,
    RightHandSide,
    call,
    inline,
)
from symbody.simulation.native.lanes.arithmetic import (
    WIDTH,
    absolute,
    choose,
    larger,
    minus,
    over,
    plus,
    put,
    spread,
    take,
    times,
)
from symbody.simulation.native.layout import (
    ERROR_1,
    ERROR_2,
    NOTHING,
    STAGE,
    STATE_NEW,
    STATE_OLD,
)
from symbody.simulation.native.stages import error_size, four_states

# Rows of Bundle.trial.
T, H, T_NEW, ERROR_NORM, CALLS, FIRST, SECOND, MASK, ONE, TRIALS = range(10)


class Bundle(NamedTuple):
    """What `Memory` is for one motion, for one in each of W lanes: state i of lane l lies at i W + l.

    Attributes
    ----------
    vectors : (VECTORS, n W) array
        As in `Memory`.
    K : (k, n W) array
        The derivatives of the stages.
    F : (4 + d, n W) array
        The dense output of the last step.
    scratch, derivative, minus_zero : (1, n W) arrays
        A derivative or state that may not be wanted in all lanes, a derivative there; and what changes
        nothing when added.
    atol : (1, n W) array
        As in `Goal`.
    trial : (TRIALS, W) array
        Beginning, length, end and error of the steps just tried, the evaluations they took, numbers on the
        way, which lanes are meant, and ones.
    real : (W, REALS) array
        As in `Memory`.
    counts : (W, COUNTS) array of int
        As in `Memory`.
    cases : (W,) array of int
        Which case a lane computes, -1 for none.
    codes : (W,) array of int
        What `loop.advance` would have returned.
    """

    vectors: Floats
    K: Floats
    F: Floats
    scratch: Floats
    derivative: Floats
    minus_zero: Floats
    atol: Floats
    trial: Floats
    real: Floats
    counts: Integers
    cases: Integers
    codes: Integers


@inline
def _combine(
    method: Method, row: int, K: Floats, trial: Floats, factor: int, base: Floats, source: int, out: Floats,
    target: int,
) -> None:  # fmt: skip
    """Set out[target] to base[source] plus a row of `trial` times a row of the tableau times K."""
    n = K.shape[1]
    share = take(trial, factor * WIDTH)
    for block in range(0, n // WIDTH, 4):
        first, second, third, fourth = four_states(block, n // WIDTH)
        i, j = np.intp(first) * WIDTH, np.intp(second) * WIDTH
        k, m = np.intp(third) * WIDTH, np.intp(fourth) * WIDTH
        a = b = c = d = spread(0.0)
        for entry in range(method.first[row], method.first[row + 1]):
            stage, weight = np.intp(method.columns[entry]) * n, spread(method.weights[entry])
            a = plus(a, times(weight, take(K, stage + i)))
            b = plus(b, times(weight, take(K, stage + j)))
            c = plus(c, times(weight, take(K, stage + k)))
            d = plus(d, times(weight, take(K, stage + m)))
        old, new = source * n, target * n
        put(out, new + i, plus(take(base, old + i), times(share, a)))
        put(out, new + j, plus(take(base, old + j), times(share, b)))
        put(out, new + k, plus(take(base, old + k), times(share, c)))
        put(out, new + m, plus(take(base, old + m), times(share, d)))


@inline
def _copy(array: Floats, first: int, stop: int, source: int, target: int) -> None:
    """Copy part of one row to another; places count doubles."""
    n = array.shape[1]
    for place in range(first, stop, WIDTH):
        put(array, target * n + place, take(array, source * n + place))


@inline
def _evaluate(
    wide: RightHandSide, trial: Floats, c: float, x: Floats, source: int, out: Floats, target: int
) -> int:
    """Write the derivative at x[source] and the share c of each step to out[target]; return its status."""
    start, h = take(trial, T * WIDTH), take(trial, H * WIDTH)
    put(wide.clock, 0, plus(start, times(spread(c), h)))
    n = x.shape[1]
    code: int = call(wide, x, source * n, out, target * n)
    return code


@inline
def _write_errors(method: Method, goal: Goal, bundle: Bundle) -> None:
    """Write the errors of all lanes to the trial, as `stages.error_size` computes them."""
    vectors, K, trial = bundle.vectors, bundle.K, bundle.trial
    row, n = K.shape[0], K.shape[1]
    _combine(method, row, K, trial, ONE, vectors, NOTHING, vectors, ERROR_1)
    _combine(method, row + 1, K, trial, ONE, vectors, NOTHING, vectors, ERROR_2)
    first = second = spread(0.0)
    for place in range(0, n, WIDTH):
        old, new = take(vectors, STATE_OLD * n + place), take(vectors, STATE_NEW * n + place)
        size = times(spread(goal.rtol), larger(absolute(old), absolute(new)))
        share = over(spread(1.0), plus(take(bundle.atol, place), size))
        a = times(take(vectors, ERROR_1 * n + place), share)
        b = times(take(vectors, ERROR_2 * n + place), share)
        first, second = plus(first, times(a, a)), plus(second, times(b, b))
    put(trial, FIRST * WIDTH, first)
    put(trial, SECOND * WIDTH, second)
    for lane in range(WIDTH):
        error = error_size(trial[FIRST, lane], trial[SECOND, lane], trial[H, lane], n // WIDTH)
        trial[ERROR_NORM, lane] = error


@inline
def _write_faults(method: Method, bundle: Bundle) -> None:
    """Make the errors of lanes infinite where they, or tolerated ends, are not finite; count evaluations."""
    K, trial, end = bundle.K, bundle.trial, method.stages
    n = K.shape[1]
    zero = spread(0.0)  # becomes NaN
    for place in range(0, n, WIDTH):
        zero = plus(zero, times(spread(0.0), take(K, end * n + place)))
    put(trial, FIRST * WIDTH, zero)
    for lane in range(WIDTH):
        error = trial[ERROR_NORM, lane]
        trial[CALLS, lane] = end if method.error_reads_end or error <= 1.0 else end - 1
        if np.isnan(error) or (error <= 1.0 and trial[FIRST, lane] != 0.0):
            trial[ERROR_NORM, lane] = np.inf


@inline
def _mark_small_errors(bundle: Bundle) -> bool:
    """Mark the lanes whose error is tolerated; return whether there are any that compute a case."""
    trial, some = bundle.trial, False
    for lane in range(WIDTH):
        is_small = trial[ERROR_NORM, lane] <= 1.0
        trial[MASK, lane] = 1.0 if is_small else 0.0
        some = some or (is_small and bundle.cases[lane] >= 0)
    return some


@inline
def take_marked(bundle: Bundle, array: Floats, row: int, out: Floats, target: int) -> None:
    """Copy array[row] to out[target] in the lanes that are marked."""
    n = array.shape[1]
    mask = take(bundle.trial, MASK * WIDTH)
    for place in range(0, n, WIDTH):
        there = target * n + place
        put(out, there, choose(mask, take(array, row * n + place), take(out, there)))


@inline
def attempt_all(wide: RightHandSide, method: Method, goal: Goal, bundle: Bundle) -> bool:
    """Do what `stages.attempt` does in every lane; return False if the function failed in one.

    What an attempt in the loop for one motion starts from is then as it was.
    """
    vectors, K, trial, end = bundle.vectors, bundle.K, bundle.trial, method.stages
    n = K.shape[1]
    for k in range(1, end):
        _combine(method, k, K, trial, H, vectors, STATE_OLD, vectors, STAGE)
        if method.split:
            _copy(vectors, wide.n_u, n, STATE_OLD, STAGE)
        if _evaluate(wide, trial, method.c[k], vectors, STAGE, K, k) != 0:
            return False
    _combine(method, end, K, trial, H, vectors, STATE_OLD, vectors, STATE_NEW)
    if method.split:
        _copy(vectors, 0, wide.n_u, STAGE, STATE_NEW)
    if method.error_reads_end and _evaluate(wide, trial, 1.0, vectors, STATE_NEW, K, end) != 0:
        return False
    _write_errors(method, goal, bundle)
    if _mark_small_errors(bundle) and not method.error_reads_end:
        if _evaluate(wide, trial, 1.0, vectors, STATE_NEW, bundle.scratch, 0) != 0:
            return False
        take_marked(bundle, bundle.scratch, 0, K, end)
    _write_faults(method, bundle)
    return True


@inline
def form_dense_outputs(wide: RightHandSide, method: Method, bundle: Bundle) -> bool:
    """Do what `stages.form_dense_output` does in the lanes that are marked, the others lose theirs.

    The trial's row FIRST is 0 where all is finite. It returns False if the function failed in a lane.
    """
    vectors, K, F, trial, end = bundle.vectors, bundle.K, bundle.F, bundle.trial, method.stages
    n = K.shape[1]
    for k in range(end + 1, K.shape[0]):
        _combine(method, k, K, trial, H, vectors, STATE_OLD, bundle.scratch, 0)
        take_marked(bundle, bundle.scratch, 0, vectors, ERROR_1)
        if _evaluate(wide, trial, method.c[k], bundle.scratch, 0, K, k) != 0:
            return False
    h, two = take(trial, H * WIDTH), spread(2.0)
    for place in range(0, n, WIDTH):
        old, new = take(vectors, STATE_OLD * n + place), take(vectors, STATE_NEW * n + place)
        first, last = take(K, place), take(K, end * n + place)
        move = minus(new, old)
        put(F, place, old)
        put(F, n + place, move)
        put(F, 2 * n + place, minus(times(h, first), move))
        put(F, 3 * n + place, minus(times(two, move), times(h, plus(first, last))))
    zero = spread(0.0)
    for row in range(4, F.shape[0]):
        _combine(method, K.shape[0] + row - 2, K, trial, H, bundle.minus_zero, 0, F, row)
        for place in range(row * n, row * n + n, WIDTH):
            zero = plus(zero, times(spread(0.0), take(F, place)))
    put(trial, FIRST * WIDTH, zero)
    return True
