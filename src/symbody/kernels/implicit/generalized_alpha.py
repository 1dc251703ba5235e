"""One step of the generalized-alpha method: Newton's method on the rates.

Chung and Hulbert 1993; Arnold and Bruls 2007; Bruls and Cardona 2010; every formula is derived in
``docs/derivations/generalized_alpha.md``. `f` computes the slopes of all states, `k` the rates of
coordinates, `d` the derivatives of the slopes by the states; `run` is the motion, `implicit` what the method
keeps.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import Run
from symbody.kernels.implicit.implicit_block import ImplicitStep
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


def scale_rates(run: Run, implicit: ImplicitStep, h: float) -> None:
    """Set the algorithmic rates at the old state to what belongs to a step of length h.

    They are those of an earlier instant, by a share of the step: what lies between is scaled with it.
    """
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    K = run.slopes
    rates = implicit.rates
    used = implicit.rates_used
    slopes = implicit.slopes_used
    for i in range(n_v):
        slopes[i] = K[place_of(i, n_u, n_q)]
    if implicit.length_before == 0.0:
        start_rates(run, implicit, h)
        return
    share = h / implicit.length_before
    for i in range(n_v):
        used[i] = slopes[i]
        if implicit.lag != 0.0:
            used[i] = slopes[i] + share * (rates[i] - slopes[i])


def start_rates(run: Run, implicit: ImplicitStep, h: float) -> None:
    """Set algorithmic rates and slopes at a start, without what changes too fast for steps of length h."""
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    S = implicit.factors
    pivots = implicit.pivots
    change = implicit.slopes_change
    used = implicit.rates_used
    slopes = implicit.slopes_used
    scratch = implicit.correction
    for i in range(n_v):
        used[i] = change[place_of(i, n_u, n_q)]
    solve_dense(n_v, S, pivots, used)
    for i in range(n_v):
        used[i] = slopes[i] + implicit.lag * h * used[i]
    smooth(n_v, S, pivots, used, scratch)
    smooth(n_v, S, pivots, slopes, scratch)


def smooth(n: int, S: Reals, pivots: Reals, y: Reals, scratch: Reals) -> None:
    """Apply 2/S - 1/S^2 to y, by the factors of S: what is slow stays to second order, what is fast goes."""
    solve_dense(n, S, pivots, y)
    copy(n, y, scratch)
    solve_dense(n, S, pivots, scratch)
    for i in range(n):
        y[i] = 2.0 * y[i] - scratch[i]


def turn(k: Function, run: Run, implicit: ImplicitStep, t: float, x: Reals) -> int:
    """Set `turn` to the rates of coordinates at a state; return 0 if all went well."""
    return call(k, run.speeds, implicit.rate_numbers, t, x, implicit.turn)


def place_state(k: Function, run: Run, implicit: ImplicitStep, h: float) -> int:
    """Set the new state to where the new algorithmic rates lead; return 0 if that is impossible, else 1.

    Coordinates move with the mean speeds by the midpoint rule, which turns quaternions by a rotation.
    """
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    old = run.state_old
    new = run.state_new
    middle = implicit.middle
    rates = implicit.turn
    used = implicit.rates_used
    after = implicit.rates_new
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        new[place] = old[place] + h * ((1.0 - implicit.gamma) * used[i] + implicit.gamma * after[i])
        middle[place] = 0.5 * (old[place] + new[place])
        if i < n_u:
            middle[place] = old[place] + h * ((0.5 - implicit.beta) * used[i] + implicit.beta * after[i])
    for i in range(n_u, n_u + n_q):
        middle[i] = 0.5 * (old[i] + new[i])
    for _round in range(MIDDLE_ROUNDS):
        if turn(k, run, implicit, run.time + 0.5 * h, middle) != 0:
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


def correct(run: Run, implicit: ImplicitStep, h: float) -> float:
    """Take one round of Newton's method; return how far it moves the state over the tolerated error."""
    n = run.states
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    size = n_v + n_q
    K = run.slopes
    used = implicit.rates_used
    after = implicit.rates_new
    slopes = implicit.slopes_used
    y = implicit.correction
    D = implicit.derivatives
    share = 1.0 / (1.0 - implicit.alpha_m)
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        mean = (1.0 - implicit.alpha_f) * K[n + place] + implicit.alpha_f * slopes[i]
        y[i] = share * (mean - implicit.alpha_m * used[i]) - after[i]
    solve_dense(n_v, implicit.factors, implicit.pivots, y)
    total = 0.0
    for i in range(n_v):
        after[i] = after[i] + y[i]
        move = h * implicit.gamma * y[i] / error_scale(run, n, place_of(i, n_u, n_q))
        total = total + move * move
    for i in range(n_u, n_u + n_q):
        move = 0.0
        for j in range(n_u):
            move = move + D[i * size + j] * y[j]
        move = h * h * implicit.beta * move / error_scale(run, n, i)
        total = total + move * move
    implicit.rounds = implicit.rounds + 1.0
    return sqrt(total / max(size, 1))


def iterate(f: Function, k: Function, run: Run, implicit: ImplicitStep, h: float, most: int) -> int:
    """Solve for the new state by Newton's method; return how many rounds that took, 0 if it failed."""
    n_v = implicit.unknowns
    copy(n_v, implicit.rates_used, implicit.rates_new)
    before = 0.0
    for number in range(most):
        if place_state(k, run, implicit, h) == 0:
            return 0
        evaluate(f, run, run.time + h, run.state_new, part(run.slopes, run.states, run.states))
        if run.counts.failed_kernel != 0:
            return 0
        moved = correct(run, implicit, h)
        if not is_finite(moved):
            return 0
        if number > 0 and before > 0.0:
            ratio = moved / before
            if ratio > 0.9 and moved > LEFT:
                return 0
            implicit.contraction = max(max(0.3 * implicit.contraction, FASTEST), ratio)
        if moved * min(implicit.contraction, 1.0) <= LEFT:
            return number + 1
        before = moved
    return 0


def solve_step(f: Function, k: Function, d: Function, run: Run, implicit: ImplicitStep, h: float) -> int:
    """Find the new state with the derivatives at hand, or with fresh ones; return 0 if that fails, else 1."""
    for trial in range(2):
        is_fresh = 0
        if implicit.has_derivatives == 0.0:
            is_fresh = 1
            if make_derivatives(d, run, implicit, run.time, run.state_old) == 0:
                return 0
        if implicit.factored_for != h:
            if make_factors(run, implicit, h) == 0:
                implicit.has_derivatives = 0.0
                implicit.factored_for = 0.0
                return 0
        scale_rates(run, implicit, h)
        run.counts.failed_kernel = 0
        most = PATIENCE
        if is_fresh == 1 or trial == 1:
            most = MOST_ROUNDS
        rounds = iterate(f, k, run, implicit, h, most)
        if rounds > 0:
            if rounds > QUICK:
                implicit.has_derivatives = 0.0
            return 1
        implicit.has_derivatives = 0.0
        if is_fresh == 1:
            return 0
    return 0


def finish_step(k: Function, run: Run, implicit: ImplicitStep, h: float) -> int:
    """Set new state and slopes from the new rates; return 0 if they are not finite, else 1.

    The slopes of v are those of the method's implicit equation: they carry no rounding of fast forces.
    """
    n = run.states
    n_u = run.speeds
    n_q = implicit.coordinates
    n_v = implicit.unknowns
    if place_state(k, run, implicit, h) == 0:
        return 0
    K = run.slopes
    used = implicit.rates_used
    after = implicit.rates_new
    slopes = implicit.slopes_used
    for i in range(n_v):
        place = place_of(i, n_u, n_q)
        mean = (1.0 - implicit.alpha_m) * after[i] + implicit.alpha_m * used[i]
        K[n + place] = (mean - implicit.alpha_f * slopes[i]) / (1.0 - implicit.alpha_f)
    for i in range(n_v + n_q, n):
        old = run.state_old[i]
        run.state_new[i] = old + 0.5 * h * (K[i] + K[n + i])
    if renew_turn(k, run, implicit, h) == 0:
        return 0
    return all_finite(n, part(K, n, n))


def renew_turn(k: Function, run: Run, implicit: ImplicitStep, h: float) -> int:
    """Set the slopes of coordinates at the new state; return 0 if that is impossible, else 1."""
    n = run.states
    n_u = run.speeds
    n_q = implicit.coordinates
    if turn(k, run, implicit, run.time + h, run.state_new) != 0:
        return 0
    copy(n_q, implicit.turn, part(run.slopes, n + n_u, n_q))
    return 1
