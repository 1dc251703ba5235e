"""The arrays of an `EventMonitor`."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.kernels.events.event_monitor import (
    EXTREMUM_NODES,
    RECORDS,
    STEP_NODES,
    SWITCHES,
    EventMonitor,
    MonitoredEvent,
)
from symbody.kernels.pack import pack
from symbody.simulation.inputs.steepness import DEGREE, chebyshev_nodes, to_coefficients
from symbody.simulation.native.dense_output import cut_matrix

Floats = NDArray[np.float64]

# So many events of one kind at one instant are one too many.
_MOST_ACTING: Final = 10
_MOST: Final = MappingProxyType({RECORDS: 100, SWITCHES: 50})


def _fit(degree: int, room: int) -> Floats:
    """Return nodes and matrix, and room behind them."""
    return np.concatenate([chebyshev_nodes(degree), to_coefficients(degree).ravel(), np.zeros(room)])


_EXTREMUM_FIT: Final = _fit(EXTREMUM_NODES - 1, 2 * EXTREMUM_NODES)
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
    """Return the array of an `EventMonitor` that has seen nothing; its span is still to be set."""
    m, targets = len(events), [float(place) for event in events for place in event.targets]
    return pack(
        EventMonitor,
        states=numbers.states, speeds=numbers.speeds, event_count=m,
        action_values=len(targets) + numbers.states, node=STEP_NODES,
        extremum_fit=_EXTREMUM_FIT, step_fit=_STEP_FIT, events=_event_table(events), targets=targets,
        leaf=np.zeros(STEP_NODES * (m + 1)),
        numbers=numbers.values, actions=numbers.actions, closing=numbers.closing,
    )  # fmt: skip


def with_cut_fit(block: Floats, rows: int) -> Floats:
    """Return the array of a monitor that can cut steps whose polynomials have so many rows."""
    nodes, inverse = cut_matrix(rows)
    monitor = EventMonitor(block)
    fit = [nodes, inverse.ravel(), np.zeros(rows * monitor.states)]
    result = np.concatenate([block, *fit])
    result[EventMonitor.fields["cut_fit"].place] = block.size
    return result


def _event_table(events: Sequence[WatchedEvent]) -> Floats:
    rows, first = list[Floats](), 0
    for event in events:
        rows.append(
            pack(
                MonitoredEvent, way=event.direction, action=event.action, wraps=event.wraps,
                of_time=event.of_time, set_count=len(event.targets), set_first=first, level=event.level,
                most=_MOST.get(event.action, _MOST_ACTING),
            )
        )  # fmt: skip
        first += len(event.targets)
    return np.array(rows)
