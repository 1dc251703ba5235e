"""Classes found by the folder they stand in: a new file there needs no list."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pkgutil import iter_modules


@cache
def module_names(folder: str) -> tuple[str, ...]:
    """Return the names of the modules in a package, in order."""
    return tuple(sorted(each.name for each in iter_modules(import_module(folder).__path__)))


def final_classes(folder: str) -> Iterator[type]:
    """Yield the final classes of the modules in a package."""
    for file in module_names(folder):
        module = import_module(f"{folder}.{file}")
        for value in vars(module).values():
            is_own = isinstance(value, type) and value.__module__ == module.__name__
            if is_own and getattr(value, "__final__", False):
                yield value


def snake_case(name: str) -> str:
    """Return the name of a class as files write it.

    >>> snake_case("PointOnLine"), snake_case("DCMotor")
    ('point_on_line', 'dc_motor')
    """
    return re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def definition_name(word: str) -> str:
    """Return the name of an entry in the schema of the model file.

    >>> definition_name("point_on_line")
    'PointOnLineEntry'
    """
    return f"{word.title().replace('_', '')}Entry"
