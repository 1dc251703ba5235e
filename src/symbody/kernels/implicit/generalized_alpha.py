"""One step of the generalized-alpha method: Newton's method on the rates.

Chung and Hulbert 1993; Arnold and Bruls 2007; Bruls and Cardona 2010; every formula is derived in
``docs/derivations/generalized_alpha.md``. `f` computes the slopes of all states, `k` the rates of
coordinates, `d` the derivatives of the slopes by the states; `B` is the block of the motion, `A` the array
of `implicit_block`.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import KERNEL, N_U, STATE_NEW, STATE_OLD, TIME, VECTOR_ROWS, VECTORS, N
from symbody.kernels.implicit.implicit_block import (
    ALPHA_F,
    ALPHA_M,
    BETA,
    CONTRACTION,
    COORDINATES,
    CORRECTION,
    DERIVATIVES,
    FACTORED_FOR,
    FACTORS,
    GAMMA,
    HAS_DERIVATIVES,
    LAG,
    LENGTH_BEFORE,
    MIDDLE,
    PIVOTS,
    RATE_FUNCTION,
    RATES,
    RATES_NEW,
    RATES_USED,
    ROUNDS,
    SLOPES_CHANGE,
    SLOPES_USED,
    TURN,
    UNKNOWNS,
)
from symbody.kernels.implicit.newton_matrix import make_derivatives, make_factors, place_of
from symbody.kernels.language import Function, Reals, is_finite, part, sqrt
from symbody.kernels.linear.dense_factors import solve_dense
from symbody.kernels.runge_kutta import all_finite, call, copy, error_scale, evaluate

# Newton's method leaves so much of the tolerated error. Its rounds with derivatives of another step, and with
# fresh ones; after more than the last derivatives are renewed for the next step.
LEFT: Final = 0.05
PATIENCE: Final = 5
MOST_ROUNDS: Final = 12
QUICK: Final = 3
# Corrections are trusted to shrink by no more than this from one round to the next.
FASTEST: Final = 1e-3
# The middle of a step is found to this share of rounding or in so many rounds.
MIDDLE_ROUNDS: Final = 12
ROUNDING: Final = 2.3e-16


def scale_rates(B: Reals, A: Reals, h: float) -> None:
    """Set the algorithmic rates at the old state to what belongs to a step of length h.

    They are those of an earlier instant, by a share of the step: what lies between is scaled with it.
    """
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    K = part(B, VECTORS + VECTOR_ROWS * n, n)
    rates = part(A, int(A[RATES]), n_v)
    used = part(A, int(A[RATES_USED]), n_v)
    slopes = part(A, int(A[SLOPES_USED]), n_v)
    for i in range(n_v):
        slopes[i] = K[place_of(i, n_u, n_q)]
    if A[LENGTH_BEFORE] == 0.0:
        start_rates(B, A, h)
        return
    share = h / A[LENGTH_BEFORE]
    for i in range(n_v):
        used[i] = slopes[i]
        if A[LAG] != 0.0:
            used[i] = slopes[i] + share * (rates[i] - slopes[i])


def start_rates(B: Reals, A: Reals, h: float) -> None:
    """Set algorithmic rates and slopes at a start, without what changes too fast for steps of length h."""
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    S = part(A, int(A[FACTORS]), n_v * n_v)
    pivots = part(A, int(A[PIVOTS]), n_v)
    change = part(A, int(A[SLOPES_CHANGE]), int(B[N]))
    used = part(A, int(A[RATES_USED]), n_v)
    slopes = part(A, int(A[SLOPES_USED]), n_v)
    scratch = part(A, int(A[CORRECTION]), n_v)
    for i in range(n_v):
        used[i] = change[place_of(i, n_u, n_q)]
    solve_dense(n_v, S, pivots, used)
    for i in range(n_v):
        used[i] = slopes[i] + A[LAG] * h * used[i]
    smooth(n_v, S, pivots, used, scratch)
    smooth(n_v, S, pivots, slopes, scratch)


def smooth(n: int, S: Reals, pivots: Reals, y: Reals, scratch: Reals) -> None:
    """Apply 2/S - 1/S^2 to y, by the factors of S: what is slow stays to second order, what is fast goes."""
    solve_dense(n, S, pivots, y)
    copy(n, y, scratch)
    solve_dense(n, S, pivots, scratch)
    for i in range(n):
        y[i] = 2.0 * y[i] - scratch[i]


def turn(k: Function, B: Reals, A: Reals, t: float, x: Reals) -> int:
    """Set `TURN` to the rates of coordinates at a state; return 0 if all went well."""
    return call(k, int(B[N_U]), part(A, int(A[RATE_FUNCTION]), 1), t, x, part(A, int(A[TURN]), 1))


def place_state(k: Function, B: Reals, A: Reals, h: float) -> int:
    """Set the new state to where the new algorithmic rates lead; return 0 if that is impossible, else 1.

    Coordinates move with the mean speeds by the midpoint rule, which turns quaternions by a rotation.
    """
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    old = part(B, VECTORS + STATE_OLD * n, n)
    new = part(B, VECTORS + STATE_NEW * n, n)
    middle = part(A, int(A[MIDDLE]), n)
    rates = part(A, int(A[TURN]), n_q)
    used = part(A, int(A[RATES_USED]), n_v)
    after = part(A, int(A[RATES_NEW]), n_v)
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        new[place] = old[place] + h * ((1.0 - A[GAMMA]) * used[i] + A[GAMMA] * after[i])
        middle[place] = 0.5 * (old[place] + new[place])
        if i < n_u:
            middle[place] = old[place] + h * ((0.5 - A[BETA]) * used[i] + A[BETA] * after[i])
    for i in range(n_u, n_u + n_q):
        middle[i] = 0.5 * (old[i] + new[i])
    for _round in range(MIDDLE_ROUNDS):
        if turn(k, B, A, B[TIME] + 0.5 * h, middle) != 0:
            return 0
        moved = 0
        for i in range(n_q):
            step = h * rates[i]
            new[n_u + i] = old[n_u + i] + step
            halfway = old[n_u + i] + 0.5 * step
            if abs(halfway - middle[n_u + i]) > ROUNDING * (abs(halfway) + abs(step)):
                moved = 1
            middle[n_u + i] = halfway
        if moved == 0:
            break
    return 1


def correct(B: Reals, A: Reals, h: float) -> float:
    """Take one round of Newton's method; return how far it moves the state over the tolerated error."""
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    size = n_v + n_q
    K = part(B, VECTORS + VECTOR_ROWS * n, 2 * n)
    used = part(A, int(A[RATES_USED]), n_v)
    after = part(A, int(A[RATES_NEW]), n_v)
    slopes = part(A, int(A[SLOPES_USED]), n_v)
    y = part(A, int(A[CORRECTION]), n_v)
    D = part(A, int(A[DERIVATIVES]), size * size)
    share = 1.0 / (1.0 - A[ALPHA_M])
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        mean = (1.0 - A[ALPHA_F]) * K[n + place] + A[ALPHA_F] * slopes[i]
        y[i] = share * (mean - A[ALPHA_M] * used[i]) - after[i]
    solve_dense(n_v, part(A, int(A[FACTORS]), n_v * n_v), part(A, int(A[PIVOTS]), n_v), y)
    total = 0.0
    for i in range(n_v):
        after[i] = after[i] + y[i]
        move = h * A[GAMMA] * y[i] / error_scale(B, n, place_of(i, n_u, n_q))
        total = total + move * move
    for i in range(n_u, n_u + n_q):
        move = 0.0
        for j in range(n_u):
            move = move + D[i * size + j] * y[j]
        move = h * h * A[BETA] * move / error_scale(B, n, i)
        total = total + move * move
    A[ROUNDS] = A[ROUNDS] + 1.0
    return sqrt(total / max(size, 1))


def iterate(f: Function, k: Function, B: Reals, A: Reals, h: float, most: int) -> int:
    """Solve for the new state by Newton's method; return how many rounds that took, 0 if it failed."""
    n_v = int(A[UNKNOWNS])
    copy(n_v, part(A, int(A[RATES_USED]), n_v), part(A, int(A[RATES_NEW]), n_v))
    before = 0.0
    for number in range(most):
        if place_state(k, B, A, h) == 0:
            return 0
        evaluate(f, B, B[TIME] + h, STATE_NEW, 1)
        if B[KERNEL] != 0.0:
            return 0
        moved = correct(B, A, h)
        if not is_finite(moved):
            return 0
        if number > 0 and before > 0.0:
            ratio = moved / before
            if ratio > 0.9 and moved > LEFT:
                return 0
            A[CONTRACTION] = max(max(0.3 * A[CONTRACTION], FASTEST), ratio)
        if moved * min(A[CONTRACTION], 1.0) <= LEFT:
            return number + 1
        before = moved
    return 0


def solve_step(f: Function, k: Function, d: Function, B: Reals, A: Reals, h: float) -> int:
    """Find the new state with the derivatives at hand, or with fresh ones; return 0 if that fails, else 1."""
    n = int(B[N])
    for trial in range(2):
        is_fresh = 0
        if A[HAS_DERIVATIVES] == 0.0:
            is_fresh = 1
            if make_derivatives(d, B, A, B[TIME], part(B, VECTORS + STATE_OLD * n, n)) == 0:
                return 0
        if A[FACTORED_FOR] != h:
            if make_factors(B, A, h) == 0:
                A[HAS_DERIVATIVES] = 0.0
                A[FACTORED_FOR] = 0.0
                return 0
        scale_rates(B, A, h)
        B[KERNEL] = 0.0
        most = PATIENCE
        if is_fresh == 1 or trial == 1:
            most = MOST_ROUNDS
        rounds = iterate(f, k, B, A, h, most)
        if rounds > 0:
            if rounds > QUICK:
                A[HAS_DERIVATIVES] = 0.0
            return 1
        A[HAS_DERIVATIVES] = 0.0
        if is_fresh == 1:
            return 0
    return 0


def finish_step(k: Function, B: Reals, A: Reals, h: float) -> int:
    """Set new state and slopes from the new rates; return 0 if they are not finite, else 1.

    The slopes of v are those of the method's own equation: they carry no rounding of fast forces.
    """
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    n_v = int(A[UNKNOWNS])
    if place_state(k, B, A, h) == 0:
        return 0
    K = part(B, VECTORS + VECTOR_ROWS * n, 2 * n)
    used = part(A, int(A[RATES_USED]), n_v)
    after = part(A, int(A[RATES_NEW]), n_v)
    slopes = part(A, int(A[SLOPES_USED]), n_v)
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        mean = (1.0 - A[ALPHA_M]) * after[i] + A[ALPHA_M] * used[i]
        K[n + place] = (mean - A[ALPHA_F] * slopes[i]) / (1.0 - A[ALPHA_F])
    for i in range(n_v + n_q, n):
        old = B[VECTORS + STATE_OLD * n + i]
        B[VECTORS + STATE_NEW * n + i] = old + 0.5 * h * (K[i] + K[n + i])
    if renew_turn(k, B, A, h) == 0:
        return 0
    return all_finite(n, part(K, n, n))


def renew_turn(k: Function, B: Reals, A: Reals, h: float) -> int:
    """Set the slopes of coordinates at the new state; return 0 if that is impossible, else 1."""
    n = int(B[N])
    n_u = int(B[N_U])
    n_q = int(A[COORDINATES])
    if turn(k, B, A, B[TIME] + h, part(B, VECTORS + STATE_NEW * n, n)) != 0:
        return 0
    copy(n_q, part(A, int(A[TURN]), n_q), part(B, VECTORS + (VECTOR_ROWS + 1) * n + n_u, n_q))
    return 1
