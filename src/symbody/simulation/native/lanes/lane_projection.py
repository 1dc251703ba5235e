"""Projection of the states at the ends of steps in lanes: lane by lane, their derivatives all at once.

The cache of the compiled loop does not see a change of this file: renew `lane_cases.SOURCES` after one.
"""

from __future__ import annotations

import numpy as np

from symbody.simulation.native.cases import Cases, fill, fill_projector
from symbody.simulation.native.interface import (
    Floats,
    Goal,
    Memory,
    Method,
    Projector,
    RightHandSide,
    call,
    inline,
)
from symbody.simulation.native.lanes.arithmetic import WIDTH, choose, plus, put, spread, take, times
from symbody.simulation.native.lanes.lane_steps import (
    CALLS,
    ERROR_NORM,
    FIRST,
    MASK,
    T_NEW,
    Bundle,
    T,
    take_marked,
)
from symbody.simulation.native.layout import STATE_NEW, STATE_OLD, TIME
from symbody.simulation.native.loop import project_new_state


@inline
def _project_lane(
    projector: Projector, goal: Goal, memory: Memory, bundle: Bundle, cases: Cases, lane: int
) -> float:
    """Project the new state of a lane; return how far it moved, negative if that was too far."""
    vectors = bundle.vectors
    for i in range(memory.K.shape[1]):
        memory.vectors[STATE_OLD, i] = vectors[STATE_OLD, i * WIDTH + lane]
        memory.vectors[STATE_NEW, i] = vectors[STATE_NEW, i * WIDTH + lane]
    memory.real[TIME] = bundle.trial[T, lane]
    fill_projector(projector, cases, bundle.cases[lane])
    fill(goal.atol, cases.atol, bundle.cases[lane])
    moved: float = project_new_state(projector, goal, memory, bundle.trial[T_NEW, lane])
    for i in range(memory.K.shape[1]):
        vectors[STATE_NEW, i * WIDTH + lane] = memory.vectors[STATE_NEW, i]
    return moved


@inline
def _renew_derivatives(wide: RightHandSide, bundle: Bundle, K: Floats, end: int) -> bool:
    """Renew the derivatives at the ends of the steps that are marked; return False if the function failed.

    Other lanes compute the beginnings of theirs, where the function is known not to fail.
    """
    vectors, trial, scratch, n = bundle.vectors, bundle.trial, bundle.scratch, K.shape[1]
    mask = take(trial, MASK * WIDTH)
    for place in range(0, n, WIDTH):
        new, old = take(vectors, STATE_NEW * n + place), take(vectors, STATE_OLD * n + place)
        put(scratch, place, choose(mask, new, old))
    put(wide.clock, 0, choose(mask, take(trial, T_NEW * WIDTH), take(trial, T * WIDTH)))
    if call(wide, scratch, 0, bundle.derivative, 0) != 0:
        return False
    take_marked(bundle, bundle.derivative, 0, K, end)
    zero = spread(0.0)  # becomes NaN
    for place in range(0, n, WIDTH):
        zero = plus(zero, times(spread(0.0), take(K, end * n + place)))
    put(trial, FIRST * WIDTH, zero)
    for lane in range(WIDTH):
        if trial[MASK, lane] != 0.0 and trial[FIRST, lane] != 0.0:
            trial[ERROR_NORM, lane] = np.inf
    return True


@inline
def project_new_states(
    wide: RightHandSide, projector: Projector, method: Method, goal: Goal, memory: Memory, bundle: Bundle,
    cases: Cases,
) -> bool:  # fmt: skip
    """Do what `loop._close` does in every lane whose error is tolerated; return False if the function failed.

    The errors of lanes that had to move too far become infinite. `memory` is scratch.
    """
    trial, some = bundle.trial, False
    for lane in range(WIDTH):
        trial[MASK, lane] = 0.0
        if bundle.cases[lane] >= 0 and trial[ERROR_NORM, lane] <= 1.0:
            moved = _project_lane(projector, goal, memory, bundle, cases, lane)
            if moved < 0.0:
                trial[ERROR_NORM, lane] = np.inf
            elif moved > 0.0:
                trial[MASK, lane] = 1.0
                trial[CALLS, lane] += 1.0
                some = True
    return not some or _renew_derivatives(wide, bundle, bundle.K, method.stages)
