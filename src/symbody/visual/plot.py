"""Curves of a motion: outputs over time, or over each other, drawn with matplotlib."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np
from cycler import Cycler, cycler
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
    smooth = _refined(run)
    curves = smooth.columns(*(expressions or run.coordinate_names))
    across = _single(smooth, x)
    names = tuple(curves) if labels is None else tuple(labels)
    if len(names) != len(curves):
        what = f"{len(names)} labels for {len(curves)} curves"
        raise UsageError(Problem("plot.labels", "labels", what, fix=f"label {', '.join(curves)}, in this order"))
    axes = _new_axes() if ax is None else ax
    ...
