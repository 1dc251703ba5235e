"""Curves of a motion: outputs over time, or over each other, drawn with matplotlib."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.simulation.trajectory import Trajectory

Floats = NDArray[np.float64]

SIZE: Final = (7.0, 4.2)  # inches: a column of text, and a slide
RESOLUTION: Final = 150  # dots per inch
SMOOTH: Final = 1000  # points a curve gets at least where the motion between its samples is known

# The palette of Okabe and Ito, told apart by readers with any colour vision; yellow is too pale for lines.
COLOURS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: Final = ("-", "--", ":", "-.")

# A unit at the end of a label; digits in brackets are the place of a component.
UNIT: Final = re.compile(r"\[([^\[\]\d][^\[\]]*)\]$")

# What a unit measures, for an axis that several curves share.
QUANTITIES: Final[Mapping[str, str]] = {
    "rad": "angle",
    "rad/s": "angular velocity",
    "rad/s^2": "angular acceleration",
    "m": "length",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "N": "force",
    "N m": "torque",
    "J": "energy",
    "W": "power",
}


def plot(
    run: Trajectory,
    *expressions: str,
    ax: Axes | None = None,
    x: str = "t",
    title: str | None = None,
    labels: Sequence[str] | None = None,
    equal: bool = False,
) -> Axes:
    """Draw outputs of a motion into one pair of axes and return it; nothing is shown.

    Parameters
    ----------
    *expressions : str
        Whatever ``run[...]`` knows; all coordinates if none is given. A vector makes three curves.
    ax : Axes, optional
        Where to draw, for instance from ``matplotlib.pyplot.subplots()`` to see a window. By default a new
        figure that belongs to no window: ``ax.figure``, or `save_plot`.
    x : str
        The output along the horizontal axis; with another than time the start is marked by a dot.
    labels : sequence of str, optional
        One for each curve, in place of the names.
    equal : bool
        Whether a unit is equally long on both axes.

    Raises
    ------
    UsageError
        An unknown name, a horizontal output with several components, or too few labels.
    """
    chosen = expressions or run.coordinate_names
    motion = run if run.stored.keys() & {x, *chosen} else _refined(run)
    curves = _named([curve for name in chosen for curve in _curves(motion, name)], labels)
    across = _across(motion, x)
    axes = _new_axes() if ax is None else ax
    for curve in curves:
        _draw(axes, across.values, curve, marks_start=x != "t")
    _write_labels(axes, across, title)
    if equal:
        axes.set_aspect("equal", adjustable="datalim")
    elif x == "t":
        axes.margins(x=0.0)
    return axes


def save_plot(ax: Axes, path: str | PathLike[str]) -> None:
    """Write the figure that holds `ax` to a file; the suffix chooses png, svg, pdf or another format.

    Raises
    ------
    UsageError
        A suffix that is no picture format.
    EnvironmentFault
        If the file cannot be written.
    """
    canvas = ax.figure.canvas
    suffix = Path(path).suffix.lstrip(".").lower()
    known = canvas.get_supported_filetypes()
    if suffix not in known:
        what = f"{suffix!r} is no picture format" if suffix else "the name has no suffix"
        fix = f"end the name with one of {', '.join(sorted(known))}"
        raise UsageError(Problem("plot.format", str(path), what, fix=fix))
    try:
        canvas.figure.savefig(path, format=suffix)
    except OSError as error:
        what = f"the picture cannot be written: {error.strerror}"
        fix = "choose a folder that exists and is yours"
        raise EnvironmentFault(Problem("plot.unwritable", str(path), what, fix=fix)) from error


@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """One line: a name, a unit that may be unknown, and one value a sample."""

    name: str
    unit: str
    values: Floats

    @property
    def text(self) -> str:
        return _with_unit(self.name, self.unit)


def _curves(run: Trajectory, expression: str) -> list[_Curve]:
    """Return the components of an output."""
    unit = run.units.get(expression, "")
    return [_Curve(name, unit, values) for name, values in run.columns(expression).items()]


def _named(curves: list[_Curve], labels: Sequence[str] | None) -> list[_Curve]:
    """Return the curves under the labels of the caller."""
    if labels is None:
        return curves
    if isinstance(labels, str) or len(labels) != len(curves):
        count = "one text" if isinstance(labels, str) else f"{len(labels)}"
        what = f"{len(curves)} curves need {len(curves)} labels, not {count}"
        fix = f"give a list of labels for {', '.join(curve.name for curve in curves)}, in this order"
        raise UsageError(Problem("plot.labels", "labels", what, fix=fix))
    return [replace(curve, name=label) for curve, label in zip(curves, labels, strict=True)]


def _across(run: Trajectory, x: str) -> _Curve:
    """Return what runs along the horizontal axis."""
    if x == "t":
        return _Curve("time", "s", np.atleast_1d(run.t))
    found = _curves(run, x)
    if len(found) > 1:
        names = ", ".join(repr(curve.name) for curve in found)
        fix = f"choose a component: x={names}"
        raise UsageError(Problem("plot.across", f"x={x!r}", f"{x!r} has {len(found)} components", fix=fix))
    return found[0]


def _refined(run: Trajectory) -> Trajectory:
    """Return the motion at enough times for a smooth line: steps of order 8 are long."""
    if run.dense_output is None or not 2 <= run.t.size < SMOOTH:
        return run
    pieces = max(4, math.ceil(SMOOTH / (run.t.size - 1)))
    shares = np.arange(pieces) / pieces
    inner = (run.t[:-1, np.newaxis] + np.diff(run.t)[:, np.newaxis] * shares).ravel()
    return run.at(np.append(inner, run.t[-1]))


def _new_axes() -> Axes:
    """Return axes in a figure of their own, which belongs to no window and no global state."""
    figure = Figure(figsize=SIZE, dpi=RESOLUTION, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_prop_cycle(cycler(linestyle=DASHES) * cycler(color=COLOURS))
    axes.grid(True, color="0.88", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def _draw(axes: Axes, across: Floats, curve: _Curve, marks_start: bool) -> None:
    single = "o" if across.size == 1 else ""
    (line,) = axes.plot(across, curve.values, label=_plain(curve.text), linewidth=1.6, marker=single)
    if marks_start and across.size > 1:
        axes.plot(across[0], curve.values[0], "o", color=line.get_color(), markersize=4.5, label="_start")


def _write_labels(axes: Axes, across: _Curve, title: str | None) -> None:
    """Label what the axes now hold, curves of earlier calls included."""
    axes.set_xlabel(_plain(across.text))
    lines, labels = axes.get_legend_handles_labels()
    if len(lines) == 1:
        axes.set_ylabel(labels[0])
    else:
        axes.set_ylabel(_shared_quantity(labels))
        if axes.figure.get_layout_engine() is None:  # nothing would make room outside
            axes.legend(lines, labels, loc="best")
        else:
            axes.legend(lines, labels, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    if title is not None:
        axes.set_title(_plain(title))


def _shared_quantity(labels: Sequence[str]) -> str:
    """Return what all labels measure, such as "angle [rad]", or nothing if that differs or is unknown."""
    units = {found[1] if (found := UNIT.search(label)) else "" for label in labels}
    unit = units.pop() if len(units) == 1 else ""
    return _plain(_with_unit(QUANTITIES.get(unit, ""), unit))


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]".lstrip() if unit else name


def _plain(text: str) -> str:
    """Return text that matplotlib prints as it is, not as mathematics."""
    return text.replace("$", r"\$")
