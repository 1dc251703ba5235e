"""The search for events, sample by sample along a motion, and what happens at them.

A step is sampled at the Chebyshev points of one degree above that of its dense output. Where the highest
coefficients of the polynomial through them are not small, it is halved: a motion that is slow takes long
steps, but what is watched may depend on time. A zero counts when the sample behind the next one is known: an
extremum needs both sides. What is found depends on the motion alone, not on when it is looked at.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import (
    add_root,
    add_touch,
    add_zero,
    compute_values_at,
    sign,
    state_at,
    value_at,
)
from symbody.kernels.events.event_monitor import (
    DEEPEST,
    FAILS,
    GOES_ON,
    LEAF_VALUES,
    NOTHING_YET,
    SHORTENS,
    STEP_NODES,
    EventMonitor,
)
from symbody.kernels.events.event_starts import begin_samples, leave_zero, note_value, settle_start
from symbody.kernels.events.zeros_in_order import SIMULTANEOUS, settle, steps_before
from symbody.kernels.language import INFINITY, Function, Reals, part

RESOLVED: Final = 1e-3
MIDDLE: Final = 4  # sample of a leaf


def start_stretch(monitor: EventMonitor, first: int) -> None:
    """Begin a smooth motion with step number `first`."""
    monitor.first_step = first
    monitor.sampled = first
    monitor.current = first
    monitor.seen = 0.0
    monitor.stacked = 0
    monitor.node = STEP_NODES
    monitor.pending_count = 0
    for k in range(monitor.event_count):
        monitor.events[k].hit = 0.0
        monitor.events[k].at_zero = 0.0
        monitor.events[k].goes_through = 0.0
        monitor.events[k].at_start = 0.0


def sample_leaf(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, begin: float, end: float
) -> None:
    """Sample a part of a step: times, then the values of each event."""
    m = monitor.event_count
    leaf = monitor.leaf
    shares = monitor.step_fit
    values = monitor.values
    for k in range(STEP_NODES):
        leaf[k] = begin + (end - begin) * shares[k]
    leaf[STEP_NODES - 1] = end
    for k in range(STEP_NODES):
        compute_values_at(e, monitor, breaks, pieces, leaf[k])
        for i in range(m):
            leaf[LEAF_VALUES + i * STEP_NODES + k] = values[i]


def is_rough(monitor: EventMonitor) -> int:
    """Return 1 if the polynomial through the samples of a leaf does not resolve some value, else 0."""
    fit = part(monitor.step_fit, STEP_NODES, STEP_NODES * STEP_NODES)
    for i in range(monitor.event_count):
        samples = part(monitor.leaf, LEAF_VALUES + i * STEP_NODES, STEP_NODES)
        largest = 0.0
        last = 0.0
        for k in range(STEP_NODES):
            coefficient = 0.0
            for j in range(STEP_NODES):
                coefficient = coefficient + fit[k * STEP_NODES + j] * samples[j]
            largest = max(largest, abs(coefficient))
            if k >= STEP_NODES - 2:
                last = max(last, abs(coefficient))
        if last > RESOLVED * largest:
            return 1
    return 0


def take_leaf(e: Function, a: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals) -> None:
    """Sample the next part of a step, halved until its values are resolved."""
    stack = monitor.stack
    top = monitor.stacked - 1
    begin = monitor.leaf_end
    end = stack[2 * top]
    depth = int(stack[2 * top + 1])
    sample_leaf(e, monitor, breaks, pieces, begin, end)
    if monitor.seen == 0.0 and depth == 0:
        settle_start(e, monitor)
    while depth < DEEPEST:
        if is_rough(monitor) == 0:
            break
        depth = depth + 1
        middle = monitor.leaf[MIDDLE]
        stack[2 * top + 1] = float(depth)
        top = top + 1
        stack[2 * top] = middle
        stack[2 * top + 1] = float(depth)
        sample_leaf(e, monitor, breaks, pieces, begin, middle)
    monitor.stacked = top
    monitor.leaf_end = stack[2 * top]
    monitor.node = 1
    if monitor.seen == 0.0:
        begin_samples(e, a, monitor, breaks, pieces)


def take_sample(e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals) -> None:
    """Take the next sample of the leaf, and find the zeros that it shows."""
    m = monitor.event_count
    node = monitor.node
    t = monitor.leaf[node]
    monitor.t_older = monitor.t_before
    monitor.t_before = monitor.t_last
    monitor.t_last = t
    monitor.seen = monitor.seen + 1.0
    monitor.node = node + 1
    for i in range(m):
        event = monitor.events[i]
        value = monitor.leaf[LEAF_VALUES + i * STEP_NODES + node]
        note_value(monitor, i, t, value)
        if event.at_zero != 0.0:
            value = leave_zero(e, monitor, breaks, pieces, i, t, value)
        event.peak = max(event.peak, abs(value))
        event.g_older = event.g_before
        event.g_before = event.g_last
        event.g_last = value
        if abs(value) < INFINITY:
            event.largest = max(event.largest, abs(value))
    for i in range(m):
        compare_samples(e, monitor, breaks, pieces, i)


def compare_samples(e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int) -> None:
    """Add the zeros of one value that its newest sample shows."""
    event = monitor.events[place]
    last = event.g_last
    before = event.g_before
    if event.action == SHORTENS and is_moment(monitor, breaks) != 0:
        return
    if event.hit != 0.0:  # the sample before was zero
        direction = sign(last)
        if direction == 0.0:
            direction = -event.hit
        elif direction == event.hit:
            direction = 0.0
        add_zero(monitor, event.hit_time, place, direction)
        event.hit = 0.0
    elif last == 0.0 and sign(before) != 0.0:
        event.hit = sign(before)
        event.hit_time = monitor.t_last
    elif sign(before) * sign(last) < 0.0:
        if event.action == SHORTENS and comes_back(e, monitor, breaks, pieces, place, sign(before)) == 0:
            return
        add_root(e, monitor, breaks, pieces, place, monitor.t_before, monitor.t_last, sign(last))
    elif monitor.seen >= 3.0 and is_lowest(event.g_older, before, last) != 0:
        add_touch(e, monitor, breaks, pieces, place, monitor.t_older, monitor.t_last, sign(before))


def is_moment(monitor: EventMonitor, breaks: Reals) -> int:
    """Return 1 if a step is so short that all that happens in it is simultaneous, else 0."""
    end = breaks[monitor.current + 1]
    if abs(end - breaks[monitor.current]) <= SIMULTANEOUS * max(monitor.span, abs(end)):
        return 1
    return 0


def comes_back(
    e: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, place: int, side: float
) -> int:
    """Return 1 if a value is back on a side of zero at the end of its step, else 0."""
    if value_at(e, monitor, breaks, pieces, place, breaks[monitor.current + 1]) * side > 0.0:
        return 1
    return 0


def is_lowest(older: float, before: float, last: float) -> int:
    """Return 1 if the middle of three samples on one side of zero may stand beside a touch, else 0."""
    side = sign(before)
    if side == 0.0 or sign(older) != side or sign(last) != side:
        return 0
    inner = abs(before)
    left = abs(older)
    right = abs(last)
    if inner > left or inner > right or not max(left, right) < INFINITY:
        return 0
    if inner <= 4.0 * max(left - inner, right - inner):
        return 1
    return 0


def look(
    e: Function, a: Function, c: Function, monitor: EventMonitor, breaks: Reals, pieces: Reals, H: Reals,
    steps: int, is_over: int,
) -> int:  # fmt: skip
    """Look at the first `steps` steps of a motion as far as not done; return one of the codes of the block.

    What happened is written into H. `e` gives the values of events, `a` the energy and what actions set, `c`
    what moves a state onto the constraints.
    """
    while monitor.fault == 0:
        last = 0
        if is_over != 0 and monitor.sampled >= steps and monitor.stacked == 0:
            if monitor.node >= STEP_NODES:
                last = 1
                conclude_hits(monitor)
        code = settle(e, a, c, monitor, breaks, pieces, H, last)
        if monitor.fault != 0:
            break
        if code == GOES_ON:
            start_stretch(monitor, steps_before(breaks, monitor.current + 1, monitor.cut, monitor.direction))
        if code != NOTHING_YET:
            return code
        if monitor.node < STEP_NODES:
            take_sample(e, monitor, breaks, pieces)
        elif monitor.stacked > 0:
            take_leaf(e, a, monitor, breaks, pieces)
        elif monitor.sampled < steps:
            take_step(monitor, breaks, pieces)
        else:
            return NOTHING_YET
    return FAILS


def take_step(monitor: EventMonitor, breaks: Reals, pieces: Reals) -> None:
    """Turn to the next step."""
    step = monitor.sampled
    n = monitor.states
    stack = monitor.stack
    monitor.current = step
    monitor.sampled = step + 1
    monitor.leaf_end = breaks[step]
    stack[0] = breaks[step + 1]
    stack[1] = 0.0
    monitor.stacked = 1
    if monitor.seen == 0.0:
        state_at(monitor, breaks, pieces, breaks[step], part(monitor.scratch, 2 * n, n))


def conclude_hits(monitor: EventMonitor) -> None:
    """Add the zeros that the last sample of all hit."""
    for i in range(monitor.event_count):
        event = monitor.events[i]
        if event.hit != 0.0:
            add_zero(monitor, event.hit_time, i, -event.hit)
            event.hit = 0.0
