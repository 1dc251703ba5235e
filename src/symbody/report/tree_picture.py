"""Linear graphs with many or long names as outlines: a body a row, the joint that carries it beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import FancyArrowPatch

from symbody.graph.linear_graph import Edge
from symbody.graph.spanning_tree import SpanningTree, TreeBranch
from symbody.model.naming import GROUND
from symbody.visual.film.text_metrics import text_width

TREE_COLOR: Final = "#1f5f99"
CHORD_COLOR: Final = "#b3541e"
_SIZE: Final = 8.5  # of letters [pt]
_ROW: Final = 21.0  # from row to row [pt]
_INDENT: Final = 18.0  # of each body where branches part [pt]
_BOX: Final = 6.5  # half of the height of a box [pt]
_MARGIN: Final = 10.0  # [pt]
_LANE: Final = 16.0  # between cut joints that stand side by side [pt]


@dataclass(frozen=True, slots=True)
class _Place:
    """A body of an outline: its row, its indentation, and the widths of its name and its joint's [pt]."""

    row: int
    indent: int
    width: float
    joint_width: float

    @property
    def start(self) -> float:
        """Where its box begins [pt]."""
        return _MARGIN + _INDENT * self.indent

    @property
    def end(self) -> float:
        """Where its row ends [pt]."""
        return self.start + self.width + 12.0 + (self.joint_width + 10.0 if self.joint_width else 0.0)

    @property
    def height(self) -> float:
        """Of its middle below the upper end of the picture [pt]."""
        return _MARGIN + _BOX + _ROW * self.row


def outline_figure(tree: SpanningTree, nodes: Sequence[str]) -> Canvas:
    """Return an outline of a linear graph: branches from row to row, cut joints dashed on the right.

    Parameters
    ----------
    nodes : sequence of str
        Names of bodies, the ground among them; those without a branch stand below all others.
    """
    branches = {branch.child: branch for branch in tree.branches}
    places = _places(branches, nodes)
    lanes = _LANE * len(tree.chords) + max((text_width(e.name, _SIZE) for e in tree.chords), default=0.0)
    reach = max(place.end for place in places.values())
    width = reach + lanes + 2 * _MARGIN
    height = max(place.height for place in places.values()) + _BOX + _MARGIN
    figure = Canvas(figsize=(width / 72, height / 72))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(height, 0.0)
    for name, place in places.items():
        _draw_body(axes, name, place)
        if name in branches:
            _draw_branch(axes, branches[name], places[branches[name].parent], place)
    for k, edge in enumerate(tree.chords):
        _draw_chord(axes, edge, places, reach + _LANE * (k + 1))
    return figure


def _places(branches: Mapping[str, TreeBranch], nodes: Sequence[str]) -> dict[str, _Place]:
    """Return where bodies stand, depth first; an only child stands below its parent."""
    children: dict[str, list[str]] = {name: [] for name in nodes}
    for child, branch in branches.items():
        children[branch.parent].append(child)
    places: dict[str, _Place] = {}
    waiting = [(name, 0) for name in reversed(nodes) if name not in branches]
    while waiting:
        name, indent = waiting.pop()
        joint = branches[name].edge.name if name in branches else ""
        widths = text_width(name, _SIZE), text_width(joint, _SIZE) if joint else 0.0
        places[name] = _Place(len(places), indent, *widths)
        deeper = indent + (len(children[name]) > 1)
        waiting += [(child, deeper) for child in reversed(children[name])]
    return places


def _draw_body(axes: Axes, name: str, place: _Place) -> None:
    style = "square,pad=0.25" if name == GROUND else "round,pad=0.25"
    box = {"boxstyle": style, "facecolor": "white", "edgecolor": "#333333", "linewidth": 0.9}
    axes.text(place.start + 6.0, place.height, name, va="center_baseline", fontsize=_SIZE, bbox=box, zorder=6)


def _draw_branch(axes: Axes, branch: TreeBranch, parent: _Place, child: _Place) -> None:
    x = child.start + child.width + 20.0
    axes.text(x, child.height, branch.edge.name, color=TREE_COLOR, va="center_baseline", fontsize=_SIZE)
    start = (parent.start + 8.0, parent.height + _BOX)
    if child.indent == parent.indent:
        end = (start[0], child.height - _BOX)
    else:
        corner = (start[0], child.height)
        axes.plot(*zip(start, corner, strict=True), color=TREE_COLOR, linewidth=1.4, zorder=1)
        start, end = corner, (child.start + 1.0, child.height)
    _draw_arrow(axes, start, end) if branch.forward else _draw_arrow(axes, end, start)


def _draw_arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.add_patch(
        FancyArrowPatch(
            start, end, arrowstyle="-|>", mutation_scale=7.0, shrinkA=0, shrinkB=0, linewidth=1.4,
            color=TREE_COLOR, zorder=2,
        )
    )  # fmt: skip


def _draw_chord(axes: Axes, edge: Edge, places: Mapping[str, _Place], lane: float) -> None:
    """Draw a cut joint as a bracket between the rows of its bodies."""
    start, end = places[edge.start], places[edge.end]
    corners = ((start.end, start.height), (lane, start.height), (lane, end.height), (end.end, end.height))
    axes.plot(
        *zip(*corners, strict=True), color=CHORD_COLOR, linewidth=1.4, linestyle="--", zorder=1,
        marker="o", markevery=[0, 3], markersize=3.0,
    )  # fmt: skip
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    x, y = lane + 3.0, (start.height + end.height) / 2
    axes.text(x, y, edge.name, color=CHORD_COLOR, va="center", fontsize=_SIZE, bbox=box, zorder=5)
