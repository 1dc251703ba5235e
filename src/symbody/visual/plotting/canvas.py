"""How curves and paths are drawn: figures, panels, lines, labels and legends of matplotlib."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from symbody.visual.plotting.axis_labels import plain, printed_length, shown_unit
from symbody.visual.plotting.curves import PlanePath, PlottedCurve, shared_label, shared_quantity
from symbody.visual.plotting.picture_axes import axes_class

SIZE: Final = (7.0, 4.2)  # inches: a column of text, and a slide
SIZE_IN_SPACE: Final = (6.0, 5.2)
PANEL: Final = 1.8  # inches that each further panel adds
TALLEST: Final = 13.0  # inches; more panels share them
RESOLUTION: Final = 150  # dots per inch
# Entries of a legend that stand below each other in an inch, in two sizes of type.
_ROWS: Final = 16 / SIZE[1]
_ROWS_SMALL: Final = 23 / SIZE[1]
_LETTERS: Final = 10.5  # of a label, in an inch
_PANELS: Final = "symbody panels"  # the label, which is not drawn, of a figure whose axes are named by units

# The palette of Okabe and Ito, distinct to readers with any colour vision; yellow is too pale for lines.
COLOURS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: Final = ("-", "--", ":", "-.")


def new_axes(in_space: bool = False) -> Axes:
    """Return axes in a figure of their own, which belongs to no window and no global state."""
    figure = _new_figure(SIZE_IN_SPACE if in_space else SIZE)
    axes: Axes = figure.add_subplot(axes_class=axes_class(in_space))
    axes.set_prop_cycle(cycler(linestyle=DASHES) * cycler(color=COLOURS))
    if in_space:
        axes.locator_params(nbins=5)  # more run into each other
        axes.tick_params(labelsize=8)
    else:
        _style(axes)
    return axes


def new_panels(units: Sequence[str]) -> dict[str, Axes]:
    """Return an axes for each unit, below each other over one horizontal axis."""
    if len(units) == 1:
        return {units[0]: new_axes()}
    figure = _new_figure((SIZE[0], min(SIZE[1] + PANEL * (len(units) - 1), TALLEST)))
    figure.set_label(_PANELS)
    column = figure.subplots(len(units), 1, sharex=True, subplot_kw={"axes_class": axes_class()})
    for axes, unit in zip(column, units, strict=True):
        axes.set_label(unit)
        axes.set_prop_cycle(cycler(linestyle=DASHES) * cycler(color=COLOURS))
        _style(axes)
    return dict(zip(units, column, strict=True))


def panels_beside(axes: Axes) -> dict[str, Axes]:
    """Return the panels of the figure that holds axes, by their units; none if it has no panels of ours."""
    figure = axes.figure
    return {str(panel.get_label()): panel for panel in figure.axes} if figure.get_label() == _PANELS else {}


def _new_figure(size: tuple[float, float]) -> Figure:
    figure = Figure(figsize=size, dpi=RESOLUTION, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _style(axes: Axes) -> None:
    axes.grid(True, color="0.88", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def is_in_space(axes: Axes) -> bool:
    """Return whether axes are three."""
    return axes.name == "3d"


def draw(axes: Axes, curves: Sequence[PlottedCurve], label: str, marks_start: bool) -> None:
    """Draw the last curve over the others, with a dot at its start if that is asked for."""
    data = [curve.values for curve in curves]
    single = "o" if data[0].size == 1 else ""
    beside = sum(len(_curves_in(each)) for each in _axes_at_same_place(axes) if each is not axes)
    # None is the next colour of these axes; a twin begins where the other ends
    colour = f"C{(beside + len(_curves_in(axes))) % 10}" if beside else None
    (line,) = axes.plot(*data, label=label, linewidth=1.6, marker=single, color=colour)
    if marks_start and data[0].size > 1:
        start = [values[:1] for values in data]
        axes.plot(*start, "o", color=line.get_color(), markersize=4.5, label="_start")


def _axes_at_same_place(axes: Axes) -> list[Axes]:
    """Return all axes that fill the same place, as twins do, in the order in which they were made."""
    bounds = axes.get_position(original=True).bounds
    return [each for each in axes.figure.axes if each.get_position(original=True).bounds == bounds]


def _curves_in(axes: Axes) -> list[str]:
    return list(axes.get_legend_handles_labels()[1])


def label_curves(axes: Axes, across: PlottedCurve, title: str | None) -> None:
    """Label what the axes now hold, curves of earlier calls included."""
    axes.set_xlabel(across.text)
    labels = list(dict.fromkeys(_curves_in(axes)))
    axes.set_ylabel(labels[0] if len(labels) == 1 else shared_quantity(labels))
    finish_axes(axes, title)


def label_panels(panels: Sequence[Axes], across: PlottedCurve, title: str | None) -> None:
    """Label panels: what runs across at the lowest, the title over the highest, legends where needed."""
    letters = int(_LETTERS * _height(panels[0]))
    for axes in panels:
        _, labels = axes.get_legend_handles_labels()
        axes.set_ylabel(_wrap(shared_label(labels, letters), letters))
        finish_axes(axes, title if axes is panels[0] else None)
    panels[-1].set_xlabel(across.text)
    panels[0].figure.align_ylabels(panels)


def label_paths(axes: Axes, paths: Sequence[PlanePath], title: str | None) -> None:
    """Label the two or three axes with what the paths have in common along each."""
    for letter, curves in zip("xyz", zip(*(path.curves for path in paths), strict=True), strict=False):
        texts = list(dict.fromkeys(curve.text for curve in curves))
        axes.set(**{f"{letter}label": texts[0] if len(texts) == 1 else _shared_component(curves)})
    finish_axes(axes, title)


def _shared_component(curves: Sequence[PlottedCurve]) -> str:
    """Return ``"x [m]"`` for components x of several vectors, else what all measure."""
    ends = {curve.name[-1:] if curve.name[-2:-1] == " " else "" for curve in curves}
    units = {shown_unit(curve.shown_unit) for curve in curves}
    if len(ends) == len(units) == 1 and ends < {"x", "y", "z"}:
        unit = units.pop()
        return f"${ends.pop()}$" + (f" [{unit}]" if unit else "")
    return shared_quantity([curve.text for curve in curves])


def _wrap(text: str, letters: int) -> str:
    """Return text in lines of about so many letters; formulas between dollar signs are not broken."""
    lines = [""]
    for word in re.findall(r"(?:[^\s$]|\$[^$]*\$)+", text):
        if lines[-1] and printed_length(lines[-1]) + 1 + printed_length(word) > letters:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def finish_axes(axes: Axes, title: str | None) -> None:
    """Put the title over axes, and a legend of all that they and their twins hold beside them."""
    together = _axes_at_same_place(axes)
    for each in together:
        old = each.get_legend()
        if old is not None:
            old.remove()
    pairs = [pair for each in together for pair in zip(*each.get_legend_handles_labels(), strict=True)]
    lines, labels = [line for line, _ in pairs], [label for _, label in pairs]
    if len(lines) > 1:
        axes = together[-1]  # drawn over the others
        if len(together) > 1:
            axes.legend(lines, labels, loc="best")
        elif axes.figure.get_layout_engine() is None:  # nothing would make room outside
            axes.legend(lines, labels, loc="best")
        else:
            height = _height(axes)
            size = "x-small" if len(lines) > int(_ROWS * height) else "medium"
            columns = -(-len(lines) // max(1, int(_ROWS_SMALL * height)))
            corner = (1.0, 1.0)
            axes.legend(
                lines,
                labels,
                loc="upper left",
                bbox_to_anchor=corner,
                frameon=False,
                fontsize=size,
                ncols=columns,
            )
    if title is not None:
        axes.set_title(plain(title))


def _height(axes: Axes) -> float:
    """Return the inches that a row of the figure has for axes and what stands beside it."""
    place = axes.get_subplotspec()
    rows = 1 if place is None else place.get_gridspec().nrows
    return float(axes.figure.bbox.height) / axes.figure.dpi / rows
