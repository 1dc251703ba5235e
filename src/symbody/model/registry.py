"""Which elements there are: every final class in the folders of this package that declares one."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType, ModuleType
from typing import Any, Final

from symbody.model import constraints, joints, loads, shapes, signals, tables
from symbody.model.body import Body
from symbody.model.declarations.declaration import REQUIRED, Field
from symbody.model.element import Element
from symbody.model.model import KINDS
from symbody.model.shapes.shape import BodyShape
from symbody.model.signals import blocks

# Kinds of which a file has several types, named by a word.
TYPED: Final = ("joint", "constraint", "block")
# What the diagram editor calls groups of kinds.
_GROUPS: Final = MappingProxyType(
    {
        "body": "Bodies",
        "joint": "Joints",
        "constraint": "Constraints",
        "spring": "Springs and dampers",
        "torsion_spring": "Springs and dampers",
        "force": "Forces and torques",
        "torque": "Forces and torques",
        "signal": "Signals",
        "table": "Signals",
        "block": "Blocks",
    }
)


@cache
def element_type(kind: str, word: str) -> type[Element]:
    """Return the element of a kind by its word in model files.

    A joint or block stands in the file of its word: no other is loaded for it.
    """
    if kind == Body.kind:
        return Body
    for folder in (joints, blocks):
        own_file = [file for file in _files(folder) if file == word]
        for each in _final_classes(folder, own_file):
            if issubclass(each, Element) and each.kind == kind and type_word(each) == word:
                return each
    return element_types(kind)[word]


@cache
def element_types(kind: str) -> Mapping[str, type[Element]]:
    """Return the elements of a kind by their words in model files; "" where the kind has one type."""
    if kind == Body.kind:
        return MappingProxyType({"": Body})
    classes = [
        each
        for folder in (joints, constraints, loads, signals, blocks, tables)
        for each in _final_classes(folder, _files(folder))
    ]
    words = {type_word(each): each for each in classes if issubclass(each, Element) and each.kind == kind}
    return MappingProxyType(dict(sorted(words.items())))


@cache
def shape_types() -> Mapping[str, type[BodyShape]]:
    """Return the shapes by their words in model files."""
    classes = [each for each in _final_classes(shapes, _files(shapes)) if issubclass(each, BodyShape)]
    words = {snake_case(each.__name__): each for each in classes}
    return MappingProxyType(dict(sorted(words.items())))


def type_word(kind: type[Element]) -> str:
    """Return the word for a type in model files."""
    return kind.word or snake_case(kind.__name__) if kind.kind in TYPED else ""


def snake_case(name: str) -> str:
    """Return the name of a class as files write it.

    >>> snake_case("PointOnLine")
    'point_on_line'
    """
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def elements() -> list[dict[str, Any]]:
    """Return all elements as JSON data, with the fields from which an editor makes its forms.

    Each has `section` and `type`, its place in a model file; `title`, `group` and `summary`; `definition`,
    its name in the schema of the file; and `fields`: name, role, unit, default, whether it is required, and a
    sentence.
    """
    return [_entry(kind, word, each) for kind in KINDS for word, each in element_types(kind).items()]


@cache
def _files(folder: ModuleType) -> tuple[str, ...]:
    """Return the names of the modules in a folder, in order."""
    return tuple(sorted(each.name for each in iter_modules(folder.__path__)))


def _final_classes(folder: ModuleType, files: Iterable[str]) -> Iterator[type]:
    """Yield the final classes of modules in a folder."""
    for file in files:
        module = import_module(f"{folder.__name__}.{file}")
        for value in vars(module).values():
            is_own = isinstance(value, type) and value.__module__ == module.__name__
            if is_own and getattr(value, "__final__", False):
                yield value


def _entry(kind: str, word: str, each: type[Element]) -> dict[str, Any]:
    title = word or kind
    return {
        "section": kind,
        "type": word,
        "title": _title(title, each.__name__),
        "group": _GROUPS.get(kind, kind.capitalize()),
        "summary": each.summary(),
        "definition": definition_name(title),
        "fields": [_field(name, field) for name, field in each.fields.items()],
    }


def _title(word: str, class_name: str) -> str:
    """Return a word of model files as a title, abbreviations as the class has them.

    >>> _title("dc_motor", "DCMotor"), _title("pin_slot", "PinSlot")
    ('DC motor', 'Pin slot')
    """
    words = word.split("_")
    if class_name.lower() == "".join(words):
        shown = [class_name[sum(map(len, words[:k])) :][: len(each)] for k, each in enumerate(words)]
        words = [each if each.isupper() and len(each) > 1 else each.lower() for each in shown]
    text = " ".join(words)
    return text[:1].upper() + text[1:]


def definition_name(word: str) -> str:
    """Return the name of an entry in the schema of the model file.

    >>> definition_name("point_on_line")
    'PointOnLineEntry'
    """
    return f"{word.title().replace('_', '')}Entry"


def _field(name: str, field: Field[Any, Any]) -> dict[str, Any]:
    default = None if field.default is REQUIRED else json.loads(json.dumps(field.default))
    return {
        "name": name,
        "place": field.place or name,
        "role": field.role,
        "unit": field.unit,
        "required": field.is_required,
        "default": default,
        "sentence": field.sentence,
    }
