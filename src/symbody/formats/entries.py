"""Tables of the model file to elements and back; the file's words are those of the constructors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Final, TypeVar

from symbody.errors import FormatError, ModelError, Problem, SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.body import Body, Frames
from symbody.model.declarations.declaration import Declared, Field
from symbody.model.declarations.joint_fields import CoordinateDrive, CoordinateDrives, DryFriction
from symbody.model.element import Element, FrameRef
from symbody.model.frame import Frame
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joint import InTrees, Joint
from symbody.model.loads.curve import Curve
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.registry import TYPED, element_type, shape_types, snake_case, type_word
from symbody.model.shapes.mesh import Mesh
from symbody.model.shapes.shape import BodyShape, Shapes
from symbody.model.tables.lookup import Lookup

T = TypeVar("T")

# What a model file consists of; formulas become text or numbers when it is written.
Node = Formula | str | bool | int | list["Node"] | dict[str, "Node"]

# Written even where they have their default: a reader looks for them, or other defaults depend on them.
_ALWAYS: Final = frozenset({"angles", "axes", "axis"})


def read_element(kind: str, entry: Mapping[str, object], folder: str = "") -> Element:
    """Return the element of a table that fits the schema; paths of meshes start from `folder`.

    Raises
    ------
    ModelError
        With everything in it that is not a name, a place or a formula.
    """
    arguments = dict(entry)
    if kind == Lookup.kind:
        arguments["folder"] = folder
    element_class = element_type(kind, str(arguments.pop("type", "")))
    make: Callable[..., Element] = element_class
    between = arguments.pop("between", None)
    if isinstance(between, list):
        arguments["start"], arguments["end"] = between
    problems: list[Problem] = []
    label = f"{kind} {entry['name']}"
    for name, field in element_class.fields.items():
        key = field.place or name
        if key in arguments:
            arguments[name] = _value(field, arguments.pop(key), f"{label}, {key}", folder, problems)
    element = _attempt(lambda: make(**arguments), problems)
    if element is None or problems:
        raise ModelError(*problems)
    return element


def _value(field: Field[Any, Any], entry: object, where: str, folder: str, problems: list[Problem]) -> object:
    """Return an argument from its entry: parts of elements are tables there."""
    if isinstance(field, Frames):
        return _frames(entry, where, problems)
    if isinstance(field, Shapes):
        return shapes_from_entries(entry, where, folder, problems)
    if isinstance(field, CoordinateDrive | CoordinateDrives):
        return _drives(entry, where, problems)
    return _read_part(Friction, entry, where, problems) if isinstance(field, DryFriction) else entry


def ground_frames(entry: object, problems: list[Problem]) -> dict[str, Frame]:
    """Return the frames of the ground; faults are added to `problems`."""
    return _frames(entry, "model, ground.frames", problems)


def shapes_from_entries(entries: object, where: str, folder: str, problems: list[Problem]) -> list[BodyShape]:
    """Return the shapes of a list of tables; faults are added to `problems`."""
    shapes = []
    for k, entry in enumerate(entries if isinstance(entries, list) else []):
        arguments = dict(entry)
        make: Callable[..., BodyShape] = shape_types()[arguments.pop("type")]
        if make is Mesh:
            arguments["folder"] = folder
        shape = _read_part(make, arguments, f"{where}[{k}]", problems)
        shapes += [] if shape is None else [shape]
    return shapes


def shape_entries(shapes: Iterable[BodyShape], folder: str | None = None) -> list[Node]:
    """Return the tables of shapes, without what has its default.

    Parameters
    ----------
    folder : str, optional
        Where the file stands: paths of meshes lead from there; None leaves them as they are.
    """
    entries: list[Node] = []
    for shape in shapes:
        values = _values(shape)
        plain = type(shape)(**{name: getattr(shape, name) for name in _required_arguments(shape)})
        entry: dict[str, Node] = {"type": snake_case(type(shape).__name__)}
        for name, value in values.items():
            if value is not None and (name in _required_arguments(shape) or value != getattr(plain, name)):
                entry[name] = write_node(value)
        if isinstance(shape, Mesh):
            entry["path"] = shape.path if folder is None else shape.path_from(folder)
            if "scale" in entry and len(set(shape.scale)) == 1:
                entry["scale"] = shape.scale[0]
        entries.append(entry)
    return entries


def write_element(element: Element, folder: str | None = None, *, is_alone: bool = False) -> dict[str, Node]:
    """Return the table of an element, without what has its default; `folder` as in `shape_entries`.

    Where the text `is_alone`, points of files stand in it.
    """
    if isinstance(element, Lookup):
        return table_entry(element, folder, is_alone=is_alone)
    entry: dict[str, Node] = {"name": element.name}
    if element.kind in TYPED:
        entry["type"] = type_word(type(element))
    values = _values(element)
    shapes = values.pop("shapes", ())
    if "start" in values:
        entry["between"] = [write_node(values.pop("start")), write_node(values.pop("end"))]
    given = [*_required_arguments(element), *(_ALWAYS & set(values))]
    fields = element.fields
    defaults = {name: fields[name].default_value(element, name) for name in fields if name not in given}
    for name, value in values.items():
        if name not in entry and value is not None and (name not in defaults or value != defaults[name]):
            entry[name] = write_node(_alone(element, value))
    if isinstance(element, Body) and shapes:
        entry["shape"] = shape_entries(element.shapes, folder)
    return entry


def table_entry(table: Lookup, folder: str | None, *, is_alone: bool) -> dict[str, Node]:
    """Return the table of a function by points.

    Raises
    ------
    FormatError
        If its file lies outside of the folder.
    """
    values = {name: value for name, value in table.given_arguments().items() if name != "folder"}
    if is_alone and table.file:
        values = {name: value for name, value in values.items() if name not in ("file", "columns", "units")}
        values["points"] = table.points
    elif table.file and folder is not None:
        values["file"] = table.path_from(folder)
        if values["file"].startswith(".."):
            raise FormatError(
                Problem("file.outside", f"table {table.name}, file",
                        f"{table.file!r} is outside the folder in which the model is saved",
                        "a model file may only refer to files in its own folder",
                        "copy the file into the folder first, or save the model next to the file")
            )  # fmt: skip
    return {name: write_node(value) for name, value in values.items()}


def write_node(value: object) -> Node:
    """Return a value of the model as part of a file."""
    if isinstance(value, Formula | str | bool | int):
        return value
    if isinstance(value, float):
        return Formula.from_value(value)
    if isinstance(value, FrameRef):
        return value.full_name
    if isinstance(value, FrozenMapping):
        return {name: write_node(item) for name, item in value.items()}
    if isinstance(value, tuple):
        return [write_node(item) for item in value]
    if isinstance(value, InTrees) and value.rotation is not None and value.rotation == value.translation:
        return value.rotation
    values = _values(value)
    if isinstance(value, Curve):
        plain = {"kind": "linear", "outside": "hold"}
        return {name: write_node(item) for name, item in values.items() if item != plain.get(name)}
    empty = {InTrees: InTrees, Drive: Drive, Frame: Frame, Friction: Friction}[type(value)]()
    defaults = _values(empty)
    return {name: write_node(item) for name, item in values.items() if item != defaults[name]}


def _values(value: object) -> dict[str, object]:
    """Return the content of an element or of a part of one, in the order of its constructor."""
    if isinstance(value, Declared):
        return {name: getattr(value, name) for name, field in value.fields.items() if field.is_content}
    return {field.name: getattr(value, field.name) for field in fields(value)} if is_dataclass(value) else {}


def _alone(element: Element, value: object) -> object:
    """Return the value for the only coordinate of a joint; all of them, by name, where there are several."""
    if isinstance(value, FrozenMapping) and isinstance(element, Joint) and len(element.coordinates) == 1:
        return next(iter(value.values()))
    return value


def _required_arguments(value: Declared) -> list[str]:
    """Return the arguments without default of a constructor."""
    return [name for name, field in value.fields.items() if field.is_required]


def _drives(entry: object, where: str, problems: list[Problem]) -> object:
    """Return the drive of a table, or those of a table of tables by coordinate."""
    law = entry.get("law") if isinstance(entry, Mapping) else None
    is_curve = isinstance(law, Mapping) and "x" in law  # and not the drive of a coordinate called law
    keyed = isinstance(entry, Mapping) and entry and all(isinstance(item, Mapping) for item in entry.values())
    if isinstance(entry, Mapping) and keyed and not is_curve:
        return {name: _read_part(Drive, item, f"{where}.{name}", problems) for name, item in entry.items()}
    return _read_part(Drive, entry, where, problems)


def _frames(entries: object, where: str, problems: list[Problem]) -> dict[str, Frame]:
    if not isinstance(entries, Mapping):
        return {}
    frames: dict[str, Frame] = {}
    for name, entry in entries.items():
        frame = _read_part(Frame, entry, f"{where}.{name}", problems)
        frames[name] = Frame() if frame is None else frame
    return frames


def _read_part(make: Callable[..., T], entry: object, where: str, problems: list[Problem]) -> T | None:
    """Return what `make` makes of a table; its faults are placed at `where`, below which they are told."""
    inner: list[Problem] = []
    made = _attempt(lambda: make(**entry), inner) if isinstance(entry, Mapping) else None
    for problem in inner:
        rest = problem.where.partition(", ")[2]
        place = f"{where}.{rest}" if rest else where
        problems.append(Problem(problem.code, place, problem.what, problem.why, problem.fix))
    return made


def _attempt(make: Callable[[], T], problems: list[Problem]) -> T | None:
    try:
        return make()
    except SymbodyError as error:
        problems.extend(error.problems)
        return None
