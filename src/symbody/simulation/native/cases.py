"""Many motions of one mechanism, one after the other in the compiled loop, without returning to Python.

numba renews what it keeps of `run_cases` when the text of this file changes; `SOURCES` stands for the files
compiled into it, `loop.py` among them.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from symbody.simulation.native.interface import (
    Floats,
    Goal,
    Integers,
    Memory,
    Method,
    Projector,
    Record,
    RightHandSide,
    compile_loop,
    inline,
)
from symbody.simulation.native.layout import FIRST_BREAK, NEXT_BREAK, RUNNING, STATE_OLD, TIME
from symbody.simulation.native.loop import advance, begin

# A test says what it has to be.
SOURCES: Final = "f781e4f44aef2043"
# Steps between two looks at whether the run is to stop.
_SLICE: Final = 1000


class Cases(NamedTuple):
    """What differs from case to case; one row each.

    Attributes
    ----------
    states : (cases, n) array
        First states x = (u, q).
    parameters, constants : (cases, n_p), (cases, n_c) arrays
        The groups p and c of the right-hand side.
    projector_parameters, projector_constants : arrays
        The same of the projector; without columns if nothing is projected.
    scales, sizes : (cases, constraints), (cases, n_q) arrays
        As in `Projector`.
    atol : (cases, n) array
        As in `Goal`.
    first_breaks : (cases,) array of int
        Where the breakpoints of each begin, see `Goal`.
    """

    states: Floats
    parameters: Floats
    constants: Floats
    projector_parameters: Floats
    projector_constants: Floats
    scales: Floats
    sizes: Floats
    atol: Floats
    first_breaks: Integers


class Outcome(NamedTuple):
    """What comes of each case; one row each.

    Attributes
    ----------
    x : (cases, N, n) array
        The samples; rows that were not reached stay as they were.
    codes : (cases,) array of int
        What `loop.advance` returned; -1 for cases not begun or not ended.
    counts : (cases, COUNTS) array of int
        `Memory.counts` at the end.
    reached : (cases,) array
        Time up to which each motion is known [s].
    stop : array of one int
        Anything but 0 ends the work between two steps.
    done : array of one int
        How many cases have ended.
    """

    x: Floats
    codes: Integers
    counts: Integers
    reached: Floats
    stop: Integers
    done: Integers


@inline
def fill(row: Floats, rows: Floats, k: int) -> None:
    """Copy a row of a table."""
    for i in range(row.size):
        row[i] = rows[k, i]


@inline
def fill_projector(projector: Projector, cases: Cases, k: int) -> None:
    """Set what projects to the numbers of case k, if anything is projected."""
    if projector.address != 0:
        fill(projector.parameters, cases.projector_parameters, k)
        fill(projector.constants, cases.projector_constants, k)
        fill(projector.scales, cases.scales, k)
        fill(projector.sizes, cases.sizes, k)


@inline
def prepare(rhs: RightHandSide, memory: Memory, cases: Cases, k: int, start: float) -> None:
    """Set the loop to the beginning of case k."""
    fill(rhs.parameters, cases.parameters, k)
    fill(rhs.constants, cases.constants, k)
    for i in range(cases.states.shape[1]):
        memory.vectors[STATE_OLD, i] = cases.states[k, i]
    # What a case before left there would decide whose fault a failure is.
    memory.K[:] = 0.0
    memory.real[:] = 0.0
    memory.real[TIME] = start
    memory.counts[:] = 0
    memory.counts[FIRST_BREAK] = memory.counts[NEXT_BREAK] = cases.first_breaks[k]


@inline
def conclude(memory: Memory, outcome: Outcome, k: int, code: int) -> None:
    """Write down how far case k came, and how it ended unless it is still running."""
    for i in range(memory.counts.size):
        outcome.counts[k, i] = memory.counts[i]
    outcome.reached[k] = memory.real[TIME]
    if code != RUNNING:
        outcome.codes[k] = code
        outcome.done[0] += 1


@compile_loop
def run_cases(
    rhs: RightHandSide,
    projector: Projector,
    method: Method,
    goal: Goal,
    memory: Memory,
    record: Record,
    start: float,
    first_step: float,
    cases: Cases,
    outcome: Outcome,
) -> None:
    """Compute all cases that have no code yet; `record.x` and `record.t` are scratch.

    Arrays of `rhs`, `projector`, `goal` and `memory` are overwritten by those of each case.
    """
    for k in range(cases.states.shape[0]):
        if outcome.codes[k] != -1:
            continue
        prepare(rhs, memory, cases, k, start)
        fill_projector(projector, cases, k)
        fill(goal.atol, cases.atol, k)
        own = Record(record.wanted, record.t, outcome.x[k], record.breaks, record.pieces, False, False)
        code = begin(rhs, method, goal, memory, own, first_step)
        while code == RUNNING and outcome.stop[0] == 0:
            code = advance(rhs, projector, method, goal, memory, own, _SLICE)
        conclude(memory, outcome, k, code)
        if code == RUNNING:
            return
