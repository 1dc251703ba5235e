"""How fast values of events change by the equations of motion, whatever the polynomial of a step says.

An implicit method knows places and speeds to its tolerance each, so that between its samples a place may fall
while its speed rises. At a start the rates decide: those that the function of actions writes behind its
values, or the first rows of the step's polynomial.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import TOUCHING, compute_values
from symbody.kernels.events.watch_block import (
    ACTED,
    ACTION_VALUES,
    CURRENT,
    DIRECTION,
    PIECE_ROWS,
    RATE,
    RESOLUTION,
    SCRATCH,
    STATES,
    VALUES,
)
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_bounds import EPSILON

ROUNDED: Final = 1e-4  # of a change by `TOUCHING`: what polynomials make of roundings
VISIBLE: Final = 10.0  # so many roundings are a change
SHORTEST: Final = 1e-6  # of a step
LONGER: Final = 16.0


def rounding_error(e: Function, W: Reals, place: int, t: float, here: float, state: Reals) -> float:
    """Return how much a value changes where time or one state does by a share of `TOUCHING`.

    A value that is the difference of larger ones is not known better; one of a small state alone is.
    """
    n = int(W[STATES])
    values = part(W, int(W[VALUES]), place + 1)
    x = part(W, int(W[SCRATCH]) + n, n)
    copy(n, state, x)
    most = 0.0
    change = -TOUCHING
    for _side in range(2):
        compute_values(e, W, t * (1.0 + change), x)
        most = max(most, abs(values[place] - here))
        for i in range(n):
            kept = x[i]
            x[i] = kept * (1.0 + change)
            compute_values(e, W, t, x)
            most = max(most, abs(values[place] - here))
            x[i] = kept
        change = -change
    return most


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

    The way is as short as its change shows above rounding, at most `longest`, which is negative where it
    leads back. Where nothing shows the slope is 0, and `RESOLUTION` is the one that would have.
    """
    n = int(W[STATES])
    values = part(W, int(W[VALUES]), place + 1)
    x = part(W, int(W[SCRATCH]) + n, n)
    compute_values(e, W, t, state)
    here = values[place]
    rounded = ROUNDED * rounding_error(e, W, place, t, here, state)
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
