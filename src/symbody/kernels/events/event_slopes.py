"""How fast values of events change by the equations of motion, whatever the polynomial of a step says.

An implicit method knows places and speeds to its tolerance each, so that between its samples a place may fall
while its speed rises. At a start the rates decide: those that the function of actions writes behind its
values, or the first rows of the step's polynomial where no event acts.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import TOUCHING, compute_values, sign
from symbody.kernels.events.watch_block import (
    ACTED,
    ACTION_VALUES,
    ACTIONS,
    BLUR,
    CURRENT,
    DIRECTION,
    EVENT_SIZE,
    EVENTS,
    FAULT,
    HERE,
    PIECE_ROWS,
    RATE,
    RESOLUTION,
    SCRATCH,
    SPEEDS,
    STATES,
    TABLE,
    VALUES,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import call, copy
from symbody.kernels.step_bounds import EPSILON

ROUNDED: Final = 1e-4  # of a change by `TOUCHING`: what polynomials make of roundings
VISIBLE: Final = 10.0  # so many roundings are a change
SHORTEST: Final = 1e-6  # of a step
LONGER: Final = 16.0


def disturb_values(e: Function, W: Reals, t: float, state: Reals) -> None:
    """Note the values at a state, and how much each changes where time or one state does by `TOUCHING`.

    A value that is the difference of larger ones is not known better; one of a small state alone is.
    """
    n = int(W[STATES])
    m = int(W[EVENTS])
    table = part(W, int(W[TABLE]), EVENT_SIZE * m)
    values = part(W, int(W[VALUES]), m)
    x = part(W, int(W[SCRATCH]) + n, n)
    copy(n, state, x)
    compute_values(e, W, t, x)
    for k in range(m):
        table[EVENT_SIZE * k + HERE] = values[k]
        table[EVENT_SIZE * k + BLUR] = 0.0
    change = -TOUCHING
    for _side in range(2):
        compute_values(e, W, t * (1.0 + change), x)
        widen_blurs(W)
        for i in range(n):
            kept = x[i]
            x[i] = kept * (1.0 + change)
            compute_values(e, W, t, x)
            widen_blurs(W)
            x[i] = kept
        change = -change


def widen_blurs(W: Reals) -> None:
    """Note where a value differs more from that of the state than before."""
    for k in range(int(W[EVENTS])):
        row = int(W[TABLE]) + EVENT_SIZE * k
        W[row + BLUR] = max(W[row + BLUR], abs(W[int(W[VALUES]) + k] - W[row + HERE]))


def compute_action(a: Function, W: Reals, t: float, x: Reals, values: Reals) -> None:
    """Compute the energy, what actions set, and the rates of the states."""
    status = call(a, int(W[SPEEDS]), part(W, int(W[ACTIONS]), 1), t, x, values)
    if status != 0:
        W[FAULT] = float(status)


def find_rates(a: Function, W: Reals, t: float, state: Reals) -> None:
    """Keep the rates of a state by the equations of motion."""
    compute_action(a, W, t, state, part(W, int(W[ACTED]), int(W[ACTION_VALUES])))
    take_rates(W)


def take_rates(W: Reals) -> None:
    """Keep the rates of the states as the function of actions has written them."""
    n = int(W[STATES])
    copy(n - 1, part(W, int(W[ACTED]) + int(W[ACTION_VALUES]) - (n - 1), n - 1), part(W, int(W[RATE]), n - 1))


def take_rates_of_step(W: Reals, breaks: Reals, pieces: Reals) -> None:
    """Keep the rates at the start of the step that is looked at, from the first rows of its polynomial."""
    n = int(W[STATES])
    step = int(W[CURRENT])
    piece = part(pieces, step * int(W[PIECE_ROWS]) * n, 3 * n)
    length = breaks[step + 1] - breaks[step]
    for i in range(n - 1):
        W[int(W[RATE]) + i] = (piece[n + i] + piece[2 * n + i]) / length


def slope_along(e: Function, W: Reals, place: int, t: float, state: Reals, longest: float) -> float:
    """Return how fast a value changes, as the motion goes on, where states move straight on at `RATE`.

    `disturb_values` has seen the state. The way is as short as its change shows above rounding, at most
    `longest`, which is negative where it leads back. Where nothing shows the slope is 0, and `RESOLUTION` is
    the one that would have.
    """
    n = int(W[STATES])
    values = part(W, int(W[VALUES]), place + 1)
    x = part(W, int(W[SCRATCH]) + n, n)
    row = int(W[TABLE]) + EVENT_SIZE * place
    here = W[row + HERE]
    rounded = ROUNDED * W[row + BLUR]
    most = max(abs(longest), EPSILON / SHORTEST * abs(t))
    way = SHORTEST * most
    slope = 0.0
    while slope == 0.0 and way <= most:
        length = way * W[DIRECTION]
        if longest < 0.0:
            length = -length
        copy(n, state, x)
        for i in range(n - 1):
            x[i] = x[i] + length * W[int(W[RATE]) + i]
        compute_values(e, W, t + length, x)
        if abs(values[place] - here) > VISIBLE * rounded:
            slope = (values[place] - here) / (length * W[DIRECTION])
        W[RESOLUTION] = VISIBLE * rounded / way
        way = way * LONGER
    return slope


def bend_along(
    e: Function, a: Function, W: Reals, place: int, t: float, state: Reals, longest: float
) -> float:
    """Return the sign of the second rate of a value whose first one is zero, as the motion goes on.

    `RATE` holds the rates at the state, which `disturb_values` has seen. The mean of these and of the rates
    at the end of the way leads to a state that is right to second order; the way is that of a slope.
    """
    n = int(W[STATES])
    values = part(W, int(W[VALUES]), place + 1)
    x = part(W, int(W[SCRATCH]) + n, n)
    later = part(W, int(W[ACTED]) + int(W[ACTION_VALUES]) - (n - 1), n - 1)
    row = int(W[TABLE]) + EVENT_SIZE * place
    most = max(abs(longest), EPSILON / SHORTEST * abs(t))
    way = SHORTEST * most
    while way <= most:
        length = way * W[DIRECTION]
        copy(n, state, x)
        for i in range(n - 1):
            x[i] = x[i] + length * W[int(W[RATE]) + i]
        compute_action(a, W, t + length, x, part(W, int(W[ACTED]), int(W[ACTION_VALUES])))
        for i in range(n - 1):
            x[i] = state[i] + length * (0.5 * (W[int(W[RATE]) + i] + later[i]))
        compute_values(e, W, t + length, x)
        if abs(values[place] - W[row + HERE]) > VISIBLE * ROUNDED * W[row + BLUR]:
            return sign(values[place] - W[row + HERE])
        way = way * LONGER
    return 0.0
