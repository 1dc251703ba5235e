"""What ``symbody check`` prints: the model, its trees, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.redundancy import redundancy
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, SymbodyError
from symbody.formats.native import to_data
from symbody.model.body import Body
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.model import Model


def summary(model: Model, eqs: EquationSet) -> list[str]:
    """Return what a model is, a line a fact."""
    valueless = [name for name, value in model.parameters.items() if value is None]
    points = [body.name for body in model.bodies if _is_point(model, body)]
    kinds = [_fact(f"{kind}s", _names(model.elements, kind)) for kind in ("spring", "force", "torque")]
    return [
        _fact("model", [model.name]),
        _fact("gravity", [component.text for component in model.gravity]),
        _fact("bodies", [body.name for body in model.bodies]),
        *([_fact("rotate without inertia, as point masses", points)] if points else []),
        *_joint_lines(model),
        *_constraint_lines(model, eqs),
        *(line for line in kinds if not line.endswith("none")),
        _fact("inputs", eqs.input_names),
        _fact("parameters", [f"{name} = {value.text}" for name, value in model.parameters.items() if value]),
        *([_fact("parameters without value", valueless)] if valueless else []),
        *_tree_lines(eqs),
        _fact("coordinates", eqs.coordinate_names),
        _fact("speeds", eqs.speed_names),
        _fact("constraints", _count_names(eqs.multiplier_names)),
        *_freedom_lines(eqs),
        *(f"note: {note}" for note in eqs.notes),
    ]


def _is_point(model: Model, body: Body) -> bool:
    """Return whether a body that may turn has mass and no inertia, which may have been forgotten."""
    joints = [joint for joint in model.joints if body.name in (joint.start.body, joint.end.body)]
    is_turned = all(joint.locked_rotations < 3 for joint in joints)
    return is_turned and body.mass.constant() != 0 and all(each.constant() == 0 for each in body.inertia)


def _fact(word: str, values: Iterable[str]) -> str:
    return f"{word}: {', '.join(values) or 'none'}"


def _names(elements: Iterable[Element], kind: str) -> list[str]:
    return [element.name for element in elements if element.kind == kind]


def _joint_lines(model: Model) -> list[str]:
    """Return the joints, one a line, in columns; free bodies have none."""
    types = {entry["name"]: entry["type"] for entry in to_data(model, is_alone=True).get("joint", [])}
    rows = [_joint_row(joint, types[joint.name]) for joint in model.joints]
    return ["joints:" if rows else "joints: none", *_columns(rows)]


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _constraint_lines(model: Model, eqs: EquationSet) -> list[str]:
    """Return the constraints beside the joints, one a line: what they connect, and what they hold."""
    entries = to_data(model, is_alone=True).get("constraint", [])
    rows = [row for row, _ in eqs.formed.rows_and_multipliers]
    lines = []
    for entry in entries:
        kinds = [row.is_holonomic for row in rows if row.element == entry["name"]]
        counts = [(kinds.count(True), "position"), (kinds.count(False), "velocity")]
        held = " and ".join(f"{count} in {word}" for count, word in counts if count)
        between = " -> ".join(entry.get("between", ())) or ", ".join(entry.get("coupled", ()))
        word = entry["type"].replace("_", " ")
        lines.append((entry["name"], word, between, f"holds {held or 'nothing that is not already held'}"))
    return ["constraints in addition to joints:", *_columns(lines)] if lines else []


def _joint_row(joint: Joint, word: str) -> tuple[str, str, str, str]:
    coordinates = [
        name if given else f"({name})"
        for name, given in zip(joint.coordinates, joint.given_names, strict=True)
    ]
    return joint.name, word.replace("_", " "), f"{joint.start} -> {joint.end}", ", ".join(coordinates)


def _tree_lines(eqs: EquationSet) -> list[str]:
    """Return both trees as one if they are the same, and the joints that are cut."""
    topology = eqs.formed.topology
    order = [joint.name for joint in topology.joints]
    turning, sliding = (
        [name for name in order if name in tree]
        for tree in (topology.rotation_branches, topology.translation_branches)
    )
    cut = [name for name in order if name not in turning and name not in sliding]
    if turning == sliding:
        trees = [_fact("rotation and translation tree", turning)]
    else:
        trees = [_fact("rotation tree", turning), _fact("translation tree", sliding)]
    return [*trees, _fact("cut joints", cut)]


def _count_names(names: tuple[str, ...]) -> list[str]:
    return [f"{len(names)} ({', '.join(names)})"] if names else []


def _freedom_lines(eqs: EquationSet) -> list[str]:
    """Return how many freedoms there are, and which constraints take none because others do so already."""
    try:
        count = redundancy(eqs) if eqs.multiplier_names else None
    except SymbodyError:  # the next count gives the reason, in words of the mechanism
        count = None
    if count is None:
        return [f"degrees of freedom: {_freedoms(eqs)}"]
    lines = [f"degrees of freedom: {count.degrees_of_freedom}"]
    if count.dropped:
        u, rows = len(eqs.speed_names), len(eqs.multiplier_names)
        lines += [
            _fact("redundant constraints", _count_names(count.dropped)),
            f"  they follow from the other {len(count.kept)}: {u} speeds less {rows} constraints would be "
            f"{u - rows} degrees of freedom, less {len(count.kept)} independent ones "
            f"{count.degrees_of_freedom}; how the joints share the loads in these directions is undetermined",
        ]
    return [*lines, *(f"  {note}" for note in count.notes)]


def _freedoms(eqs: EquationSet) -> str:
    """Return their number; loops without values of their lengths cannot be counted."""
    try:
        return str(eqs.degrees_of_freedom)
    except SymbodyError as error:
        return f"not counted, {error.problems[0].what}{_what_stays_open(eqs)}"


def _what_stays_open(eqs: EquationSet) -> str:
    """Return which joints keep loops from closing, and how far; nothing if that is not why."""
    try:
        assemble(eqs)
    except AssemblyError as error:
        return "".join(f"; {problem.what}" for problem in error.problems)
    except SymbodyError:
        return ""
    return ""
