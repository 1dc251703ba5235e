"""The integrator by the generalized-alpha method: steps of one motion, as `step_machine` takes explicit ones.

The functions are f, slopes of all states; k, rates of coordinates; d, derivatives of the slopes by the
states; g, which closes the constraints. `A` is the array of `implicit_block`, the other arrays are those of
`step_machine`.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import (
    ACCEPTED,
    AFTER_REJECTION,
    DIRECTION,
    EXPONENT,
    GROWTH,
    KERNEL,
    LENGTH,
    MAX_STEP,
    METHOD,
    PROJECTOR,
    REJECTED,
    RUNNING,
    SHRINK,
    STAGE,
    STATE_NEW,
    STATE_OLD,
    STEP,
    T_NEW,
    TIME,
    VECTOR_ROWS,
    VECTORS,
    N,
)
from symbody.kernels.configurations.projection import project_new_state
from symbody.kernels.implicit.generalized_alpha import finish_step, renew_turn, solve_step
from symbody.kernels.implicit.implicit_block import (
    CONTRACTION,
    FACTORED_FOR,
    HAS_DERIVATIVES,
    LENGTH_BEFORE,
    ONE_LENGTH,
    RATES,
    RATES_NEW,
    SLOPES_BEFORE,
    SLOPES_CHANGE,
    UNKNOWNS,
)
from symbody.kernels.implicit.implicit_errors import local_error
from symbody.kernels.language import INFINITY, Function, Reals, is_finite, part
from symbody.kernels.power import power
from symbody.kernels.runge_kutta import all_finite, copy, evaluate
from symbody.kernels.step_bounds import behind_jump, plan_trial
from symbody.kernels.step_machine import begin, failure, keep_step, reached_limit

# The share of the first step over which the change of the slopes is measured.
PROBE: Final = 1e-3
SAFETY: Final = 0.8
# Within these bounds the next step is as long as the last, and the factors stay.
NEARLY: Final = 0.9
WORTHWHILE: Final = 1.2
# Where Newton's method fails.
QUARTER: Final = 0.25


def set_out(f: Function, B: Reals, A: Reals) -> None:
    """Forget the steps before, and measure how the slopes change at the state from which motion starts."""
    n = int(B[N])
    V = part(B, VECTORS, VECTOR_ROWS * n)
    K = part(B, VECTORS + VECTOR_ROWS * n, 2 * n)
    change = part(A, int(A[SLOPES_CHANGE]), n)
    h = PROBE * B[STEP]
    A[LENGTH_BEFORE] = 0.0
    A[HAS_DERIVATIVES] = 0.0
    A[FACTORED_FOR] = 0.0
    A[CONTRACTION] = 1.0
    for i in range(n):
        change[i] = 0.0
        V[STAGE * n + i] = V[STATE_OLD * n + i] + h * K[i]
    if h == 0.0:
        return
    evaluate(f, B, B[TIME] + h, STAGE, 1)
    if B[KERNEL] == 0.0 and all_finite(n, part(K, n, n)) == 1:
        for i in range(n):
            change[i] = (K[n + i] - K[i]) / h
    B[KERNEL] = 0.0


def begin_implicit(f: Function, B: Reals, A: Reals, times: Reals, t: Reals, x: Reals, breaks: Reals) -> int:
    """Begin as `step_machine.begin` does."""
    code = begin(f, B, times, t, x, breaks)
    if code == RUNNING:
        set_out(f, B, A)
    return code


def attempt_implicit(
    f: Function, k: Function, d: Function, g: Function, B: Reals, A: Reals, h: float
) -> float:
    """Try one step; return its error over the tolerance: infinite, or -1 where Newton's method fails."""
    if solve_step(f, k, d, B, A, h) == 0:
        return -1.0
    if finish_step(k, B, A, h) == 0:
        return -1.0
    error = 0.0
    if A[ONE_LENGTH] == 0.0:
        error = local_error(B, A, h)
    if error <= 1.0 and B[PROJECTOR] != 0.0:
        moved = project_new_state(g, B, B[T_NEW])
        if moved < 0.0 or not is_finite(moved):
            return INFINITY
        if moved > 0.0:
            if renew_turn(k, B, A, h) == 0:
                return INFINITY
    return error


def shorten_step(B: Reals, factor: float) -> None:
    """Go on with a shorter step, after one in vain."""
    B[REJECTED] = B[REJECTED] + 1.0
    B[AFTER_REJECTION] = 1.0
    B[STEP] = B[LENGTH] * factor


def step_factor(B: Reals, error: float) -> float:
    """Return by how much the next step may be longer after an error."""
    factor = B[METHOD + GROWTH]
    if error > 0.0 and is_finite(error):
        factor = SAFETY / power(error, B[METHOD + EXPONENT])
    if not is_finite(error):
        factor = B[METHOD + SHRINK]
    return min(max(factor, B[METHOD + SHRINK]), B[METHOD + GROWTH])


def choose_step(B: Reals, A: Reals, error: float) -> None:
    """Choose the length of the next step after one that was accepted."""
    if A[ONE_LENGTH] != 0.0:
        B[STEP] = B[DIRECTION] * B[MAX_STEP]
        return
    factor = step_factor(B, error)
    if B[AFTER_REJECTION] != 0.0:
        factor = min(factor, 1.0)
    if factor > NEARLY and factor < WORTHWHILE:
        factor = 1.0
    h = B[LENGTH]
    if factor >= 1.0 and abs(h) < abs(B[STEP]):
        h = B[STEP]  # what lay ahead, not its error, made the step short
        factor = 1.0
    B[STEP] = B[DIRECTION] * min(abs(h) * factor, B[MAX_STEP])
    B[AFTER_REJECTION] = 0.0


def accept_implicit(f: Function, B: Reals, A: Reals, error: float) -> None:
    """Go on to the end of a step, behind a jump that lies there."""
    n = int(B[N])
    n_v = int(A[UNKNOWNS])
    first = VECTORS + VECTOR_ROWS * n
    copy(n, part(B, first, n), part(A, int(A[SLOPES_BEFORE]), n))
    copy(n, part(B, first + n, n), part(B, first, n))
    copy(n, part(B, VECTORS + STATE_NEW * n, n), part(B, VECTORS + STATE_OLD * n, n))
    copy(n_v, part(A, int(A[RATES_NEW]), n_v), part(A, int(A[RATES]), n_v))
    A[LENGTH_BEFORE] = B[LENGTH]
    B[ACCEPTED] = B[ACCEPTED] + 1.0
    B[TIME] = B[T_NEW]
    choose_step(B, A, error)
    t = behind_jump(B, B[TIME])
    if t != B[TIME]:
        B[TIME] = t
        evaluate(f, B, t, STATE_OLD, 0)
        set_out(f, B, A)


def try_implicit(
    f: Function, k: Function, d: Function, g: Function, B: Reals, A: Reals, times: Reals, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Try one step; return why there is no other, or `RUNNING`."""
    plan_trial(B, B[TIME], B[STEP])
    h = B[LENGTH]
    if h == 0.0:
        return failure(B)
    error = attempt_implicit(f, k, d, g, B, A, h)
    if error >= 0.0 and error <= 1.0:
        error = keep_step(f, g, B, error, times, t, x, breaks, pieces)
    if error >= 0.0 and error <= 1.0:
        accept_implicit(f, B, A, error)
        return RUNNING
    if A[ONE_LENGTH] != 0.0:
        return failure(B)
    factor = QUARTER
    if error >= 0.0:
        factor = min(step_factor(B, error), SAFETY)
    shorten_step(B, factor)
    return RUNNING


def advance_implicit(
    f: Function, k: Function, d: Function, g: Function, B: Reals, A: Reals, times: Reals, t: Reals, x: Reals,
    breaks: Reals, pieces: Reals, trials: int,
) -> int:  # fmt: skip
    """Try up to so many steps; return one of the codes of `block`, as `step_machine.advance` does."""
    for _trial in range(trials):
        code = reached_limit(B)
        if code == RUNNING:
            code = try_implicit(f, k, d, g, B, A, times, t, x, breaks, pieces)
        if code != RUNNING:
            return code
    return RUNNING
