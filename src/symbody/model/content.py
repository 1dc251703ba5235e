"""The content of a model as bytes: equal bytes mean that everything made from it is equal.

Two models that are equal may differ here, as by the order of a table: what looks for results made before then
makes them once more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import Final

from symbody.expr.language.formula import Formula

_OURS: Final = "symbody."


def content_bytes(*values: object) -> bytes:
    """Return frozen values as bytes; empty if something in them is not data of this package.

    Classes of a user's own, and functions, may do tomorrow what they do not do today.
    """
    written: list[str] = []
    waiting: list[object] = list(reversed(values))
    field_names: dict[type, tuple[str, ...] | None] = {}
    while waiting:
        value = waiting.pop()
        kind = type(value)
        if kind is Formula and isinstance(value, Formula):
            written.append(f"f{value.text!r}")
            continue
        write = _PLAIN.get(kind)
        if write is not None:
            written.append(write(value))
            continue
        if kind not in field_names:
            field_names[kind] = _field_names(value)
        names = field_names[kind]
        parts: list[object]
        if names is not None:
            parts = [getattr(value, name) for name in names]
        elif not _is_data(kind):
            return b""
        elif isinstance(value, tuple | list):
            parts = list(value)
        elif isinstance(value, Mapping):
            parts = [part for pair in value.items() for part in pair]
        elif isinstance(value, Enum):
            parts = [value.value]
        else:
            return b""
        written.append(f"{kind.__module__}.{kind.__qualname__}:{len(parts)}")
        waiting.extend(reversed(parts))
    return "\n".join(written).encode()


def _field_names(value: object) -> tuple[str, ...] | None:
    """Return the names of the fields of a dataclass of this package; private ones follow from the others."""
    if not is_dataclass(value) or not _is_data(type(value)):
        return None
    return tuple(field.name for field in fields(value) if not field.name.startswith("_"))


def _is_data(kind: type) -> bool:
    return kind in (dict, list, tuple) or kind.__module__.startswith(_OURS)


# Each begins in its own way, and none contains the end of a line.
_PLAIN: Final[Mapping[type, Callable[[object], str]]] = {
    kind: repr for kind in (bool, float, Fraction, int, str, type(None))
}
