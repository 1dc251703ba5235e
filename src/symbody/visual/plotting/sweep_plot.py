"""Pictures of a sweep: one output of all cases over time, a line a case, told apart by what varied."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from symbody.errors import Problem, UsageError
from symbody.simulation.sweeps.result import Sweep
from symbody.visual.plotting.axis_labels import readable
from symbody.visual.plotting.canvas import finish_axes, new_panels
from symbody.visual.plotting.curves import with_unit

Floats = NDArray[np.float64]

_MOST_NAMED: Final = 8  # cases that a legend names; more are coloured by a scale
_COLOURS: Final = "viridis"


def plot_sweep(
    sweep: Sweep, expressions: Sequence[object], ax: Axes | None = None, title: str | None = None
) -> Axes:
    """Draw outputs of all cases over time, each in a panel of its own, and return the uppermost axes.

    Up to eight cases are named by what varied; of more the colour is the value of what varied first, with a
    scale beside it. A case that ended early ends early here.

    Raises
    ------
    UsageError
        If an output is not one number, or there are several for the axes given.
    """
    chosen = [_name(item) for item in expressions or sweep.coordinate_names]
    if ax is not None and len(chosen) > 1:
        what = f"{len(chosen)} outputs need {len(chosen)} panels"
        raise UsageError(Problem("plot.sweep_axes", "ax", what, fix="name one output, or remove ax"))
    panels = list(new_panels(chosen).values()) if ax is None else [ax]
    for axes, name in zip(panels, chosen, strict=True):
        _draw_cases(axes, sweep, name)
        axes.set_ylabel(_label(sweep, name))
        axes.margins(x=0.0)
    panels[-1].set_xlabel("time [s]")
    if len(sweep) > _MOST_NAMED:
        _add_scale(panels, sweep)
    else:
        finish_axes(panels[0], title)
    if title is not None:
        panels[0].set_title(title)
    return panels[0]


def _name(item: object) -> str:
    if isinstance(item, str):
        return item
    what, fix = "paths of many cases are not drawn", "draw one case: sb.plot(sweep.trajectory(3), ...)"
    raise UsageError(Problem("plot.sweep_path", repr(item), what, fix=fix))


def _draw_cases(axes: Axes, sweep: Sweep, name: str) -> None:
    """Draw the cases one after the other.

    Raises
    ------
    UsageError
        If the output has several components.
    """
    values = sweep[name]
    if values.ndim == 1:  # what varied is the same at all times
        values = np.broadcast_to(values[:, np.newaxis], (len(sweep), sweep.t.size))
    if values.ndim != 2:
        what = f"{name!r} has {values.shape[1]} components"
        fix = f"name one of them, such as {f'{name} x'!r}"
        raise UsageError(Problem("plot.sweep_components", name, what, fix=fix))
    if len(sweep) <= _MOST_NAMED:
        for case, row in enumerate(values):
            axes.plot(sweep.t, row, label=_case_label(sweep, case), linewidth=1.6)
        return
    scale, first = _scale(sweep), next(iter(sweep.cases.values()), np.zeros(len(sweep)))
    for row, value in zip(values, first, strict=True):
        axes.plot(sweep.t, row, color=scale.to_rgba(value), linewidth=0.9, linestyle="-")


def _case_label(sweep: Sweep, case: int) -> str:
    states = sweep.state_names
    return ", ".join(f"{readable(name, states)} = {column[case]:.4g}" for name, column in sweep.cases.items())


def _label(sweep: Sweep, name: str) -> str:
    return with_unit(readable(name, sweep.state_names), sweep.units.get(name, ""))


def _scale(sweep: Sweep) -> ScalarMappable:
    """Return the colours of the values of what varied first."""
    values = next(iter(sweep.cases.values()), np.zeros(1))
    return ScalarMappable(Normalize(float(values.min()), float(values.max())), colormaps[_COLOURS])


def _add_scale(panels: Sequence[Axes], sweep: Sweep) -> None:
    """Put the colours of what varied first beside the panels."""
    if sweep.cases:
        bar = panels[0].figure.colorbar(_scale(sweep), ax=list(panels))
        bar.set_label(_label(sweep, next(iter(sweep.cases))))
