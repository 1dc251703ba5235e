"""Tables of the model file to elements and back; the file's words are those of the constructors."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from types import MappingProxyType
from typing import Final, TypeVar

from symbody.errors import ModelError, Problem, SymbodyError
from symbody.expr.language.formula import Formula
from symbody.formats.places import words
from symbody.model.body import Body
from symbody.model.constraint import Condition
from symbody.model.constraints import (
    Angle,
    Belt,
    Constraint,
    Differential,
    Distance,
    Gear,
    KnifeEdge,
    Parallel,
    Perpendicular,
    PointOnCurve,
    PointOnLine,
    PointOnPlane,
    PointOnSurface,
    RackPinion,
    Rolling,
)
from symbody.model.element import Address, Element
from symbody.model.frame import Frame
from symbody.model.joint import InTrees, Joint
from symbody.model.joints import (
    Bearing,
    Cartesian,
    ConstantVelocity,
    Cylindrical,
    Free,
    Gimbal,
    PinSlot,
    Planar,
    Prismatic,
    Rectangular,
    Revolute,
    Screw,
    Spherical,
    Telescoping,
    Universal,
    Weld,
)
from symbody.model.loads.curve import Curve
from symbody.model.loads.forces import Drive, Force, SpringDamper, Torque
from symbody.model.loads.friction import Friction
from symbody.model.loads.springs import Bushing, TorsionSpring
from symbody.model.shapes import BodyShape, Box, Capsule, Cone, Cylinder, Mesh, Sphere
from symbody.model.table import Table

T = TypeVar("T")

# What a model file consists of; formulas become text or numbers when it is written.
Node = Formula | str | bool | list["Node"] | dict[str, "Node"]

ELEMENTS: Final = MappingProxyType[str, Callable[..., Element]](
    {
        "body": Body,
        "spring": SpringDamper,
        "torsion_spring": TorsionSpring,
        "force": Force,
        "torque": Torque,
    }
)
JOINTS: Final = MappingProxyType[str, Callable[..., Element]](
    {
        "weld": Weld,
        "revolute": Revolute,
        "prismatic": Prismatic,
        "screw": Screw,
        "cylindrical": Cylindrical,
        "universal": Universal,
        "constant_velocity": ConstantVelocity,
        "pin_slot": PinSlot,
        "planar": Planar,
        "rectangular": Rectangular,
        "cartesian": Cartesian,
        "spherical": Spherical,
        "gimbal": Gimbal,
        "bearing": Bearing,
        "telescoping": Telescoping,
        "free": Free,
        "bushing": Bushing,  # no joint of the trees, but a file lists it among them
    }
)
CONSTRAINTS: Final = MappingProxyType[str, Callable[..., Condition]](
    {
        "distance": Distance,
        "point_on_line": PointOnLine,
        "point_on_plane": PointOnPlane,
        "point_on_curve": PointOnCurve,
        "point_on_surface": PointOnSurface,
        "parallel": Parallel,
        "perpendicular": Perpendicular,
        "angle": Angle,
        "knife_edge": KnifeEdge,
        "rolling": Rolling,
        "gear": Gear,
        "rack_pinion": RackPinion,
        "belt": Belt,
        "differential": Differential,
        "equation": Constraint,
    }
)
SHAPES: Final = MappingProxyType[str, Callable[..., BodyShape]](
    {"box": Box, "cylinder": Cylinder, "sphere": Sphere, "capsule": Capsule, "cone": Cone, "mesh": Mesh}
)
_TYPES: Final = MappingProxyType[str, Mapping[str, Callable[..., Element]]](
    {"joint": JOINTS, "constraint": CONSTRAINTS}
)
_TYPE_WORDS: Final = MappingProxyType(
    {maker: word for types in (*_TYPES.values(), SHAPES) for word, maker in types.items()}
)
# Written even where they have their default: a reader looks for them, or other defaults depend on them.
_ALWAYS: Final = frozenset({"angles", "axes", "axis"})
# Keyed by coordinate in the model; in the file too, unless the joint has only one.
_BY_COORDINATE: Final = frozenset({"armature", "force", "motion", "torque"})


def element_from(kind: str, entry: Mapping[str, object], folder: str = "") -> Element:
    """Return the element of a table that fits the schema; paths of meshes start from `folder`.

    Raises
    ------
    ModelError
        With everything in it that is not a name, a place or a formula.
    """
    arguments = dict(entry)
    make = _TYPES[kind][str(arguments.pop("type"))] if kind in _TYPES else ELEMENTS[kind]
    between = arguments.pop("between", None)
    if isinstance(between, list):
        arguments["start"], arguments["end"] = between
    problems: list[Problem] = []
    label = f"{kind} {entry['name']}"
    if kind == "body":
        arguments["frames"] = _frames(arguments.get("frames", {}), label, ("frames",), problems)
        shapes = arguments.pop("shape", [])
        arguments["shapes"] = shapes_from_entries(shapes, f"{label}, shape", folder, problems)
    if kind == "joint":
        for word in {"force", "torque"} & set(arguments):
            arguments[word] = _drives(arguments[word], f"{label}, {word}", problems)
        if "friction" in arguments:
            arguments["friction"] = _nested(Friction, arguments["friction"], f"{label}, friction", problems)
    element = _attempt(lambda: make(**arguments), problems)
    if element is None or problems:
        raise ModelError(*problems)
    return element


def ground_frames(entry: object, problems: list[Problem]) -> dict[str, Frame]:
    """Return the frames of the ground; faults are added to `problems`."""
    return _frames(entry, "model", ("ground", "frames"), problems)


def shapes_from_entries(entries: object, where: str, folder: str, problems: list[Problem]) -> list[BodyShape]:
    """Return the shapes of a list of tables; faults are added to `problems`."""
    shapes = []
    for k, entry in enumerate(entries if isinstance(entries, list) else []):
        arguments = dict(entry)
        make = SHAPES[arguments.pop("type")]
        if make is Mesh:
            arguments["folder"] = folder
        shape = _nested(make, arguments, f"{where}[{k}]", problems)
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
        values.pop("folder", None)
        plain = type(shape)(**{name: getattr(shape, name) for name in _needed(shape)})
        entry: dict[str, Node] = {"type": _TYPE_WORDS[type(shape)]}
        for name, value in values.items():
            if value is not None and (name in _needed(shape) or value != getattr(plain, name)):
                entry[name] = node_of(value)
        if isinstance(shape, Mesh):
            entry["path"] = shape.path if folder is None else shape.path_from(folder)
            if "scale" in entry and len(set(shape.scale)) == 1:
                entry["scale"] = shape.scale[0]
        entries.append(entry)
    return entries


def entry_of(element: Element, folder: str | None = None) -> dict[str, Node]:
    """Return the table of an element, without what has its default; `folder` as in `shape_entries`."""
    entry: dict[str, Node] = {"name": element.name}
    word = _TYPE_WORDS.get(type(element))
    if word is not None:
        entry["type"] = word
    values = _values(element)
    shapes = values.pop("shapes", ())
    if "start" in values:
        entry["between"] = [node_of(values.pop("start")), node_of(values.pop("end"))]
    given = [*_needed(element), *(_ALWAYS & set(values))]
    plainest = type(element)(**{name: getattr(element, name) for name in given})
    defaults = {name: value for name, value in _values(plainest).items() if name not in given}
    for name, value in values.items():
        if name not in entry and value is not None and (name not in defaults or value != defaults[name]):
            entry[name] = node_of(_alone(element, value) if name in _BY_COORDINATE else value)
    if isinstance(element, Body) and shapes:
        entry["shape"] = shape_entries(element.shapes, folder)
    return entry


def node_of(value: object) -> Node:
    """Return a value of the model as part of a file."""
    if isinstance(value, Formula | str | bool):
        return value
    if isinstance(value, Address):
        return value.frame
    if isinstance(value, Table):
        return {name: node_of(item) for name, item in value.items()}
    if isinstance(value, tuple):
        return [node_of(item) for item in value]
    if isinstance(value, InTrees) and value.rotation is not None and value.rotation == value.translation:
        return value.rotation
    values = _values(value)
    if isinstance(value, Curve):
        plain = {"kind": "linear", "outside": "hold"}
        return {name: node_of(item) for name, item in values.items() if item != plain.get(name)}
    empty = {InTrees: InTrees, Drive: Drive, Frame: Frame, Friction: Friction}[type(value)]()
    defaults = _values(empty)
    return {name: node_of(item) for name, item in values.items() if item != defaults[name]}


def _values(value: object) -> dict[str, object]:
    """Return the fields of an element or of a part of one, in the order of its constructor."""
    names = {field.name for field in fields(value)} if is_dataclass(value) else set()
    return {name: getattr(value, name) for name in inspect.signature(type(value)).parameters if name in names}


def _alone(element: Element, value: object) -> object:
    """Return the value for the only coordinate of a joint; all of them, by name, where there are several."""
    if isinstance(value, Table) and isinstance(element, Joint) and len(element.coordinates) == 1:
        return next(iter(value.values()))
    return value


def _needed(element: Element | BodyShape) -> list[str]:
    """Return the arguments without default of a constructor."""
    arguments = inspect.signature(type(element)).parameters.items()
    return [name for name, argument in arguments if argument.default is argument.empty]


def _drives(entry: object, where: str, problems: list[Problem]) -> object:
    """Return the drive of a table, or those of a table of tables by coordinate."""
    law = entry.get("law") if isinstance(entry, Mapping) else None
    is_curve = isinstance(law, Mapping) and "x" in law  # and not the drive of a coordinate called law
    keyed = isinstance(entry, Mapping) and entry and all(isinstance(item, Mapping) for item in entry.values())
    if isinstance(entry, Mapping) and keyed and not is_curve:
        return {name: _nested(Drive, item, f"{where}.{name}", problems) for name, item in entry.items()}
    return _nested(Drive, entry, where, problems)


def _frames(entries: object, label: str, path: tuple[str, ...], problems: list[Problem]) -> dict[str, Frame]:
    if not isinstance(entries, Mapping):
        return {}
    frames: dict[str, Frame] = {}
    for name, entry in entries.items():
        frame = _nested(Frame, entry, f"{label}, {words((*path, str(name)))}", problems)
        frames[name] = Frame() if frame is None else frame
    return frames


def _nested(make: Callable[..., T], entry: object, where: str, problems: list[Problem]) -> T | None:
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
