"""A model as a Python script that builds it anew; a file's words are those of the constructors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.body import GROUND_FRAMES
from symbody.model.declarations.field import FileTarget, Node
from symbody.model.element import Element
from symbody.model.model import Model
from symbody.model.registry import write_element
from symbody.model.shapes.shape import GROUND_SHAPES, shape_types

_WIDTH: Final = 100
_NUMBER: Final = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?")
# Values that are parts of their own, by the key they stand under.
_PARTS: Final = MappingProxyType({"force": "Drive", "torque": "Drive", "friction": "Friction"})
_INDENT: Final = "    "
_TARGET: Final = FileTarget(is_alone=True)


def model_to_script(model: Model) -> str:
    """Return a Python script in which ``model`` is an equal model.

    Only names, numbers and texts are written, each as Python writes it: nothing of a model is code. The
    script needs no other file but those of meshes: it holds what is in parts and tables.
    """
    elements = [_element(element) for element in model.elements]
    arguments = [_text(model.name), _list(elements)]
    arguments += [f"gravity={_value(list(model.gravity))}"]
    if model.parameters:
        arguments.append(f"parameters={_parameters(model.parameters)}")
    if model.inputs:
        arguments.append(f"inputs={list(model.inputs)!r}")
    if model.initial:
        arguments.append(f"initial={_initial(model)}")
    if model.ground:
        arguments.append(f"ground={_frames(GROUND_FRAMES.to_file(None, model.ground, _TARGET))}")
    if model.ground_shapes:
        arguments.append(
            f"ground_shapes={_shapes(GROUND_SHAPES.to_file(None, model.ground_shapes, _TARGET))}"
        )
    first = f'"""{_title(model.name)}, written by symbody."""'
    return f"{first}\n\nimport symbody as sb\n\nmodel = {_call('sb.Model', arguments)}\n"


def _initial(model: Model) -> str:
    """Return first values; those that hold say so."""
    values = {name: _value(formula) for name, formula in model.initial.items()}
    held = {name: _call("sb.Initial", [values[name], 'priority="hold"']) for name in model.held_initial}
    return _dict_text({**values, **held})


def _title(name: str) -> str:
    """Return a name as it may stand in a docstring."""
    return "".join(letter for letter in name if letter.isprintable() and letter not in '\\"') or "A model"


def _element(element: Element) -> str:
    entry = write_element(element, _TARGET)
    entry.pop("type", None)
    arguments = [_value(entry.pop("name"))]
    between = entry.pop("between", None)
    if isinstance(between, list):
        arguments += [f"start={_value(between[0])}", f"end={_value(between[1])}"]
    for key, node in entry.items():
        name = "shapes" if key == "shape" else key
        arguments.append(f"{name}={_argument(element.kind, key, node)}")
    return _call(f"sb.{type(element).__name__}", arguments)


def _argument(kind: str, key: str, node: Node) -> str:
    if key == "shape":
        return _shapes(node)
    if key == "frames":
        return _frames(node)
    part = _PARTS.get(key) if kind == "joint" else None
    if part == "Drive" and isinstance(node, dict) and not _is_drive(node):
        return _dict_text({name: _part(part, drive) for name, drive in node.items()})
    return _part(part, node) if part and isinstance(node, dict) else _value(node, key)


def _is_drive(node: Mapping[str, Node]) -> bool:
    """Return whether a table is a drive, and not one of drives by coordinate."""
    keyed = all(isinstance(item, dict) for item in node.values()) and bool(node)
    law = node.get("law")
    is_curve = isinstance(law, dict) and "x" in law
    return not keyed or is_curve


def _part(name: str, node: Node) -> str:
    if not isinstance(node, dict):
        return _value(node)
    return _call(f"sb.{name}", [f"{key}={_value(item, key)}" for key, item in node.items()])


def _frames(node: Node | None) -> str:
    assert isinstance(node, dict)
    return _dict_text({name: _part("Frame", frame) for name, frame in node.items()})


def _shapes(node: Node | None) -> str:
    assert isinstance(node, list)
    calls = []
    for entry in node:
        assert isinstance(entry, dict)
        maker = shape_types()[str(entry["type"])]
        calls.append(_part(maker.__name__, {key: item for key, item in entry.items() if key != "type"}))
    return _list(calls)


def _parameters(parameters: Mapping[str, Formula | None]) -> str:
    return _dict_text(
        {name: "None" if value is None else _value(value) for name, value in parameters.items()}
    )


def _value(node: Node, key: str = "") -> str:
    """Return a value as Python writes it; numbers stay numbers where they keep their digits."""
    if isinstance(node, Formula):
        return _number(node) or _text(node.text)
    if isinstance(node, dict):
        if key == "law":
            return _part("Curve", node)
        return _dict_text({name: _value(item) for name, item in node.items()})
    if isinstance(node, list):
        return "[" + ", ".join(_value(item) for item in node) + "]"
    return repr(node) if isinstance(node, int) else _text(node)


def _number(formula: Formula) -> str | None:
    text = formula.text
    if not _NUMBER.fullmatch(text):
        return None
    value = float(text) if "." in text else int(text)
    return text if Formula.from_value(value) == formula else None


def _text(value: str) -> str:
    """Return a text in double quotes, as far as it has none itself."""
    shown = repr(value)
    return f'"{shown[1:-1]}"' if shown[0] == "'" and '"' not in shown else shown


def _dict_text(items: Mapping[str, str]) -> str:
    return _break_lines("{", [f"{_text(name)}: {value}" for name, value in items.items()], "}")


def _list(items: Iterable[str]) -> str:
    return _break_lines("[", list(items), "]")


def _call(name: str, arguments: list[str]) -> str:
    return _break_lines(f"{name}(", arguments, ")")


def _break_lines(opening: str, parts: list[str], closing: str) -> str:
    """Return parts in brackets: in one line, or a line each where that is too long."""
    line = opening + ", ".join(parts) + closing
    if len(line) <= _WIDTH and "\n" not in line:
        return line
    inner = "".join(f"{_INDENT}{part},\n".replace("\n", f"\n{_INDENT}")[: -len(_INDENT)] for part in parts)
    return f"{opening}\n{inner}{closing}"
