"""The first sections of a report: the mechanism, its linear graph, its parts, its coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.units import symbol_units
from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.body import Body
from symbody.model.declarations.declaration import Declared
from symbody.model.element import Element
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.report.document import (
    Block,
    Cell,
    Figure,
    FormulaList,
    Name,
    NameList,
    Notes,
    Paragraph,
    ReportSection,
    TextTable,
    Unit,
)
from symbody.report.pictures import graph_picture, mechanism_picture
from symbody.report.setting import Setting

_MOST_NAMES: Final = 12  # in a row of the summary
_EMPTY: Final[tuple[Cell, ...]] = ("", "none", NameList(()), Unit(""))


def mechanism_section(setting: Setting) -> ReportSection:
    """Return the picture of the mechanism and its size in numbers."""
    return ReportSection("mechanism", "The mechanism", tuple(_mechanism(setting)))


def _mechanism(setting: Setting) -> Iterator[Block]:
    eqs = setting.eqs
    model = eqs.model
    try:
        freedoms = _freedoms(eqs.degrees_of_freedom)
    except SymbodyError as error:
        freedoms = f"degrees of freedom that could not be counted ({error.problems[0].what})"
    yield Paragraph(f"{model.name[:1].upper()}{model.name[1:]} has {freedoms}.")
    yield TextTable(("what", "number", "names"), tuple(_summary(eqs)))
    state = setting.start
    if isinstance(state, str):
        yield Paragraph(f"No picture: {state}")
    else:
        caption = f"{model.name} at t = {state.t:g} s"
        yield Figure("mechanism", caption, lambda kind: mechanism_picture(state, kind))


def _summary(eqs: EquationSet) -> Iterator[tuple[Cell, ...]]:
    """Yield what the mechanism consists of: how many, and their names where these fit into a row."""
    model = eqs.model
    others = [each for each in model.elements if not isinstance(each, Body | Joint)]
    for word, listed in (("bodies", model.bodies), ("joints", model.joints), ("other elements", others)):
        if listed:
            named = ", ".join(each.name for each in listed) if len(listed) <= _MOST_NAMES else ""
            yield word, str(len(listed)), named
    names = {"coordinates": eqs.coordinate_names, "speeds": eqs.speed_names,
             "multipliers": eqs.multiplier_names, "inputs": eqs.input_names}  # fmt: skip
    for word, symbols in names.items():
        if symbols:
            yield word, str(len(symbols)), NameList(symbols if len(symbols) <= _MOST_NAMES else ())


def _freedoms(count: int) -> str:
    return f"{count} degree{'' if count == 1 else 's'} of freedom"


def graph_section(setting: Setting) -> ReportSection:
    """Return the linear graph with both trees."""
    topology = setting.eqs.formed.topology
    blocks: list[Block] = [
        Paragraph(
            "Bodies are nodes, joints are edges. Coordinates are those of the joints in the trees; a joint "
            "outside both is cut, and the directions it locks become constraints."
        )
    ]
    trees = (topology.rotation, topology.translation)
    same = [{branch.edge.name for branch in tree.branches} for tree in trees]
    shown = (
        [("tree", trees[0])] if same[0] == same[1] else [("rotation", trees[0]), ("translation", trees[1])]
    )
    for word, tree in shown:
        kind = "both trees" if word == "tree" else f"the tree of {word}s"
        caption = f"Linear graph: {kind} solid, cut joints dashed" if tree.chords else "Linear graph, a tree"
        blocks.append(Figure(f"graph-{word}", caption, partial(graph_picture, tree)))
    if any(tree.chords for tree in trees):
        rows: list[tuple[Cell, ...]] = [
            (joint.name, *("branch" if joint.name in names else "cut" for names in same))
            for joint in topology.joints
        ]
        blocks.append(TextTable(("joint", "tree of rotations", "tree of translations"), tuple(rows)))
    blocks.append(Notes(topology.notes))
    return ReportSection("graph", "Linear graph and trees", blocks)


def parts_section(setting: Setting) -> ReportSection:
    """Return bodies, joints, other elements."""
    model, topology = setting.eqs.model, setting.eqs.formed.topology
    branches = {
        each.edge.name for tree in (topology.rotation, topology.translation) for each in tree.branches
    }
    joints = [
        (
            joint.name,
            type(joint).__name__,
            f"{joint.start} \u2192 {joint.end}",
            NameList(joint.coordinates if joint.name in branches else ()),
            _law(joint),
        )
        for joint in topology.joints
    ]
    others = [
        (element.name, type(element).__name__, _ends(element), _law(element))
        for element in model.elements
        if not isinstance(element, Body | Joint)
    ]
    frames = [*_frame_rows(model.ground, "ground")]
    frames += [row for body in model.bodies for row in _frame_rows(body.frames, body.name)]
    return ReportSection(
        "parts", "Bodies and joints",
        (
            TextTable(
                ("body", "mass [kg]", "inertia [kg\u00b7m\u00b2]"), tuple(map(_body_row, model.bodies))
            ),
            _table(("frame", "origin [m]", "rotated about"), tuple(frames)),
            _table(("joint", "kind", "from \u2192 to", "coordinates", "more"), tuple(joints)),
            _table(("element", "kind", "from \u2192 to", "arguments"), tuple(others)),
        ),
    )  # fmt: skip


def _table(heading: tuple[str, ...], rows: tuple[tuple[Cell, ...], ...]) -> TextTable:
    """Return a table without the columns that have no entries."""
    columns = [k for k in range(len(heading)) if any(row[k] not in _EMPTY for row in rows)]
    return TextTable(
        tuple(heading[k] for k in columns), tuple(tuple(row[k] for k in columns) for row in rows)
    )


def _ends(element: Element) -> str:
    ends = [getattr(element, word, "") for word in ("start", "end")]
    return " \u2192 ".join(end for end in ends if isinstance(end, str) and end)


def _body_row(body: Body) -> tuple[Cell, ...]:
    return (body.name, body.mass, _components(body.given_arguments().get("inertia", "none")))


def _frame_rows(frames: Mapping[str, Frame], body: str) -> Iterator[tuple[Cell, ...]]:
    for name, frame in frames.items():
        turns = ", ".join(f"{axis} by {_plain(angle)}" for axis, angle in frame.rotate)
        yield (f"{body}.{name}", _components(frame.at), turns or "none")


def _components(value: object) -> Cell:
    """Return components of a vector as formulas, all else as text."""
    if isinstance(value, tuple | list) and all(isinstance(x, Formula | str | int | float) for x in value):
        return FormulaList(tuple(x if isinstance(x, Formula) else str(x) for x in value))
    return _plain(value)


def _law(element: Element) -> str:
    skipped = ("name", "start", "end", "folder", "coordinate", "coordinates", "frames", "shape", "color")
    words = {word: value for word, value in element.given_arguments().items() if word not in skipped}
    return "; ".join(f"{word} = {_plain(value)}" for word, value in words.items())


def _plain(value: object) -> str:
    if isinstance(value, Formula):
        return value.text
    if isinstance(value, Declared):
        given = value.given_arguments().items()
        return f"{{{', '.join(f'{word} = {_plain(entry)}' for word, entry in given)}}}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_plain, value))})"
    if isinstance(value, Mapping):
        return ", ".join(f"{word}: {_plain(entry)}" for word, entry in value.items())
    return str(value)


def parameters_section(setting: Setting) -> ReportSection:
    """Return parameters, inputs and initial values with their units."""
    model = setting.eqs.model
    units = symbol_units(model)
    rows: list[tuple[Cell, ...]] = []
    for name, value in model.parameters.items():
        given = setting.parameters.get(name)
        shown: Cell = (
            "no value" if value is None and given is None else given if given is not None else value or ""
        )
        rows.append((Name(name), shown, Unit(units.get(name, ""))))
    inputs: list[tuple[Cell, ...]] = [
        (Name(name), Unit(units.get(name, ""))) for name in setting.eqs.input_names
    ]
    return ReportSection(
        "parameters", "Parameters and inputs",
        (_table(("parameter", "value", "unit"), tuple(rows)), _table(("input", "unit"), tuple(inputs))),
    )  # fmt: skip


def coordinates_section(setting: Setting) -> ReportSection:
    """Return coordinates and speeds, and why they are these."""
    eqs: EquationSet = setting.eqs
    units = eqs.units
    places = {name: joint for joint in eqs.formed.topology.joints for name in joint.coordinates}
    rows: list[tuple[Cell, ...]] = []
    for name in eqs.coordinate_names:
        joint = places.get(name)
        where = f"{type(joint).__name__} {joint.name}" if joint is not None else "in addition to joints"
        rows.append((Name(name), Unit(units.get(name, "")), where))
    speeds: list[tuple[Cell, ...]] = [(Name(name), Unit(units.get(name, ""))) for name in eqs.speed_names]
    states: list[tuple[Cell, ...]] = [(Name(name), "a signal") for name in eqs.signal_state_names]
    return ReportSection(
        "coordinates", "Coordinates and speeds",
        (
            _table(("coordinate", "unit", "of"), tuple(rows)),
            TextTable(("speed", "unit"), tuple(speeds)),
            TextTable(("state", "of"), tuple(states)),
            Notes(tuple(note for note in eqs.notes if note not in eqs.formed.topology.notes)),
        ),
    )  # fmt: skip
