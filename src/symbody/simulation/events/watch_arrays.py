"""The block of a watch for events; see `symbody.kernels.events.watch_block`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.events import watch_block as at
from symbody.simulation.inputs.chebyshev import DEGREE, chebyshev_nodes, to_coefficients
from symbody.simulation.native.dense_output import cut_matrix

Floats = NDArray[np.float64]

# So many events of one kind at one instant are one too many.
_MOST_ACTING: Final = 10
_MOST_RECORDED: Final = 100


def _fit(degree: int, room: int) -> Floats:
    """Return nodes and matrix, and room behind them."""
    return np.concatenate([chebyshev_nodes(degree), to_coefficients(degree).ravel(), np.zeros(room)])


_EXTREMUM_FIT: Final = _fit(at.EXTREMUM_NODES - 1, 2 * at.EXTREMUM_NODES)
_STEP_FIT: Final = _fit(DEGREE, 0)


class WatchedEvent(NamedTuple):
    """One event as numbers.

    Attributes
    ----------
    direction : int
        As in `Event`.
    action : float
        `RECORDS`, `STOPS` or `SETS` of the block.
    wraps : bool
        Whether its value reads an angle that jumps by a turn.
    targets : tuple of int
        The states that it sets.
    level : float
        What is taken from its value.
    of_time : bool
        Whether its value reads no state, so that no action changes where it goes.
    """

    direction: int
    action: float
    wraps: bool
    targets: tuple[int, ...]
    level: float = 0.0
    of_time: bool = False


class WatchNumbers(NamedTuple):
    """Sizes of a watch, and the numbers of its functions, empty where there is none.

    Attributes
    ----------
    states, speeds : int
        Numbers of states, the work among them, and of speeds.
    values, actions : arrays
        Numbers of the function of the values, and of actions.
    closing : array
        The block of what closes states.
    """

    states: int
    speeds: int
    values: Floats
    actions: Floats
    closing: Floats


def make_watch_block(events: Sequence[WatchedEvent], numbers: WatchNumbers) -> Floats:
    """Return the block of a watch that has not begun; the length of its run is still to be set."""
    m, n = len(events), numbers.states
    targets = np.array([place for event in events for place in event.targets], dtype=np.float64)
    parts = {
        at.EXTREMUM_FIT: _EXTREMUM_FIT,
        at.STEP_FIT: _STEP_FIT,
        at.TABLE: _event_table(events).ravel(),
        at.TARGETS: targets,
        at.PENDING: np.zeros(at.ZERO_SIZE * at.ZEROS_PER_EVENT * m),
        at.LEAF: np.zeros(at.STEP_NODES * (m + 1)),
        at.STACK: np.zeros(2 * (at.DEEPEST + 2)),
        at.RECENT: np.zeros(at.MOST_RECENT * m),
        at.NUMBERS: numbers.values,
        at.VALUES: np.zeros(m),
        at.ACTIONS: numbers.actions,
        at.ACTED: np.zeros(targets.size + n),
        at.CLOSING: numbers.closing,
        at.BEFORE: np.zeros(n),
        at.AFTER: np.zeros(n),
        at.SCRATCH: np.zeros(3 * n),
        at.RATE: np.zeros(n),
    }
    block = np.concatenate([np.zeros(at.HEADER), *parts.values()])
    places = at.HEADER + np.cumsum([0, *(part.size for part in parts.values())])
    block[list(parts)] = places[:-1]
    block[[at.ACTIONS, at.CLOSING]] *= [numbers.actions.size > 0, numbers.closing.size > 0]
    block[[at.STATES, at.SPEEDS, at.EVENTS]] = n, numbers.speeds, m
    block[[at.ACTION_VALUES, at.NODE]] = targets.size + n, at.STEP_NODES
    return block


def with_cut_fit(block: Floats, rows: int) -> Floats:
    """Return a block that can cut steps whose polynomials have so many rows."""
    nodes, inverse = cut_matrix(rows)
    fit = [nodes, inverse.ravel(), np.zeros(rows * int(block[at.STATES]))]
    result = np.concatenate([block, *fit])
    result[at.CUT_FIT] = block.size
    return result


def event_rows(block: Floats) -> Floats:
    """Return the table of the events, a view (m, EVENT_SIZE)."""
    first, m = int(block[at.TABLE]), int(block[at.EVENTS])
    return block[first : first + m * at.EVENT_SIZE].reshape(m, at.EVENT_SIZE)


def _event_table(events: Sequence[WatchedEvent]) -> Floats:
    table = np.zeros((len(events), at.EVENT_SIZE))
    first = 0
    for row, event in zip(table, events, strict=True):
        row[[at.WAY, at.ACTION, at.WRAPS]] = event.direction, event.action, event.wraps
        row[at.OF_TIME] = event.of_time
        row[[at.SET_COUNT, at.SET_FIRST, at.LEVEL]] = len(event.targets), first, event.level
        row[at.MOST] = _MOST_RECORDED if event.action == at.RECORDS else _MOST_ACTING
        first += len(event.targets)
    return table
