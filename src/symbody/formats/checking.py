"""What does not fit the structure of a model file: pydantic's findings in our words."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from decimal import Decimal
from types import MappingProxyType
from typing import Any, Final, TypeAlias, cast

from pydantic import ValidationError

from symbody.errors import FormatError, Problem, nearest
from symbody.formats.lines import Path
from symbody.formats.places import Locate, words
from symbody.formats.schema import ModelFile
from symbody.formats.version import VERSION
from symbody.model.model import KINDS

Schema: TypeAlias = dict[str, Any]

_MAX_PROBLEMS: Final = 50
_LARGE: Final = 10**60
_TYPED: Final = (("joint",), ("constraint",), ("block",))

# What other programs, and books, call our types.
OTHER_NAMES: Final = MappingProxyType(
    {
        other: ours
        for ours, others in (
            ("revolute", "hinge pin pivot rotational continuous"),
            ("prismatic", "slider slide translational linear"),
            ("spherical", "ball"),
            ("weld", "fixed rigid"),
            ("free", "floating"),
            ("universal", "cardan hooke"),
            ("constant_velocity", "rzeppa"),
            ("screw", "helical"),
            ("pin_slot", "slot"),
            ("distance", "rod link"),
            ("point_on_curve", "cam"),
            ("rolling", "wheel disc"),
            ("knife_edge", "skate blade"),
        )
        for other in others.split()
    }
)
_USUAL_TYPES: Final = MappingProxyType(
    {"block": "pid", "constraint": "distance", "joint": "revolute", "shape": "box"}
)
_EXPECTED: Final = MappingProxyType(
    {
        "bool_type": "true or false",
        "string_type": "a string in quotes",
        "list_type": "a list",
        "tuple_type": "a list of an axis and an angle",
        "dict_type": "a table",
        "model_type": "a table",
        "model_attributes_type": "a table",
    }
)
_LISTS: Final = MappingProxyType(
    {
        "gravity": 'gravity = ["0", "-9.81", "0"]',
        "inertia": 'the moments about x, y and z of the body, such as inertia = ["0", "0", "I"]',
        "inputs": 'inputs = ["F"]',
    }
)
# An effort is called by the kind of coordinate along which it acts.
_EFFORTS: Final = MappingProxyType({"force": "torque", "torque": "force"})


def refuse_misfits(data: object, locate: Locate) -> None:
    """Refuse data that have not the structure of a model file.

    Raises
    ------
    FormatError
        With every key and value that does not fit.
    """
    try:
        ModelFile.model_validate(data)
    except ValidationError as error:
        found = cast("list[dict[str, Any]]", error.errors(include_url=False))
        newer = [item for item in found if item["type"] == "newer"]
        is_needed = any(item["type"] == "extra_forbidden" for item in found)
        schema: Schema = ModelFile.model_json_schema() if is_needed else {}
        problems = [_problem(item, schema, data, locate) for item in (newer or found)[:_MAX_PROBLEMS]]
        if len(found) > len(problems) and not newer:
            rest = f"{len(found) - len(problems)} more problems are not shown"
            problems.append(Problem("file.more", locate(()), rest, "", "fix the ones above first"))
        raise FormatError(*problems) from None


def _problem(found: dict[str, Any], schema: Schema, data: object, locate: Locate) -> Problem:
    path = _drop_tag(found["loc"])
    if found["type"] == "extra_forbidden":
        code, what, why = "unknown_key", f"there is no key {path[-1]!r} here", ""
        legal = _legal_keys(schema, found["loc"])
        other = _EFFORTS.get(str(path[-1]), "")
        fix = f"the key is called {other!r}" if other in legal else nearest(str(path[-1]), legal)
    else:
        code, what, why, fix = _explain(found, path)
    shown = ", ".join(part for part in (locate(path), _element(path, data), _inner(path)) if part)
    return Problem(f"file.{code}", shown, what, why, fix)


def _explain(finding: dict[str, Any], path: Path) -> tuple[str, str, str, str]:
    """Return code, fact, cause and cure of one finding."""
    kind, value = finding["type"], finding["input"]
    key = path[-1] if path else ""
    if kind == "missing" and isinstance(key, int):
        return "wrong_length", f"entry {key + 1} is missing", "", 'write both, such as ["z", "pi/2"]'
    if kind == "missing":
        return "missing_key", f"{key!r} is missing", "", f"add {key} = .."
    if kind == "newer":
        return (
            "newer_version",
            f"the file was made by a newer version of symbody: it has version {_short_text(value)}",
            f"this version of symbody reads versions up to {VERSION}",
            "update symbody",
        )
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _type_problem(finding, "shape" if "shape" in path[1:3] else str(path[0]))
    if kind in ("too_short", "too_long"):
        context = finding["ctx"]
        number = context.get("min_length") or context.get("max_length")
        return (
            "wrong_length",
            f"{context['actual_length']} entries instead of {number}",
            "",
            f"give {number} entries",
        )
    if kind == "not_finite":
        return "not_finite", f"the value is {value}", "", "give a finite number"
    expected = _EXPECTED.get(kind, finding["msg"])
    why = _causes(kind, value)
    cure = f"write {expected}"
    if expected == "a table" and key in ("force", "torque") and isinstance(value, str):
        cure = f'write {key} = {{ applied = "{value}" }}'
    elif kind == "list_type":
        is_section = len(path) == 1 and isinstance(value, Mapping) and key in KINDS
        cure = (
            f"write [[{key}]] instead of [{key}]" if is_section else f"write {_LISTS.get(str(key), expected)}"
        )
    return "wrong_type", f"{_short_text(value)} was found where {expected} is expected", why, cure


def _causes(kind: str, value: object) -> str:
    if kind == "string_type" and not isinstance(value, bool | list | dict):
        return "quotes are missing"
    return "true and false are not numbers" if isinstance(value, bool) else ""


def _type_problem(found: dict[str, Any], kind: str) -> tuple[str, str, str, str]:
    known = [name.strip("'") for name in found["ctx"].get("expected_tags", "").split(", ") if name]
    if not known:
        word = _USUAL_TYPES[kind]
        return "missing_key", "'type' is missing", "", f'add type = "{word}", for instance'
    tag = str(found["ctx"]["tag"])
    meant = OTHER_NAMES.get(tag.lower(), "")
    fix = f"the key is called {meant!r}" if meant in known else nearest(tag, known)
    return "unknown_type", f"there is no {kind} type {tag!r}", "", fix


def _legal_keys(root: Schema, location: Path) -> list[str]:
    """Return the keys of the table in which an unknown one was found, by walking the JSON Schema."""
    node = root
    for part in location[:-1]:
        node = _child(root, node, part)
    return list(node.get("properties", {}))


def _child(root: Schema, node: Schema, part: str | int) -> Schema:
    """Return the schema of an entry, a key, or of a joint by its type."""
    child: Schema = {}
    if isinstance(part, int):
        child = node.get("items", {})
    elif part in node.get("properties", {}):
        child = node["properties"][part]
    elif "discriminator" in node:
        child = {"$ref": node["discriminator"]["mapping"][part]}
    elif isinstance(node.get("additionalProperties"), dict):
        child = node["additionalProperties"]
    choices = [child, *child.get("anyOf", [])]  # a table that may be left out is "anyOf" it and null
    reference = next((choice["$ref"] for choice in choices if "$ref" in choice), None)
    return root["$defs"][reference.rpartition("/")[2]] if reference else child


def _drop_tag(location: tuple[str | int, ...]) -> Path:
    """Return a path without the type of joint, constraint or shape that pydantic inserts."""
    if location[:1] in _TYPED:
        return (*location[:2], *location[3:])
    if "shape" in location[:3] and location[0] in ("body", "ground"):
        place = location.index("shape") + 2
        return (*location[:place], *location[place + 1 :])
    return location


def _element(path: Path, data: object) -> str:
    """Return the label of the element in which a path lies, as the model writes it."""
    if len(path) < 2 or not isinstance(path[1], int) or path[0] not in KINDS:
        return ""
    entries = data.get(path[0]) if isinstance(data, Mapping) else None
    entry = entries[path[1]] if isinstance(entries, list) else None
    name = entry.get("name") if isinstance(entry, Mapping) else None
    return f"{path[0]} {name}" if isinstance(name, str) else f"{path[0]} {path[1] + 1}"


def _inner(path: Path) -> str:
    inside = len(path) >= 2 and isinstance(path[1], int) and path[0] in KINDS
    return words(path[2:] if inside else path)


def _short_text(value: object) -> str:
    if isinstance(value, int) and abs(value) >= _LARGE:  # Python declines to write out the largest
        return "a huge whole number"
    if isinstance(value, list | dict):  # perhaps nested without end
        text = reprlib.repr(value)
    else:
        text = str(value) if isinstance(value, Decimal) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
