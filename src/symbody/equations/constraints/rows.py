"""All constraints of a mechanism; those that hold identically are set apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from symbody.equations.constraints.closings import closing_rows, motion_rows
from symbody.equations.constraints.conditions import condition_rows
from symbody.equations.constraints.integrability import is_integrable
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.row import Row
from symbody.equations.kinematics.variables import Use
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.fingerprint import vanishing
from symbody.expr.graph import Graph, Kind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence, tree_size
from symbody.graph.topology import Topology

_SHORT: Final = 40
# Of the largest offset of a frame; sums of lengths typed with 17 digits are far below, gaps far above.
_ROUNDING: Final = 1e-14


class FormedRows(NamedTuple):
    """The constraints of a mechanism.

    Attributes
    ----------
    rows : list of Row
        Without those that hold identically, holonomic ones first.
    redundant : list of Row
        Those that hold identically, without slopes: nothing follows from them, but they bear loads.
    notes : tuple of str
    """

    rows: list[Row]
    redundant: list[Row]
    notes: tuple[str, ...]


def form_rows(topology: Topology, names: Names, kinematics: Kinematics, uses: Sequence[Use]) -> FormedRows:
    """Return the constraints of a mechanism.

    Raises
    ------
    FormulationError
        If a row is a constant other than zero, so that the loop can never close; if it depends on time
        alone; if an equation is not of first degree in the speeds.
    """
    rows = [
        row
        for use in uses
        for row in (*closing_rows(names, kinematics, use), *motion_rows(names, kinematics, use))
    ]
    for condition in topology.model.constraints:
        rows += condition_rows(names, kinematics, condition)
    rows.sort(key=lambda row: not row.is_holonomic)
    rounding = _ROUNDING * _size(topology)
    gone = [
        zero or _is_rounding(row, rounding)
        for row, zero in zip(rows, _holding(kinematics.graph, rows), strict=True)
    ]
    kept = [row for row, zero in zip(rows, gone, strict=True) if not zero]
    problems = list(_impossible(topology, kinematics.graph, kept, uses))
    if problems:
        raise FormulationError(*problems)
    lost = [row for row, zero in zip(rows, gone, strict=True) if zero]
    zero = Expr(kinematics.graph, 0)
    redundant = [replace(row, slopes={}, rest=zero, gamma=zero) for row in lost]
    return FormedRows(kept, redundant, (*_dropped(topology, lost), *_integrable(kinematics, kept)))


def _holding(graph: Graph, rows: Sequence[Row]) -> list[bool]:
    """Return which rows hold identically: by their value, or by all that makes up their rate."""
    parts = [[row.value] if row.is_holonomic else [row.rest, *row.slopes.values()] for row in rows]
    zero = iter(vanishing(graph, [x.index for group in parts for x in group]))
    return [all([next(zero) for _ in group]) for group in parts]


def _is_rounding(row: Row, rounding: float) -> bool:
    """Return whether a closing equation is a constant that is 0 but for the digits lengths are typed with."""
    number = row.value.number
    limit = _ROUNDING if row.force.is_zero else rounding
    return isinstance(number, float) and row.is_holonomic and abs(number) <= limit


def _size(topology: Topology) -> float:
    """Return the largest offset of a frame that is a number [m]."""
    model = topology.model
    frames = [*model.ground.values(), *(frame for body in model.bodies for frame in body.frames.values())]
    offsets = (x.constant() for frame in frames for x in frame.at)
    return max((abs(float(x)) for x in offsets if x is not None), default=0.0)


def _impossible(
    topology: Topology, graph: Graph, rows: Sequence[Row], uses: Sequence[Use]
) -> Iterator[Problem]:
    """Return a problem for each row that no motion fulfils.

    A constraint on parameters alone is left to those who know their values; see `check_idle`.
    """
    kinds = dependence(graph, [row.value.index for row in rows])
    driven = ", ".join(name for use in uses for name in use.prescribed)
    for row, is_idle in zip(rows, _idle(graph, rows), strict=True):
        where = f"{_kind(topology, row)} {row.element}"
        inside = kinds[row.value.index]
        if is_own(topology, row):
            if is_idle and not (row.is_holonomic and row.value.number is None and inside == {Kind.PARAMETER}):
                yield _unfulfilled(graph, row, where, driven)
        elif row.value.number is not None:
            yield _never_closed(row, where)
        elif Kind.TIME in inside and Kind.COORDINATE not in inside:
            yield Problem(
                "equations.over_driven", where,
                f"its closing equation {row.name} depends on time alone: every joint of its loop is driven",
                f"prescribed are {driven or 'none'}, more than the loop has freedoms",
                "let one of these coordinates free, or give it a drive instead of a motion",
            )  # fmt: skip


def _idle(graph: Graph, rows: Sequence[Row]) -> list[bool]:
    """Return which rows no speed is in: those whose slopes vanish identically."""
    zero = iter(vanishing(graph, [slope.index for row in rows for slope in row.slopes.values()]))
    return [all([next(zero) for _ in row.slopes]) for row in rows]


def _never_closed(row: Row, where: str) -> Problem:
    return Problem(
        "equations.never_closed", where,
        f"its closing equation {row.name} is the constant {row.value.number}, whatever the coordinates",
        "the frames it connects are apart in a direction in which nothing can move",
        "move the frames together, or let the loop move in this direction",
    )  # fmt: skip


def _unfulfilled(graph: Graph, row: Row, where: str, driven: str) -> Problem:
    """Return the problem of a constraint without any coordinate or speed that is not 0 = 0."""
    left = row.value if row.is_holonomic else row.rest
    number = left.number
    if number is None and tree_size(graph, left.index) > _SHORT:
        said = "without any coordinate or speed"
    else:
        said = f"{number if number is not None else to_text(graph, left.index)}, whatever moves"
    why = "what it holds does not move" + (f", or only as prescribed ({driven})" if driven else "")
    return Problem(
        "equations.never_closed", where, f"its equation {row.name} has the left-hand side {said}", why,
        "leave it out, or let what it holds move freely",
    )  # fmt: skip


def _dropped(topology: Topology, rows: Sequence[Row]) -> Iterator[str]:
    lost: dict[str, list[str]] = {}
    for row in rows:
        lost.setdefault(f"{_kind(topology, row)} {row.element}", []).append(row.name)
    for where, names in lost.items():
        count = "1 equation holds" if len(names) == 1 else f"{len(names)} equations hold"
        are = "is" if len(names) == 1 else "are"
        if where.startswith("joint"):
            count, are = f"{len(names)} closing equations hold", "are"
        yield f"{where}: {count} identically and {are} dropped ({', '.join(names)})"


def _integrable(kinematics: Kinematics, rows: Sequence[Row]) -> Iterator[str]:
    for row in rows:
        if not row.is_holonomic and is_integrable(kinematics, row):
            yield (
                f"constraint {row.element}: {row.name} constrains velocities, but it is the rate of a "
                "constraint on positions, which would keep them from drifting; write it in coordinates"
            )


def _kind(topology: Topology, row: Row) -> str:
    return "constraint" if is_own(topology, row) else "joint"


def is_own(topology: Topology, row: Row) -> bool:
    """Return whether a row belongs to a constraint beside the joints."""
    return any(part.name == row.element for part in topology.model.constraints)
