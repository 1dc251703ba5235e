"""Events of a motion in a picture over time: thin lines, their names above the axes, none over another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.labels import plain, printed_length, readable

_MARK: Final = "symbody event"  # the id by which our marks are known
_ROWS: Final = 3  # of names above the axes
_SIZE: Final = 8.0  # points of their letters
_LETTER: Final = 0.6  # width of a letter, of its size
_LEGEND: Final = 0.8  # of the width of new axes is left beside a legend
_LONGEST: Final = 28  # letters
_MOST: Final = 200  # more lines would hide the curves
_COLOUR: Final = "0.55"


class EventLines(LineCollection):
    """Lines at events, which it keeps by time and the name that is shown."""

    events: tuple[tuple[float, str], ...] = ()


def mark_events(axes: Axes, panels: Iterable[Axes], run: Trajectory) -> None:
    """Mark the events of a motion in panels, with names above the first; those of earlier calls stay.

    Names are written from left to right, each in the lowest row that has room; where none has, and where
    the same name would follow itself, the line stands alone.
    """
    events = [(event.t, _shown(event.name, run)) for event in run.events]
    old = [artist for artist in axes.get_children() if artist.get_gid() == _MARK]
    for artist in old:
        events += artist.events if isinstance(artist, EventLines) else ()
        artist.remove()
    events = sorted(set(events))
    if not events:
        return
    for panel in {axes: None, **dict.fromkeys(panels)}:
        if panel is not axes:
            for artist in [each for each in panel.get_children() if each.get_gid() == _MARK]:
                artist.remove()
        _draw_lines(panel, events)
    rows = _write_names(axes, events)
    axes.set_title(axes.get_title(), pad=6.0 + rows * (_SIZE + 4.0))


def _draw_lines(axes: Axes, events: Sequence[tuple[float, str]]) -> None:
    times = list(dict.fromkeys(t for t, _ in events))[:_MOST]
    segments = [[(t, 0.0), (t, 1.0)] for t in times]
    lines = EventLines(
        segments, transform=axes.get_xaxis_transform(), colors=_COLOUR, linewidths=0.7, zorder=1.2
    )
    lines.set_gid(_MARK)
    lines.events = tuple(events)
    axes.add_collection(lines, autolim=False)


def _write_names(axes: Axes, events: Sequence[tuple[float, str]]) -> int:
    """Write the names that have room and return how many rows they take."""
    low, high = axes.get_xlim()
    points = axes.get_window_extent().width / axes.figure.dpi * 72.0
    if axes.get_legend() is not None:
        points *= _LEGEND
    ends = [-1.0] * _ROWS  # of the last name of each row, in shares of the width
    last = ""
    used = 0
    for t, name in events:
        place = (t - low) / (high - low)
        width = (printed_length(name) + 1) * _SIZE * _LETTER / points
        row = next((k for k, end in enumerate(ends) if place - width / 2.0 > end), None)
        if not 0.0 <= place <= 1.0 or row is None or name == last and place - width < max(ends):
            continue
        ends[row] = place + width / 2.0
        last = name
        used = max(used, row + 1)
        side = "left" if place < width / 2.0 else "right" if place > 1.0 - width / 2.0 else "center"
        _write(axes, t, row, name, side)
    return used


def _write(axes: Axes, t: float, row: int, text: str, side: str) -> None:
    note = axes.annotate(
        text,
        xy=(t, 1.0),
        xycoords=axes.get_xaxis_transform(),
        xytext=(0.0, 3.0 + row * (_SIZE + 3.0)),
        textcoords="offset points",
        ha=side,
        va="bottom",
        fontsize=_SIZE,
        color="0.35",
        annotation_clip=False,
    )
    note.set_gid(_MARK)


def _shown(name: str, run: Trajectory) -> str:
    """Return the name of an event as it is written: expressions as formulas, words as they are, all cut."""
    if len(name) > _LONGEST:
        return plain(f"{name[: _LONGEST - 1].rstrip()}\u2026")
    states = (*run.coordinate_names, *run.speed_names)
    is_word = name.replace(" ", "").isidentifier() and name not in states
    return plain(name) if is_word else readable(name, states)
