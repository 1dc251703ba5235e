"""A drawing on axes of matplotlib: for figures of one's own, and for PDF."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from symbody.visual.film.drawing import Caption, Drawing, Filled, Stroke
from symbody.visual.film.facets import Floats
from symbody.visual.film.files.raster import DASHES
from symbody.visual.film.surfaces.polylines import join_lines
from symbody.visual.film.surfaces.regions import Region, trace_regions

_SIDES: Final = {"start": "left", "middle": "center", "end": "right"}
_RIM: Final = 0.35  # points: regions overlap a little, so that nothing shines between them


def figure_of(drawing: Drawing) -> Figure:
    """Return a figure of the drawing's size that shows it and nothing else."""
    figure = Figure(figsize=(drawing.size[0] / 72, drawing.size[1] / 72), facecolor=drawing.background)
    FigureCanvasAgg(figure)
    draw_on_axes(figure.add_axes((0.0, 0.0, 1.0, 1.0)), drawing)
    return figure


def draw_on_axes(axes: Axes, drawing: Drawing) -> None:
    """Draw on axes, whose units become points of 1/72 inch from the upper left corner; they are hidden."""
    width, height = drawing.size
    axes.set(xlim=(0.0, width), ylim=(height, 0.0), aspect="equal")
    axes.set_axis_off()
    per_point = drawing.samples.shape[1] / width
    for region in trace_regions(drawing.samples, drawing.background):
        patch = PathPatch(
            _path(region, per_point), facecolor=region.color, edgecolor=region.color, linewidth=_RIM
        )
        axes.add_patch(patch)
    for order, mark in enumerate(drawing.marks, start=2):
        if isinstance(mark, Stroke):
            dashes = (0.0, DASHES) if mark.dashed else "solid"
            lines = LineCollection(
                list(join_lines(mark.lines)), colors=mark.color, linewidths=mark.width, alpha=mark.opacity,
                linestyles=[dashes], capstyle="round", joinstyle="round", zorder=order,
            )  # fmt: skip
            axes.add_collection(lines, autolim=False)
        elif isinstance(mark, Filled):
            axes.add_patch(Polygon(mark.corners, facecolor=mark.color, edgecolor="none", zorder=order))
        else:
            _write(axes, mark, order)


def _write(axes: Axes, words: Caption, order: int) -> None:
    text = axes.text(
        *words.at, words.text.replace("$", r"\$"), fontsize=words.size, color=words.color,
        ha=_SIDES[words.side], va="baseline", weight="bold" if words.bold else "normal", zorder=order,
    )  # fmt: skip
    if words.halo:
        text.set_path_effects([withStroke(linewidth=0.28 * words.size, foreground=words.halo)])


def _path(region: Region, per_point: float) -> Path:
    return Path.make_compound_path(*(_ring(ring / per_point) for ring in region.rings))


def _ring(corners: Floats) -> Path:
    codes = np.full(len(corners) + 1, Path.LINETO, dtype=np.uint8)
    codes[0], codes[-1] = Path.MOVETO, Path.CLOSEPOLY
    return Path(np.concatenate([corners, corners[:1]]), codes)
