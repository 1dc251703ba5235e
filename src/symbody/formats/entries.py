"""Tables of the model file to elements and back; the file's words are those of the constructors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symbody.model.declarations.field import FileTarget, Node
from symbody.model.element import Element
from symbody.model.registry import element_type, type_word


def read_element(kind: str, entry: Mapping[str, Any], folder: str = "") -> Element:
    """Return the element of a table that fits the schema; paths of other files start from `folder`.

    Raises
    ------
    ModelError
        With everything in it that is not a name, a place or a formula.
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
