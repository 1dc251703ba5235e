"""What in a model file has another structure than its role: fact, cause and cure, below a table."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.errors import nearest

Path = tuple[str | int, ...]
# A part of a JSON Schema.
Schema = dict[str, object]

FORMULA_SCHEMA: Final[Mapping[str, object]] = MappingProxyType({"type": ["string", "number"]})
_LARGE: Final = 10**60
_LONGEST: Final = 60
# An effort is called by the kind of coordinate along which it acts.
_EFFORTS: Final = MappingProxyType({"force": "torque", "torque": "force"})


class Misfit(NamedTuple):
    """One value of a wrong type, or one key too many or too few.

    Attributes
    ----------
    path : tuple of str or int
        Where it is, from the top of the file.
    """

    path: Path
    code: str
    what: str
    why: str = ""
    fix: str = ""


Judge = Callable[[object, Path], Iterable[Misfit]]


def wrong_type(value: object, path: Path, expected: str, fix: str = "", why: str = "") -> tuple[Misfit]:
    """Return the misfit of a value of another type than what is `expected`, in words."""
    cause = "true and false are not numbers" if isinstance(value, bool) else why
    what = f"{short_text(value)} was found where {expected} is expected"
    return (Misfit(path, "wrong_type", what, cause, fix or f"write {expected}"),)


def wrong_length(path: Path, length: int, count: int) -> tuple[Misfit]:
    """Return the misfit of a list that should have `count` entries."""
    what = f"{length} entries instead of {count}"
    return (Misfit(path, "wrong_length", what, "", f"give {count} entries"),)


def text_misfits(value: object, path: Path) -> Iterable[Misfit]:
    """Return what keeps a value from being a text."""
    if isinstance(value, str):
        return ()
    why = "" if isinstance(value, list | dict) else "quotes are missing"
    return wrong_type(value, path, "a string in quotes", why=why)


def formula_misfits(value: object, path: Path) -> Iterable[Misfit]:
    """Return what keeps a value from being a formula or a finite number."""
    if isinstance(value, str) or type(value) is int:
        return ()
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        return wrong_type(value, path, "a number or an expression")
    if Decimal(value).is_finite():
        return ()
    return (Misfit(path, "not_finite", f"the value is {value}", "", "give a finite number"),)


def list_misfits(
    value: object, path: Path, item: Judge, count: int | None = None, example: str = ""
) -> Iterable[Misfit]:
    """Return what keeps a value from being a list of `count` items, or of any number, that fit."""
    if not isinstance(value, list):
        return wrong_type(value, path, "a list", example and f"write {example}")
    length = len(value)
    if count is not None and length > count:
        return wrong_length(path, length, count)
    misfits = [misfit for k, each in enumerate(value) for misfit in item(each, (*path, k))]
    return misfits if misfits or count in (None, length) else wrong_length(path, length, count or 0)


def mapping_misfits(value: object, path: Path, item: Judge) -> Iterable[Misfit]:
    """Return what keeps a value from being a table of items that fit, under any names."""
    if not isinstance(value, dict):
        return wrong_type(value, path, "a table")
    return [
        misfit
        for key, each in value.items()
        for misfit in (*text_misfits(key, (*path, str(key))), *item(each, (*path, str(key))))
    ]


def missing_key(path: Path, key: str) -> Misfit:
    """Return the misfit of a table at `path` without one of its keys."""
    return Misfit((*path, key), "missing_key", f"{key!r} is missing", "", f"add {key} = ..")


def unknown_key(path: Path, key: object, legal: Iterable[str]) -> Misfit:
    """Return the misfit of a table at `path` with a key that has no meaning there."""
    names = tuple(legal)
    other = _EFFORTS.get(str(key), "")
    fix = f"the key is called {other!r}" if other in names else nearest(str(key), names)
    return Misfit((*path, str(key)), "unknown_key", f"there is no key {key!r} here", "", fix)


def short_text(value: object) -> str:
    """Return a value as messages show it, which may be huge or nested without end."""
    if isinstance(value, int) and abs(value) >= _LARGE:  # Python declines to write out the largest
        return "a huge whole number"
    if isinstance(value, list | dict):
        text = reprlib.repr(value)
    else:
        text = str(value) if isinstance(value, Decimal) else repr(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
