"""The words of joints: what each argument of a constructor takes, and what is kept of it.

A word means the same in every joint. `take` is the one way in; a joint with words of its own hands over
how they are read.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeVar

from symbody.expr.language.formula import Formula
from symbody.model.body import Place, address_from
from symbody.model.door import ZERO, Door
from symbody.model.joint import InTrees, Joint
from symbody.model.joints.keys import check_keys
from symbody.model.loads.forces import Drive, drive_from
from symbody.model.loads.friction import Friction, friction_from
from symbody.model.table import Table
from symbody.model.turn import axis_from

T = TypeVar("T")

Trees = InTrees | bool | Mapping[str, bool] | None
# Takes the joint with the words before this one, the door, what was given, and the word.
Reader = Callable[[Joint, Door, object, str], object]


def take(
    joint: Joint,
    name: str,
    start: Place,
    end: Place,
    tree: Trees,
    own: Mapping[str, Reader] = MappingProxyType({}),
    **words: object,
) -> None:
    """Set the fields of a new joint from the arguments of its constructor, in their order.

    Parameters
    ----------
    own : mapping of word to reader
        Words that mean something of their own in this joint.
    **words : object
        Arguments beyond those that all joints have; coordinates before what is keyed by them.

    Raises
    ------
    ModelError
        With everything that is wrong with them.
    """
    door = Door(f"joint {name}")
    object.__setattr__(joint, "name", door.element_name(name))
    object.__setattr__(joint, "start", address_from(door, start, "between[0]"))
    object.__setattr__(joint, "end", address_from(door, end, "between[1]"))
    object.__setattr__(joint, "tree", _trees(door, tree))
    for word, value in words.items():
        read = own[word] if word in own else _READERS[word]
        object.__setattr__(joint, word, read(joint, door, value, word))
    check_keys(joint, door)
    door.close()


def names_from(door: Door, value: object, path: str, default: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of symbols, as many as `default` has, which stands where none or a bad one is given."""
    if value is None:
        return default
    items = door.items(value, path)
    if len(items) != len(default):
        door.refuse(
            "model.wrong_number",
            path,
            f"{len(items)} names instead of {len(default)}",
            f"left out, they are {', '.join(default)}",
            f"give {len(default)} names, or none",
        )
        return default
    pairs = zip(items, default, strict=True)
    return tuple(_symbol(door, item, f"{path}[{k}]", other) for k, (item, other) in enumerate(pairs))


def along(component: Formula, coordinate: str) -> Formula:
    """Return the product of a component and a coordinate, short where the component is 0 or 1."""
    if component.text in ("0", "1"):
        return Formula.of(coordinate) if component.text == "1" else ZERO
    return Formula.of(f"({component.text})*{coordinate}")


def _coordinate(joint: Joint, door: Door, value: object, path: str) -> str | None:
    return None if value is None else _symbol(door, value, path, joint.default_coordinates[0])


def _coordinates(joint: Joint, door: Door, value: object, path: str) -> tuple[str, ...]:
    return names_from(door, value, path, joint.default_coordinates)


def _drives(joint: Joint, door: Door, value: object, path: str) -> Table[Drive]:
    return _by_coordinate(joint, door, value, path, lambda item, place: drive_from(door, item, place))


def _motion(joint: Joint, door: Door, value: object, path: str) -> Table[Formula]:
    return _by_coordinate(joint, door, value, path, door.angle)


def _armature(joint: Joint, door: Door, value: object, path: str) -> Table[Formula]:
    inertias = _by_coordinate(joint, door, value, path, door.formula)
    return Table({name: inertia for name, inertia in inertias.items() if inertia.constant() != 0})


def _friction(joint: Joint, door: Door, value: object, path: str) -> Friction | None:
    found = friction_from(door, value, path)
    if found is None or len(joint.coordinates) == 1:
        return found
    door.refuse(
        "model.friction_directions",
        path,
        f"the joint has {len(joint.coordinates)} free directions",
        "friction is defined along one",
        "build it from joints with one coordinate, with bodies without mass between them",
    )
    return None


def _flag(joint: Joint, door: Door, value: object, path: str) -> bool:
    if isinstance(value, bool):
        return value
    door.refuse("model.not_a_flag", path, f"{value!r} is neither true nor false", "", "write true or false")
    return False


_READERS: Final[Mapping[str, Reader]] = MappingProxyType(
    {
        "axis": lambda joint, door, value, word: axis_from(door, value, word),
        "coordinate": _coordinate,
        "coordinates": _coordinates,
        "force": _drives,
        "torque": _drives,
        "motion": _motion,
        "as_constraint": _flag,
        "armature": _armature,
        "friction": _friction,
    }
)


def _by_coordinate(
    joint: Joint, door: Door, value: object, path: str, read: Callable[[object, str], T | None]
) -> Table[T]:
    """Return what `read` makes of the value for each coordinate; a joint with one takes it without name."""
    names = joint.coordinates
    if len(names) == 1:
        if isinstance(value, Table):  # of a joint that is copied, perhaps with another coordinate
            value = next(iter(value.values()), None)
        value = {} if value is None else {names[0]: value}
    if value is None:
        return Table()
    if not isinstance(value, Mapping):
        door.refuse(
            "model.not_by_coordinate",
            path,
            f"{value!r} does not say which coordinate it belongs to",
            f"the joint has {len(names)} coordinates: {', '.join(names)}",
            f"write {{ {names[-1]} = .. }}, in Python {{{names[-1]!r}: ..}}",
        )
        return Table()
    found = {str(key): read(item, joint.path_of(path, str(key))) for key, item in value.items()}
    return Table({key: item for key, item in found.items() if item is not None})


def _symbol(door: Door, value: object, path: str, default: str) -> str:
    count = len(door.problems)
    name = door.symbol_name(value, path)
    return name if len(door.problems) == count else default


def _trees(door: Door, value: object) -> InTrees:
    """Return the choice of trees from None, a bool, or a mapping rotation/translation to bool."""
    if isinstance(value, InTrees):
        return value
    if value is None:
        return InTrees()
    if isinstance(value, bool):
        return InTrees(value, value)
    if isinstance(value, Mapping) and set(value) <= {"rotation", "translation"}:
        if all(isinstance(flag, bool) for flag in value.values()):
            return InTrees(value.get("rotation"), value.get("translation"))
    door.refuse(
        "model.bad_tree",
        "tree",
        f"{value!r} is no choice of trees",
        "",
        "write true, false, or { rotation = true, translation = false }; leave it out for automatic",
    )
    return InTrees()
