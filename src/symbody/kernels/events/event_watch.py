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
)
from symbody.kernels.events.event_starts import begin_samples, leave_zero, note_value, settle_start
from symbody.kernels.events.watch_block import (
    AT_START,
    AT_ZERO,
    CURRENT,
    CUT,
    DEEPEST,
    DIRECTION,
    EVENT_SIZE,
    EVENTS,
    FAILS,
    FAULT,
    FIRST_STEP,
    G_BEFORE,
    G_LAST,
    G_OLDER,
    GOES_ON,
    GOES_THROUGH,
    HIT,
    HIT_TIME,
    LARGEST,
    LEAF,
    LEAF_END,
    LEAF_VALUES,
    NODE,
    NOTHING_YET,
    PEAK,
    PENDING_COUNT,
    SAMPLED,
    SCRATCH,
    SEEN,
    STACK,
    STACKED,
    STATES,
    STEP_FIT,
    STEP_NODES,
    T_BEFORE,
    T_LAST,
    T_OLDER,
    TABLE,
    VALUES,
)
from symbody.kernels.events.zeros_in_order import settle, steps_before
from symbody.kernels.language import INFINITY, Function, Reals, part

RESOLVED: Final = 1e-3
MIDDLE: Final = 4  # sample of a leaf


def start_stretch(W: Reals, first: int) -> None:
    """Begin a smooth motion with step number `first`."""
    W[FIRST_STEP] = float(first)
    W[SAMPLED] = float(first)
    W[CURRENT] = float(first)
    W[SEEN] = 0.0
    W[STACKED] = 0.0
    W[NODE] = float(STEP_NODES)
    W[PENDING_COUNT] = 0.0
    for k in range(int(W[EVENTS])):
        W[int(W[TABLE]) + EVENT_SIZE * k + HIT] = 0.0
        W[int(W[TABLE]) + EVENT_SIZE * k + AT_ZERO] = 0.0
        W[int(W[TABLE]) + EVENT_SIZE * k + GOES_THROUGH] = 0.0
        W[int(W[TABLE]) + EVENT_SIZE * k + AT_START] = 0.0


def sample_leaf(e: Function, W: Reals, breaks: Reals, pieces: Reals, begin: float, end: float) -> None:
    """Sample a part of a step: times, then the values of each event."""
    m = int(W[EVENTS])
    leaf = part(W, int(W[LEAF]), LEAF_VALUES + m * STEP_NODES)
    shares = part(W, int(W[STEP_FIT]), STEP_NODES)
    values = part(W, int(W[VALUES]), m)
    for k in range(STEP_NODES):
        leaf[k] = begin + (end - begin) * shares[k]
    leaf[STEP_NODES - 1] = end
    for k in range(STEP_NODES):
        compute_values_at(e, W, breaks, pieces, leaf[k])
        for i in range(m):
            leaf[LEAF_VALUES + i * STEP_NODES + k] = values[i]


def is_rough(W: Reals) -> int:
    """Return 1 if the polynomial through the samples of a leaf does not resolve some value, else 0."""
    fit = part(W, int(W[STEP_FIT]) + STEP_NODES, STEP_NODES * STEP_NODES)
    for i in range(int(W[EVENTS])):
        samples = part(W, int(W[LEAF]) + LEAF_VALUES + i * STEP_NODES, STEP_NODES)
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


def take_leaf(e: Function, a: Function, W: Reals, breaks: Reals, pieces: Reals) -> None:
    """Sample the next part of a step, halved until its values are resolved."""
    stack = part(W, int(W[STACK]), 2 * (DEEPEST + 2))
    top = int(W[STACKED]) - 1
    begin = W[LEAF_END]
    end = stack[2 * top]
    depth = int(stack[2 * top + 1])
    sample_leaf(e, W, breaks, pieces, begin, end)
    if W[SEEN] == 0.0 and depth == 0:
        settle_start(e, W)
    while depth < DEEPEST:
        if is_rough(W) == 0:
            break
        depth = depth + 1
        middle = W[int(W[LEAF]) + MIDDLE]
        stack[2 * top + 1] = float(depth)
        top = top + 1
        stack[2 * top] = middle
        stack[2 * top + 1] = float(depth)
        sample_leaf(e, W, breaks, pieces, begin, middle)
    W[STACKED] = float(top)
    W[LEAF_END] = stack[2 * top]
    W[NODE] = 1.0
    if W[SEEN] == 0.0:
        begin_samples(e, a, W, breaks, pieces)


def take_sample(e: Function, W: Reals, breaks: Reals, pieces: Reals) -> None:
    """Take the next sample of the leaf, and find the zeros that it shows."""
    m = int(W[EVENTS])
    node = int(W[NODE])
    t = W[int(W[LEAF]) + node]
    W[T_OLDER] = W[T_BEFORE]
    W[T_BEFORE] = W[T_LAST]
    W[T_LAST] = t
    W[SEEN] = W[SEEN] + 1.0
    W[NODE] = float(node + 1)
    for i in range(m):
        row = part(W, int(W[TABLE]) + EVENT_SIZE * i, EVENT_SIZE)
        value = W[int(W[LEAF]) + LEAF_VALUES + i * STEP_NODES + node]
        note_value(W, i, t, value)
        if row[AT_ZERO] != 0.0:
            value = leave_zero(e, W, breaks, pieces, i, t, value)
        row[PEAK] = max(row[PEAK], abs(value))
        row[G_OLDER] = row[G_BEFORE]
        row[G_BEFORE] = row[G_LAST]
        row[G_LAST] = value
        if abs(value) < INFINITY:
            row[LARGEST] = max(row[LARGEST], abs(value))
    for i in range(m):
        compare_samples(e, W, breaks, pieces, i)


def compare_samples(e: Function, W: Reals, breaks: Reals, pieces: Reals, place: int) -> None:
    """Add the zeros of one value that its newest sample shows."""
    row = int(W[TABLE]) + EVENT_SIZE * place
    last = W[row + G_LAST]
    before = W[row + G_BEFORE]
    if W[row + HIT] != 0.0:  # the sample before was zero
        direction = sign(last)
        if direction == 0.0:
            direction = -W[row + HIT]
        elif direction == W[row + HIT]:
            direction = 0.0
        add_zero(W, W[row + HIT_TIME], place, direction)
        W[row + HIT] = 0.0
    elif last == 0.0 and sign(before) != 0.0:
        W[row + HIT] = sign(before)
        W[row + HIT_TIME] = W[T_LAST]
    elif sign(before) * sign(last) < 0.0:
        add_root(e, W, breaks, pieces, place, W[T_BEFORE], W[T_LAST], sign(last))
    elif W[SEEN] >= 3.0 and is_lowest(W[row + G_OLDER], before, last) != 0:
        add_touch(e, W, breaks, pieces, place, W[T_OLDER], W[T_LAST], sign(before))


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
    e: Function, a: Function, c: Function, W: Reals, breaks: Reals, pieces: Reals, H: Reals, steps: int,
    is_over: int,
) -> int:  # fmt: skip
    """Look at the first `steps` steps of a motion as far as not done; return one of the codes of the block.

    What happened is written into H. `e` gives the values of events, `a` the energy and what actions set, `c`
    what moves a state onto the constraints.
    """
    while W[FAULT] == 0.0:
        last = 0
        if is_over != 0 and int(W[SAMPLED]) >= steps and int(W[STACKED]) == 0:
            if int(W[NODE]) >= STEP_NODES:
                last = 1
                conclude_hits(W)
        code = settle(e, a, c, W, breaks, pieces, H, last)
        if W[FAULT] != 0.0:
            break
        if code == GOES_ON:
            start_stretch(W, steps_before(breaks, int(W[CURRENT]) + 1, W[CUT], W[DIRECTION]))
        if code != NOTHING_YET:
            return code
        if int(W[NODE]) < STEP_NODES:
            take_sample(e, W, breaks, pieces)
        elif int(W[STACKED]) > 0:
            take_leaf(e, a, W, breaks, pieces)
        elif int(W[SAMPLED]) < steps:
            take_step(W, breaks, pieces)
        else:
            return NOTHING_YET
    return FAILS


def take_step(W: Reals, breaks: Reals, pieces: Reals) -> None:
    """Turn to the next step."""
    step = int(W[SAMPLED])
    n = int(W[STATES])
    stack = part(W, int(W[STACK]), 2)
    W[CURRENT] = float(step)
    W[SAMPLED] = float(step + 1)
    W[LEAF_END] = breaks[step]
    stack[0] = breaks[step + 1]
    stack[1] = 0.0
    W[STACKED] = 1.0
    if W[SEEN] == 0.0:
        state_at(W, breaks, pieces, breaks[step], part(W, int(W[SCRATCH]) + 2 * n, n))


def conclude_hits(W: Reals) -> None:
    """Add the zeros that the last sample of all hit."""
    for i in range(int(W[EVENTS])):
        row = int(W[TABLE]) + EVENT_SIZE * i
        if W[row + HIT] != 0.0:
            add_zero(W, W[row + HIT_TIME], i, -W[row + HIT])
            W[row + HIT] = 0.0
