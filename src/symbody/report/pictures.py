"""The pictures of a report: the mechanism, its linear graph, its motion; the same bytes each time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from math import hypot
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from symbody.analysis.state import State
from symbody.graph.linear_graph import Edge
from symbody.graph.spanning_tree import SpanningTree
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.report.document import PictureKind
from symbody.report.tree_picture import CHORD_COLOR, TREE_COLOR, outline_figure
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.film.save_animation import save_animation
from symbody.visual.film.text_metrics import text_width
from symbody.visual.plotting.plot import plot
from symbody.visual.viewer.still import run_of_state

_SIZE: Final = (960, 540)  # of the mechanism [px]
_INCH: Final = (7.0, 3.6)  # of other pictures
_MOST_LABELS: Final = 30  # more names would hide what they name; tables have them
_COLUMN: Final = 1.6  # from one column of bodies to the next, as rows are 1 apart
_MOST_ROWS: Final = 8
_BODY_LETTERS: Final = 10.0  # [pt]
_JOINT_LETTERS: Final = 9.0
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
    if not _has_room(places, [edge.name for edge, _ in edges]):
        return _content(outline_figure(tree, tuple(names)), kind)
    figure, axes = _axes(1.0 + 0.8 * (1 + len({y for _, y in places.values()}) / 2))
    across, up = zip(*places.values(), strict=True)
    axes.set_xlim(min(across) - 0.5, max(across) + 0.5)
    axes.set_ylim(min(up) - 0.6, max(up) + 0.6)
    drawn: dict[frozenset[str], int] = {}
    for edge, is_branch in edges:
        ends = frozenset((edge.start, edge.end))
        bend = _bend(places, edge.start, edge.end, drawn.get(ends, 0))
        drawn[ends] = drawn.get(ends, 0) + 1
        _draw_edge(axes, edge, places, bend, is_branch)
    for name, (x, y) in places.items():
        box = {
            "boxstyle": "square" if name == GROUND else "round",
            "facecolor": "white",
            "edgecolor": "#333333",
        }
        axes.text(x, y, name, ha="center", va="center", fontsize=_BODY_LETTERS, bbox=box, zorder=6)
    axes.set_axis_off()
    return _content(figure, kind)


def _has_room(places: Mapping[str, tuple[float, float]], joints: Sequence[str]) -> bool:
    """Return whether names of bodies and joints fit between columns, and columns on the page."""
    across = [x for x, _ in places.values()]
    columns = Counter(across)
    step = 72 * _COLUMN * _INCH[0] / (max(across) + 1.0)  # points
    body = max(text_width(name, _BODY_LETTERS) for name in places)
    joint = max((text_width(name, _JOINT_LETTERS) for name in joints), default=0.0)
    return body + joint + 24.0 <= step and max(columns.values()) <= _MOST_ROWS


def _levels(tree: SpanningTree, nodes: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Return a place for each body: to the right by its distance from the ground, siblings in a column."""
    depth = {GROUND: 0}
    for branch in tree.branches:
        depth[branch.child] = depth[branch.parent] + 1
    layers: dict[int, list[str]] = {}
    for name in nodes:
        layers.setdefault(depth.get(name, 0), []).append(name)
    return {
        name: (_COLUMN * level, (len(names) - 1) / 2 - k)
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
    axes: Axes, edge: Edge, places: Mapping[str, tuple[float, float]], bend: float, is_branch: bool
) -> None:
    color = TREE_COLOR if is_branch else CHORD_COLOR
    start, end = places[edge.start], places[edge.end]
    along = axes.transData.transform(end) - axes.transData.transform(start)
    axes.annotate(
        "", end, start,
        arrowprops={
            "arrowstyle": "-|>", "color": color, "linewidth": 1.8, "linestyle": "-" if is_branch else "--",
            "connectionstyle": f"arc3,rad={bend}",
            "shrinkA": _way_out(edge.start, along), "shrinkB": _way_out(edge.end, along),
        },
    )  # fmt: skip
    # the middle of the arc: a quadratic curve whose control point stands aside by `bend` of the chord
    x = (start[0] + end[0]) / 2 + bend / 2 * (end[1] - start[1])
    y = (start[1] + end[1]) / 2 - bend / 2 * (end[0] - start[0])
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    axes.text(
        x, y, edge.name, color=color, ha="center", va="center", fontsize=_JOINT_LETTERS, bbox=box, zorder=5
    )


def _way_out(name: str, along: Sequence[float]) -> float:
    """Return how far it is from the middle of a body's box to just outside of it, in a direction [pt]."""
    half = text_width(name, _BODY_LETTERS) / 2 + 4.0, _BODY_LETTERS / 2 + 4.0
    length = hypot(*along)
    shares = [abs(step) / (length * extent) for step, extent in zip(along, half, strict=True) if length]
    return 1.0 / max(shares) + 2.0 if shares else half[0]


def motion_picture(run: Trajectory, curves: Sequence[str], kind: PictureKind) -> bytes:
    """Return curves over time, each unit in a panel of its own."""
    with mpl.rc_context(_settings()):
        axes = plot(run, *curves)
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
