"""Events of a motion in a picture over time: thin lines, their names above the axes, none over another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.plotting.axis_labels import plain, printed_length, readable

_MARK: Final = "symbody event"  # the id by which our marks are known
_ROWS: Final = 3  # of names above the axes
_SIZE: Final = 8.0  # points of their letters
_LOW: Final = 1.4  # height of a row of words, of their size
_TALL: Final = 1.9  # and of formulas
_LETTER: Final = 0.6  # width of a letter, of its size
_LONGEST: Final = 28  # letters
_MOST: Final = 200  # more lines would hide the curves
_COLOUR: Final = "0.55"


class EventLines(LineCollection):
    """Lines at events, which it keeps by time and the name that is shown; above some of them names stand."""

    events: tuple[tuple[float, str], ...] = ()
    has_names: bool = False


def mark_events(axes: Axes, panels: Iterable[Axes], run: Trajectory) -> None:
    """Mark the events of a motion in panels, with names above the first; those of earlier calls stay.

    Names are written from left to right, each in the lowest row that has room; where none has, and where
    the same name would follow itself, the line stands alone.
    """
    events = [(event.t, _event_text(event.name, run)) for event in run.events]
    for lines in _lines_of(axes):
        events += lines.events
    events = sorted(set(events))
    if not events:
        return
    for panel in {axes: None, **dict.fromkeys(panels)}:
        for lines in _lines_of(panel):
            lines.remove()
        _draw_lines(panel, events, has_names=panel is axes)
    _write_all_names(axes.figure.axes)


def _lines_of(axes: Axes) -> list[EventLines]:
    return [each for each in axes.collections if isinstance(each, EventLines)]


def _draw_lines(axes: Axes, events: Sequence[tuple[float, str]], has_names: bool) -> None:
    times = list(dict.fromkeys(t for t, _ in events))[:_MOST]
    segments = [[(t, 0.0), (t, 1.0)] for t in times]
    lines = EventLines(
        segments, transform=axes.get_xaxis_transform(), colors=_COLOUR, linewidths=0.7, zorder=1.2
    )
    lines.events, lines.has_names = tuple(events), has_names
    axes.add_collection(lines, autolim=False)


def _write_all_names(every: Sequence[Axes]) -> None:
    """Write the names of all axes of a figure anew: what is added beside some leaves them less room."""
    named = [(axes, lines) for axes in every for lines in _lines_of(axes) if lines.has_names]
    for axes, _ in named:
        for text in [text for text in axes.texts if text.get_gid() == _MARK]:
            text.remove()
    named[0][0].figure.canvas.figure.draw_without_rendering()  # the layout gives axes their widths
    for axes, lines in named:
        step = _SIZE * (_TALL if any("$" in name for _, name in lines.events) else _LOW)
        rows = _write_names(axes, lines.events, step)
        axes.set_title(axes.get_title(), pad=6.0 + rows * step)


def _write_names(axes: Axes, events: Sequence[tuple[float, str]], step: float) -> int:
    """Write the names that have room and return how many rows they take."""
    low, high = axes.get_xlim()
    points = axes.get_window_extent().width / axes.figure.dpi * 72.0
    ends = [-1.0] * _ROWS  # of the last name of each row, in shares of the width
    last = ""
    used = 0
    for t, name in events:
        place = (t - low) / (high - low)
        width = (printed_length(name) + 1) * _SIZE * _LETTER / points
        start = max(0.0, min(place - width / 2.0, 1.0 - width))
        row = next((k for k, end in enumerate(ends) if start >= end), None)
        if not 0.0 <= place <= 1.0 or row is None or name == last and start < max(ends):
            continue
        ends[row] = start + width
        last = name
        used = max(used, row + 1)
        _write(axes, (start + width / 2.0, 3.0 + row * step), name)
    return used


def _write(axes: Axes, place: tuple[float, float], text: str) -> None:
    note = axes.annotate(
        text,
        xy=(place[0], 1.0),
        xycoords="axes fraction",
        xytext=(0.0, place[1]),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=_SIZE,
        color="0.35",
        annotation_clip=False,
    )
    note.set_gid(_MARK)


def _event_text(name: str, run: Trajectory) -> str:
    """Return the name of an event as it is written: expressions as formulas, words as they are, all cut."""
    states = (*run.coordinate_names, *run.speed_names, *run.signal_state_names)
    is_word = name.replace(" ", "").isidentifier() and name not in states
    text = plain(name) if is_word else readable(name, states)
    return text if printed_length(text) <= _LONGEST else plain(f"{name[: _LONGEST - 1].rstrip()}\u2026")
