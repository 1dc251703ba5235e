"""Where values of events are zero: roots and extrema between samples of a motion.

The motion is the dense output of its last steps, `breaks` and `pieces` as in `step_machine`; `e` is the
function of the values of all events.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.dense_output import interpolate
from symbody.kernels.events.event_monitor import EXTREMUM_NODES, ZEROS_PER_EVENT, EventMonitor
from symbody.kernels.language import NAN, Function, Reals, part
from symbody.kernels.runge_kutta import call

EXACT: Final = 1e-15  # of a time, and of the interval a zero lies in
TOUCHING: Final = 1e-10  # of the largest value so far: an extremum this close to zero touches it
MOST_ROUNDS: Final = 200
STEEP: Final = 10.0  # times the values beside it: such a value stands at a pole
BESIDE: Final = 1e-10  # of the run
DEEP: Final = 0.01  # of the values beside it: an extremum that touches zero lies lower
SCANNED: Final = 32  # parts of an interval in which the slope is looked at
HALVINGS: Final = 54


def sign(x: float) -> float:
    """Return 1, -1 or 0."""
    if x > 0.0:
        return 1.0
    if x < 0.0:
        return -1.0
    return 0.0


def state_at(monitor: EventMonitor, breaks: Reals, pieces: Reals, t: float, x: Reals) -> None:
    """Set x to the state at a time of the smooth motion; times beyond its ends count as these."""
    n = monitor.states
    rows = monitor.piece_rows
    direction = monitor.direction
    step = monitor.current
    first = monitor.first_step
    while step > first and (t - breaks[step]) * direction < 0.0:
        step = step - 1
    start = breaks[step]
    end = breaks[step + 1]
    share = 0.0
    if end != start:
        share = min(max((t - start) / (end - start), 0.0), 1.0)
    interpolate(n, rows, part(pieces, step * rows * n, rows * n), share, x)


def compute_values(e: Function, monitor: EventMonitor, t: float, x: Reals) -> None:
    """Set `VALUES` to those of all events at a time and state."""
    out = monitor.values
    status = call(e, monitor.speeds, monitor.numbers, t, x, out)
    if status != 0:
        monitor.fault = status
    for k in range(monitor.event_count):
        if status != 0:
            out[k] = NAN
        out[k] = out[k] - monitor.events[k].level


def compute_values_at(e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, t: float) -> None:
    """Set `VALUES` to those of all events at a time of the smooth motion."""
    x = monitor.scratch
    state_at(monitor, breaks, pieces, t, x)
    compute_values(e, monitor, t, x)


def value_at(e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, t: float) -> float:
    """Return the value of one event at a time of the smooth motion."""
    compute_values_at(e, monitor, breaks, pieces, t)
    return monitor.values[place]


def find_root(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, begin: float, end: float
) -> float:
    """Return the zero of a value between times at which its signs differ, else the time where it is smaller.

    Inverse quadratic interpolation where it is monotonic, else bisection: Chandrupatla, Advances in
    Engineering Software 28 (1997). `a` and `b` enclose the zero, `c` is the point before.
    """
    a = end
    b = begin
    fa = value_at(e, monitor, breaks, pieces, place, a)
    fb = value_at(e, monitor, breaks, pieces, place, b)
    if sign(fa) * sign(fb) >= 0.0:  # a sample that was zero up to rounding
        if abs(fb) <= abs(fa):
            return b
        return a
    shortest = EXACT * abs(end - begin)
    share = 0.5
    best = a
    for _round in range(MOST_ROUNDS):
        x = a + share * (b - a)
        fx = value_at(e, monitor, breaks, pieces, place, x)
        c = a
        fc = fa
        if sign(fx) != sign(fa):
            c = b
            fc = fb
            b = a
            fb = fa
        a = x
        fa = fx
        best = a
        if abs(fb) < abs(fa):
            best = b
        tolerance = 0.5 * (shortest + EXACT * abs(best))
        if fa == 0.0 or abs(b - a) <= 2.0 * tolerance:
            break
        share = next_share(a, b, c, fa, fb, fc)
        least = tolerance / abs(b - a)
        share = min(max(share, least), 1.0 - least)
    return best


def next_share(a: float, b: float, c: float, fa: float, fb: float, fc: float) -> float:
    """Return at which share of the way from a to b a zero is looked for next."""
    along = (a - b) / (c - b)
    up = (fa - fb) / (fc - fb)
    other = 1.0 - up
    if up * up < along and other * other < 1.0 - along:
        # ratios of values, whose products might be too small for a number
        first = fa / (fb - fa) * (fc / (fb - fc))
        second = (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb))
        share = first + second
        if share > 0.0 and share < 1.0:
            return share
    return 0.5


def fit_slope(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, begin: float, end: float
) -> None:
    """Fit the slope of a value between times: its Chebyshev coefficients, over half of the interval."""
    count = EXTREMUM_NODES
    fit = monitor.extremum_fit
    samples = part(fit, count * (count + 1), count)
    slopes = part(fit, count * (count + 2), count)
    for k in range(count):
        samples[k] = value_at(e, monitor, breaks, pieces, place, begin + (end - begin) * fit[k])
    later = 0.0
    last = 0.0
    for k in range(count - 1, 0, -1):
        coefficient = 0.0
        for j in range(count):
            coefficient = coefficient + fit[count + k * count + j] * samples[j]
        slope = later + 2.0 * k * coefficient
        slopes[k] = last
        later = last
        last = slope
    slopes[0] = 0.5 * last


def slope_at(monitor: EventMonitor, share: float) -> float:
    """Return the slope that was fitted at a share of its interval."""
    count = EXTREMUM_NODES
    slopes = part(monitor.extremum_fit, count * (count + 2), count)
    x = 2.0 * share - 1.0
    one = 0.0
    two = 0.0
    for k in range(count - 1, 0, -1):
        value = slopes[k] + 2.0 * x * one - two
        two = one
        one = value
    return slopes[0] + x * one - two


def find_flat_share(monitor: EventMonitor, low: float, high: float) -> float:
    """Return where the fitted slope is zero between shares at which its signs differ."""
    below = low
    above = high
    rising = sign(slope_at(monitor, above))
    for _halving in range(HALVINGS):
        middle = 0.5 * (below + above)
        if sign(slope_at(monitor, middle)) == rising:
            above = middle
        else:
            below = middle
    return 0.5 * (below + above)


def find_extremum(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, begin: float, end: float,
    side: float,
) -> float:  # fmt: skip
    """Return when `side` times a value is least between times."""
    fit_slope(e, monitor, breaks, pieces, place, begin, end)
    lowest = begin
    least = side * value_at(e, monitor, breaks, pieces, place, begin)
    value = side * value_at(e, monitor, breaks, pieces, place, end)
    if value < least:
        lowest = end
        least = value
    before = 0.0
    for k in range(SCANNED):
        behind = (k + 1.0) / SCANNED
        # Only valleys can be lowest.
        if side * slope_at(monitor, before) < 0.0 and side * slope_at(monitor, behind) >= 0.0:
            t = begin + (end - begin) * find_flat_share(monitor, before, behind)
            value = side * value_at(e, monitor, breaks, pieces, place, t)
            if value < least:
                lowest = t
                least = value
        before = behind
    return lowest


def add_zero(monitor: EventMonitor, t: float, place: int, direction: float) -> None:
    """Add a zero to those that wait, unless as many lie where samples cannot be told apart."""
    if monitor.pending_count == ZEROS_PER_EVENT * monitor.event_count:
        return
    zero = monitor.pending[monitor.pending_count]
    zero.time = t
    zero.event = place
    zero.direction = direction
    monitor.pending_count = monitor.pending_count + 1


def add_root(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, begin: float, end: float,
    direction: float,
) -> None:  # fmt: skip
    """Add the zero between times at which the signs of a value differ, unless its sign changes at a pole."""
    event = monitor.events[place]
    t = find_root(e, monitor, breaks, pieces, place, begin, end)
    value = abs(value_at(e, monitor, breaks, pieces, place, t))
    before = abs(value_at(e, monitor, breaks, pieces, place, t - BESIDE * monitor.span))
    behind = abs(value_at(e, monitor, breaks, pieces, place, t + BESIDE * monitor.span))
    if value <= STEEP * max(before, behind):
        add_zero(monitor, t, place, direction)
    elif event.pole == 0.0:
        event.pole = 1.0
        event.pole_time = t


def add_touch(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, begin: float, end: float,
    side: float,
) -> None:  # fmt: skip
    """Add the zeros about an extremum between times at which a value has one sign, if there are any."""
    largest = monitor.events[place].largest
    lowest = find_extremum(e, monitor, breaks, pieces, place, begin, end, side)
    value = side * value_at(e, monitor, breaks, pieces, place, lowest)
    if value < -TOUCHING * largest:
        add_root(e, monitor, breaks, pieces, place, begin, lowest, -side)
        add_root(e, monitor, breaks, pieces, place, lowest, end, side)
    elif abs(value) <= TOUCHING * largest:
        beside = abs(value_at(e, monitor, breaks, pieces, place, begin))
        other = abs(value_at(e, monitor, breaks, pieces, place, end))
        beside = max(beside, other)
        if abs(value) <= DEEP * beside:  # largest may be the value beside a pole
            add_zero(monitor, lowest, place, 0.0)
