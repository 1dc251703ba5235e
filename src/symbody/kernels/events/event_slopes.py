"""How fast values of events change by the equations of motion, whatever the polynomial of a step says.

An implicit method knows places and speeds to its tolerance each, so that between its samples a place may fall
while its speed rises. At a start the rates decide: those that the function of actions writes behind its
values, or the first rows of the step's polynomial where no event acts.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import TOUCHING, compute_values, sign
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.language import Function, Reals, part
from symbody.kernels.runge_kutta import call, copy
from symbody.kernels.step_bounds import EPSILON

ROUNDED: Final = 1e-4  # of a change by `TOUCHING`: what polynomials make of roundings
VISIBLE: Final = 10.0  # so many roundings are a change
SHORTEST: Final = 1e-6  # of a step
LONGER: Final = 16.0


def disturb_values(e: Function, monitor: EventMonitor, t: float, state: Reals) -> None:
    """Note the values at a state, and how much each changes where time or one state does by `TOUCHING`.

    A value that is the difference of larger ones is not known better; one of a small state alone is.
    """
    n = monitor.states
    m = monitor.event_count
    values = monitor.values
    x = part(monitor.scratch, n, n)
    copy(n, state, x)
    compute_values(e, monitor, t, x)
    for k in range(m):
        monitor.events[k].here = values[k]
        monitor.events[k].blur = 0.0
    change = -TOUCHING
    for _side in range(2):
        compute_values(e, monitor, t * (1.0 + change), x)
        widen_blurs(monitor)
        for i in range(n):
            kept = x[i]
            x[i] = kept * (1.0 + change)
            compute_values(e, monitor, t, x)
            widen_blurs(monitor)
            x[i] = kept
        change = -change


def widen_blurs(monitor: EventMonitor) -> None:
    """Note where a value differs more from that of the state than before."""
    for k in range(monitor.event_count):
        event = monitor.events[k]
        event.blur = max(event.blur, abs(monitor.values[k] - event.here))


def compute_action(a: Function, monitor: EventMonitor, t: float, x: Reals, values: Reals) -> None:
    """Compute the energy, what actions set, and the rates of the states."""
    status = call(a, monitor.speeds, monitor.actions, t, x, values)
    if status != 0:
        monitor.fault = status


def find_rates(a: Function, monitor: EventMonitor, t: float, state: Reals) -> None:
    """Keep the rates of a state by the equations of motion."""
    compute_action(a, monitor, t, state, monitor.acted)
    take_rates(monitor)


def take_rates(monitor: EventMonitor) -> None:
    """Keep the rates of the states as the function of actions has written them."""
    n = monitor.states
    copy(n - 1, part(monitor.acted, monitor.action_values - (n - 1), n - 1), monitor.rate)


def take_rates_of_step(monitor: EventMonitor, breaks: Reals, pieces: Reals) -> None:
    """Keep the rates at the start of the step that is looked at, from the first rows of its polynomial."""
    n = monitor.states
    step = monitor.current
    piece = part(pieces, step * monitor.piece_rows * n, 3 * n)
    length = breaks[step + 1] - breaks[step]
    for i in range(n - 1):
        monitor.rate[i] = (piece[n + i] + piece[2 * n + i]) / length


def slope_along(
    e: Function, monitor: EventMonitor, place: int, t: float, state: Reals, longest: float
) -> float:
    """Return how fast a value changes, as the motion goes on, where states move straight on at `RATE`.

    `disturb_values` has seen the state. The way is as short as its change shows above rounding, at most
    `longest`, which is negative where it leads back. Where nothing shows the slope is 0, and `RESOLUTION` is
    the one that would have.
    """
    n = monitor.states
    values = monitor.values
    x = part(monitor.scratch, n, n)
    event = monitor.events[place]
    here = event.here
    rounded = ROUNDED * event.blur
    most = max(abs(longest), EPSILON / SHORTEST * abs(t))
    way = SHORTEST * most
    slope = 0.0
    while slope == 0.0 and way <= most:
        length = way * monitor.direction
        if longest < 0.0:
            length = -length
        copy(n, state, x)
        for i in range(n - 1):
            x[i] = x[i] + length * monitor.rate[i]
        compute_values(e, monitor, t + length, x)
        if abs(values[place] - here) > VISIBLE * rounded:
            slope = (values[place] - here) / (length * monitor.direction)
        monitor.resolution = VISIBLE * rounded / way
        way = way * LONGER
    return slope


def bend_along(
    e: Function, a: Function, monitor: EventMonitor, place: int, t: float, state: Reals, longest: float
) -> float:
    """Return the sign of the second rate of a value whose first one is zero, as the motion goes on.

    `RATE` holds the rates at the state, which `disturb_values` has seen. The mean of these and of the rates
    at the end of the way leads to a state that is right to second order; the way is that of a slope.
    """
    n = monitor.states
    values = monitor.values
    x = part(monitor.scratch, n, n)
    later = part(monitor.acted, monitor.action_values - (n - 1), n - 1)
    event = monitor.events[place]
    most = max(abs(longest), EPSILON / SHORTEST * abs(t))
    way = SHORTEST * most
    while way <= most:
        length = way * monitor.direction
        copy(n, state, x)
        for i in range(n - 1):
            x[i] = x[i] + length * monitor.rate[i]
        compute_action(a, monitor, t + length, x, monitor.acted)
        for i in range(n - 1):
            x[i] = state[i] + length * (0.5 * (monitor.rate[i] + later[i]))
        compute_values(e, monitor, t + length, x)
        if abs(values[place] - event.here) > VISIBLE * ROUNDED * event.blur:
            return sign(values[place] - event.here)
        way = way * LONGER
    return 0.0
