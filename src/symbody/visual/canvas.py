"""How curves and paths are drawn: figures, lines, labels and legends of matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from symbody.visual.curves import Curve, Path, shared_quantity

SIZE: Final = (7.0, 4.2)  # inches: a column of text, and a slide
SIZE_IN_SPACE: Final = (6.0, 5.2)
RESOLUTION: Final = 150  # dots per inch
# Entries of a legend that stand below each other in that height, in two sizes of type.
_ROWS: Final = 16
_ROWS_SMALL: Final = 23

# The palette of Okabe and Ito, told apart by readers with any colour vision; yellow is too pale for lines.
COLOURS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: Final = ("-", "--", ":", "-.")


def new_axes(in_space: bool = False) -> Axes:
    """Return axes in a figure of their own, which belongs to no window and no global state."""
    figure = Figure(figsize=SIZE_IN_SPACE if in_space else SIZE, dpi=RESOLUTION, layout="constrained")
    FigureCanvasAgg(figure)
    axes: Axes = figure.add_subplot(projection="3d" if in_space else None)
    axes.set_prop_cycle(cycler(linestyle=DASHES) * cycler(color=COLOURS))
    if in_space:
        axes.locator_params(nbins=5)  # more run into each other
        axes.tick_params(labelsize=8)
    else:
        axes.grid(True, color="0.88", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return axes


def is_in_space(axes: Axes) -> bool:
    """Return whether axes are three."""
    return axes.name == "3d"


def draw(axes: Axes, curves: Sequence[Curve], label: str, marks_start: bool) -> None:
    """Draw the last curve over the others, with a dot at its start if that is asked for."""
    data = [curve.values for curve in curves]
    single = "o" if data[0].size == 1 else ""
    (line,) = axes.plot(*data, label=_plain(label), linewidth=1.6, marker=single)
    if marks_start and data[0].size > 1:
        start = [values[:1] for values in data]
        axes.plot(*start, "o", color=line.get_color(), markersize=4.5, label="_start")


def label_curves(axes: Axes, across: Curve, title: str | None) -> None:
    """Label what the axes now hold, curves of earlier calls included."""
    axes.set_xlabel(_plain(across.text))
    lines, labels = axes.get_legend_handles_labels()
    axes.set_ylabel(labels[0] if len(lines) == 1 else _plain(shared_quantity(labels)))
    _finish(axes, title)


def label_paths(axes: Axes, paths: Sequence[Path], title: str | None) -> None:
    """Label the two or three axes with what the paths have in common along each."""
    for letter, curves in zip("xyz", zip(*(path.curves for path in paths), strict=True), strict=False):
        texts = list(dict.fromkeys(curve.text for curve in curves))
        common = texts[0] if len(texts) == 1 else _shared_component(texts)
        axes.set(**{f"{letter}label": _plain(common)})
    _finish(axes, title)


def _shared_component(texts: Sequence[str]) -> str:
    """Return ``"x [m]"`` for ``"r P x [m]"`` and ``"r Q x [m]"``, else what all measure."""
    ends = {text.partition(" [")[0][-2:] for text in texts}
    end = ends.pop().strip() if len(ends) == 1 else ""
    units = {text.partition(" [")[2] for text in texts}
    if end in ("x", "y", "z") and len(units) == 1:
        return f"{end} [{units.pop()}" if units != {""} else end
    return shared_quantity(texts)


def _finish(axes: Axes, title: str | None) -> None:
    lines, labels = axes.get_legend_handles_labels()
    if len(lines) > 1:
        if axes.figure.get_layout_engine() is None:  # nothing would make room outside
            axes.legend(lines, labels, loc="best")
        else:
            size = "x-small" if len(lines) > _ROWS else "medium"
            columns = -(-len(lines) // _ROWS_SMALL)
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
        axes.set_title(_plain(title))


def _plain(text: str) -> str:
    """Return text that matplotlib prints as it is, not as mathematics."""
    return text.replace("\\$", "$").replace("$", r"\$")
