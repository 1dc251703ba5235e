"""The pictures of a report: the mechanism, its linear graph, its motion; the same bytes each time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from symbody.analysis.state import State
from symbody.graph.spanning_tree import SpanningTree
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.report.document import PictureKind
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.film.save_animation import save_animation
from symbody.visual.plotting.plot import plot
from symbody.visual.viewer.still import run_of_state

_SIZE: Final = (960, 540)  # of the mechanism [px]
_INCH: Final = (7.0, 3.6)  # of other pictures
_MOST_LABELS: Final = 30  # more names would hide what they name; tables have them
_TREE_COLOR: Final = "#1f5f99"
_CHORD_COLOR: Final = "#b3541e"
# Parallel edges bend apart by this share of their length.
_BEND: Final = 0.18


def mechanism_picture(state: State, kind: PictureKind) -> bytes:
    """Return a picture of a configuration."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"picture.{kind}"
        with mpl.rc_context(_settings()):
            model: Model = state.eqs.model
            few = len(model.bodies) + len(model.joints) <= _MOST_LABELS
            save_animation(run_of_state(state), path, size=_SIZE, labels=few, progress=None)
        return path.read_bytes()


def graph_picture(tree: SpanningTree, kind: PictureKind) -> bytes:
    """Return a linear graph: branches solid, chords dashed, the ground a square."""
    branches = [branch.edge for branch in tree.branches]
    edges = [(edge, True) for edge in branches] + [(edge, False) for edge in tree.chords]
    names = dict.fromkeys([GROUND, *(name for edge, _ in edges for name in (edge.start, edge.end))])
    places = _levels(tree, names)
    figure, axes = _axes(1.0 + 0.8 * (1 + len({y for _, y in places.values()}) / 2))
    drawn: dict[frozenset[str], int] = {}
    for edge, is_branch in edges:
        ends = frozenset((edge.start, edge.end))
        bend = _bend(places, edge.start, edge.end, drawn.get(ends, 0))
        drawn[ends] = drawn.get(ends, 0) + 1
        _draw_edge(axes, places[edge.start], places[edge.end], bend, edge.name, is_branch)
    for name, (x, y) in places.items():
        box = {
            "boxstyle": "square" if name == GROUND else "round",
            "facecolor": "white",
            "edgecolor": "#333333",
        }
        axes.text(x, y, name, ha="center", va="center", fontsize=10, bbox=box, zorder=6)
    axes.set_axis_off()
    across, up = zip(*places.values(), strict=True)
    axes.set_xlim(min(across) - 0.5, max(across) + 0.5)
    axes.set_ylim(min(up) - 0.6, max(up) + 0.6)
    return _content(figure, kind)


def _levels(tree: SpanningTree, nodes: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Return a place for each body: to the right by its distance from the ground, siblings in a column."""
    depth = {GROUND: 0}
    for branch in tree.branches:
        depth[branch.child] = depth[branch.parent] + 1
    layers: dict[int, list[str]] = {}
    for name in nodes:
        layers.setdefault(depth.get(name, 0), []).append(name)
    return {
        name: (1.6 * level, (len(names) - 1) / 2 - k)
        for level, names in layers.items()
        for k, name in enumerate(names)
    }


def _bend(places: dict[str, tuple[float, float]], start: str, end: str, before: int) -> float:
    """Return how far an edge bends: aside of earlier ones, and of nodes in one line with its ends."""
    (x0, y0), (x1, y1) = places[start], places[end]
    skips = abs(x1 - x0) > 2.0 or (x0 == x1 and abs(y1 - y0) > 1.0)
    least = 0.35 if skips else 0.0
    return (least + _BEND * ((before + 1) // 2 + (before > 0))) * (1 if before % 2 == 0 else -1)


def _draw_edge(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], bend: float, name: str, is_branch: bool
) -> None:
    color = _TREE_COLOR if is_branch else _CHORD_COLOR
    axes.annotate(
        "", end, start,
        arrowprops={
            "arrowstyle": "-|>", "color": color, "linewidth": 1.8, "shrinkA": 22, "shrinkB": 22,
            "linestyle": "-" if is_branch else "--", "connectionstyle": f"arc3,rad={bend}",
        },
    )  # fmt: skip
    # the middle of the arc: a quadratic curve whose control point stands aside by `bend` of the chord
    x = (start[0] + end[0]) / 2 + bend / 2 * (end[1] - start[1])
    y = (start[1] + end[1]) / 2 - bend / 2 * (end[0] - start[0])
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    axes.text(x, y, name, color=color, ha="center", va="center", fontsize=9, bbox=box, zorder=5)


def motion_picture(run: Trajectory, curves: Sequence[str], kind: PictureKind) -> bytes:
    """Return curves over time, each unit in a panel of its own."""
    with mpl.rc_context(_settings()):
        axes = plot(run, *curves, panels=True)
        return _content(axes.figure.canvas.figure, kind)


def _axes(height: float) -> tuple[Canvas, Axes]:
    figure = Canvas(figsize=(_INCH[0], min(height, 9.0)))
    FigureCanvasAgg(figure)
    return figure, figure.add_axes((0.02, 0.02, 0.96, 0.96))


def _content(figure: Canvas, kind: PictureKind) -> bytes:
    stream = BytesIO()
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    with mpl.rc_context(_settings()):
        figure.savefig(stream, format=kind, metadata=metadata, dpi=144)
    return stream.getvalue()


def _settings() -> Any:
    """Return settings of matplotlib by which names inside a file do not change from run to run."""
    return {"svg.hashsalt": "symbody", "svg.fonttype": "path"}
