"""Whether data have the structure of a model file, by the published schema.

Nearly all data do. What is wrong with others, if anything is, pydantic finds out: it takes longer to load
than most models take to be read.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType, NoneType
from typing import Any, Final, TypeAlias, cast

from symbody.formats.places import Locate

Node: TypeAlias = Mapping[str, Any]

VERSION: Final = 2
# What version 2 brought; a file without any of them is written without a version, as those of version 1.
NEWER_SECTIONS: Final = ("table", "signal", "block", "include")

_TEXT: Final = MappingProxyType({"type": "string"})
_HALF_CHARACTER: Final = re.compile("[\ud800-\udfff]")
_CLASSES: Final[Mapping[str, frozenset[type]]] = MappingProxyType(
    {
        "array": frozenset({list}),
        "boolean": frozenset({bool}),
        "integer": frozenset({int}),
        "null": frozenset({NoneType}),
        "number": frozenset({int, float, Decimal}),
        "object": frozenset({dict}),
        "string": frozenset({str}),
    }
)


def check_structure(data: object, locate: Locate) -> Mapping[str, Any]:
    """Return `data`, which has only known keys, all that are needed, and values of the right types.

    Raises
    ------
    FormatError
        With every key and value that does not fit.
    """
    if not fits(published_schema(), data):
        judge: Callable[[object, Locate], None] = import_module("symbody.formats.checking").refuse_misfits
        judge(data, locate)
    return cast("Mapping[str, Any]", data)


@cache
def published_schema() -> Node:
    """Return the JSON Schema beside this file."""
    text = Path(__file__).with_name("schema.json").read_text(encoding="utf-8")
    return cast("Node", json.loads(text))


def fits(node: Node, value: object) -> bool:
    """Return whether a value fits a node of the schema; False where that is in doubt."""
    return all(check(node, value) for check in {_CHECKS[key] for key in node.keys() & _CHECKS.keys()})


def _fits_class(node: Node, value: object) -> bool:
    words = node["type"]
    names = [words] if isinstance(words, str) else words
    if isinstance(value, float | Decimal) and not Decimal(value).is_finite():
        return False
    if isinstance(value, str) and _HALF_CHARACTER.search(value):
        return False
    return any(type(value) in _CLASSES[name] for name in names)


def _fits_words(node: Node, value: object) -> bool:
    return type(value) is str and value in node.get("enum", [node.get("const")])


def _fits_limits(node: Node, value: object) -> bool:
    return type(value) is int and node.get("minimum", value) <= value <= node.get("maximum", value)


def _fits_any(node: Node, value: object) -> bool:
    return any(fits(choice, value) for choice in node["anyOf"])


def _fits_one(node: Node, value: object) -> bool:
    """Return whether a table fits the type that it names."""
    word = value.get(node["discriminator"]["propertyName"]) if isinstance(value, dict) else None
    place = node["discriminator"]["mapping"].get(word) if isinstance(word, str) else None
    return place is not None and fits({"$ref": place}, value)


def _fits_definition(node: Node, value: object) -> bool:
    return fits(published_schema()["$defs"][node["$ref"].rpartition("/")[2]], value)


def _fits_list(node: Node, value: object) -> bool:
    if not isinstance(value, list) or not node.get("minItems", 0) <= len(value):
        return False
    if len(value) > node.get("maxItems", len(value)):
        return False
    first = node.get("prefixItems", [])
    rest = node.get("items", {})
    return all(fits(first[k] if k < len(first) else rest, item) for k, item in enumerate(value))


def _fits_table(node: Node, value: object) -> bool:
    if not isinstance(value, dict) or any(key not in value for key in node.get("required", ())):
        return False
    known, other = node.get("properties", {}), node.get("additionalProperties", False)
    rules = [known.get(key, other) if fits(_TEXT, key) else False for key in value]
    return all(
        rule is True or (rule is not False and fits(rule, item))
        for rule, item in zip(rules, value.values(), strict=True)
    )


# What is looked at where a node has a key; the other keys explain.
_CHECKS: Final[Mapping[str, Callable[[Node, object], bool]]] = MappingProxyType(
    {
        "$ref": _fits_definition,
        "type": _fits_class,
        "const": _fits_words,
        "enum": _fits_words,
        "minimum": _fits_limits,
        "maximum": _fits_limits,
        "anyOf": _fits_any,
        "oneOf": _fits_one,
        "items": _fits_list,
        "prefixItems": _fits_list,
        "minItems": _fits_list,
        "maxItems": _fits_list,
        "properties": _fits_table,
        "additionalProperties": _fits_table,
        "required": _fits_table,
    }
)
