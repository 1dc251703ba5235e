"""Which elements there are: every final class in the folders of this package that declares one."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any, Final

from symbody.model.body import Body
from symbody.model.class_folders import definition_name, final_classes, snake_case
from symbody.model.declarations.declaration import file_table
from symbody.model.declarations.field import FileTable, FileTarget, Node
from symbody.model.element import Element
from symbody.model.model import KINDS

_PACKAGE: Final = __name__.rpartition(".")[0]
# Folders whose stubs say in which file a class stands, and all in which elements stand.
_STUBBED: Final = tuple(f"{_PACKAGE}.{each}" for each in ("joints", "signals.blocks", "constraints"))
_FOLDERS: Final = (*_STUBBED, *(f"{_PACKAGE}.{each}" for each in ("loads", "contacts", "signals", "tables")))
# Kinds of which a file has several types, named by a word.
TYPED: Final = ("joint", "constraint", "block")


@cache
def element_type(kind: str, word: str) -> type[Element]:
    """Return the element of a kind by its word in model files.

    Where a stub says in which file it stands, no other file is loaded for it.
    """
    if kind == Body.kind:
        return Body
    for folder in _STUBBED:
        package = import_module(folder)
        for name in package.__all__:
            if snake_case(name) == word:
                each: type[Element] = getattr(package, name)
                if each.kind == kind and type_word(each) == word:
                    return each
    return element_types(kind)[word]


@cache
def element_types(kind: str) -> Mapping[str, type[Element]]:
    """Return the elements of a kind by their words in model files; "" where the kind has one type."""
    if kind == Body.kind:
        return MappingProxyType({"": Body})
    classes = [each for folder in _FOLDERS for each in final_classes(folder)]
    words = {type_word(each): each for each in classes if issubclass(each, Element) and each.kind == kind}
    return MappingProxyType(dict(sorted(words.items())))


class ElementTables(Mapping[str, FileTable]):
    """The tables of model files that describe elements of a kind, by their words, made when asked for."""

    __slots__ = ("_kind",)

    def __init__(self, kind: str) -> None:
        self._kind = kind

    def __getitem__(self, word: str) -> FileTable:
        return file_table(element_type(self._kind, word), definition_name(word or self._kind), word)

    def __contains__(self, word: object) -> bool:
        return (word == "") is (self._kind not in TYPED) and (word == "" or word in element_types(self._kind))

    def __iter__(self) -> Iterator[str]:
        return iter(element_types(self._kind))

    def __len__(self) -> int:
        return len(element_types(self._kind))


def type_word(kind: type[Element]) -> str:
    """Return the word for a type in model files."""
    return kind.word or snake_case(kind.__name__) if kind.kind in TYPED else ""


def elements() -> list[dict[str, Any]]:
    """Return all elements as JSON data, with the fields from which an editor makes its forms.

    Each has `section` and `type`, its place in a model file; `title`, `group` and `summary`; `definition`,
    its name in the schema of the file; and `fields`: name, role, unit, default, whether it is required, and a
    sentence.
    """
    return [_entry(kind, word, each) for kind in KINDS for word, each in element_types(kind).items()]


def _entry(kind: str, word: str, each: type[Element]) -> dict[str, Any]:
    title = word or kind
    return {
        "section": kind,
        "type": word,
        "title": _title(title, each.__name__),
        "group": each.group or f"{kind.capitalize()}s",
        "summary": each.summary(),
        "definition": definition_name(title),
        "fields": [json.loads(json.dumps(field.panel(name))) for name, field in each.fields.items()],
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


def read_element(kind: str, entry: Mapping[str, Any], folder: str = "") -> Element:
    """Return the element of a table that fits the schema; paths of other files start from `folder`.

    A ModelError has everything in it that is not a name, a place or a formula.
    """
    element_class = element_type(kind, str(entry.get("type", "")))
    return element_class.from_entry(entry, f"{kind} {entry['name']}", folder)


def write_element(element: Element, target: FileTarget) -> dict[str, Node]:
    """Return the table of an element, without what has its default."""
    entry: dict[str, Node] = {"name": element.name}
    word = type_word(type(element))
    if word:
        entry["type"] = word
    return {**entry, **element.to_entry(target)}
