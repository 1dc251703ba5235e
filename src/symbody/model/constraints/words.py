"""The words of constraints: what each argument of a constructor takes, and what is kept of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.body import address_from
from symbody.model.constraint import Condition
from symbody.model.door import Door
from symbody.model.turn import Axis, axis_from

Reader = Callable[[Door, object, str], object]

# Fields whose place in a file is another word.
_PLACES: Final = MappingProxyType({"start": "between[0]", "end": "between[1]"})


def take(
    condition: Condition, name: str, own: Mapping[str, Reader] = MappingProxyType({}), **words: object
) -> None:
    """Set the fields of a new constraint from the arguments of its constructor.

    Parameters
    ----------
    own : mapping of word to reader
        Words that mean something of their own in this constraint.

    Raises
    ------
    ModelError
        With everything that is wrong with them.
    """
    door = Door(f"constraint {name}")
    object.__setattr__(condition, "name", door.element_name(name))
    for word, value in words.items():
        read = own[word] if word in own else _READERS[word]
        object.__setattr__(condition, word, read(door, value, _PLACES.get(word, word)))
    door.close()


def two_axes(door: Door, value: object, path: str) -> tuple[Axis, Axis]:
    """Return a direction in start and one in end."""
    why = "the first is fixed in start, the second in end"
    items = _so_many(door, value, path, 2, "directions", why, 'write axes = ["z", "z"]')
    first, second = (axis_from(door, item, f"{path}[{k}]") for k, item in enumerate(items or ("z", "z")))
    return (first, second)


def formulas(door: Door, value: object, path: str) -> tuple[Formula, ...]:
    """Return formulas from one, or from a list of them."""
    if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
        return (door.formula(value, path),)
    items = door.items(value, path)
    if not items:
        why = "a constraint says what vanishes"
        door.refuse("model.empty", path, "there is no equation", why, 'write equations = ["x - y"]')
    return tuple(door.formula(item, f"{path}[{k}]") for k, item in enumerate(items))


def pair(door: Door, value: object, path: str) -> tuple[Formula, ...]:
    """Return two formulas."""
    items = _so_many(door, value, path, 2, "values", "there are two pulleys", "give one for each")
    return tuple(door.formula(item, f"{path}[{k}]") for k, item in enumerate(items or (1, 1)))


def symbol(door: Door, value: object, path: str) -> str:
    """Return the name of a coordinate."""
    return door.symbol_name(value, path)


def symbols(count: int) -> Reader:
    """Return what reads the names of so many coordinates."""

    def read(door: Door, value: object, path: str) -> tuple[str, ...]:
        why = "each wheel, rack or shaft moves with one"
        items = _so_many(door, value, path, count, "coordinates", why, "name one for each")
        names = tuple(door.symbol_name(item, f"{path}[{k}]") for k, item in enumerate(items or ()))
        for name in sorted({name for name in names if names.count(name) > 1 and name != "?"}):
            what = f"{name} stands {names.count(name)} times"
            why = "a coordinate coupled to itself stands still"
            door.refuse("model.coupled_twice", path, what, why, "name different coordinates")
        return names if items else ("?",) * count

    return read


def _so_many(
    door: Door, value: object, path: str, count: int, nouns: str, why: str, fix: str
) -> list[object] | None:
    """Return a list of so many entries, or None."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        door.items(value, path)  # tells that it is none
        return None
    items = door.items(value, path)
    if len(items) == count:
        return items
    noun = nouns if len(items) != 1 else nouns.removesuffix("s")
    door.refuse("model.wrong_number", path, f"{len(items)} {noun} instead of {count}", why, fix)
    return None


def flag(door: Door, value: object, path: str) -> bool:
    """Return a truth value."""
    if isinstance(value, bool):
        return value
    door.refuse("model.not_a_flag", path, f"{value!r} is neither true nor false", "", "write true or false")
    return False


def axis_or_none(door: Door, value: object, path: str) -> Axis | None:
    """Return an axis, or None for None."""
    return None if value is None else axis_from(door, value, path)


_READERS: Final[Mapping[str, Reader]] = MappingProxyType(
    {
        "start": address_from,
        "end": address_from,
        "axis": axis_from,
        "normal": axis_from,
        "axes": two_axes,
        "value": Door.angle,
        "radius": Door.formula,
        "ratio": Door.formula,
        "offset": Door.formula,
        "equations": formulas,
        "curve": Door.triple,
        "parameter": symbol,
        "rope": flag,
        "crossed": flag,
        "radii": pair,
    }
)
