"""A model as a Python script that builds it anew; a file's words are those of the constructors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.field import FileTarget
from symbody.model.element import Element
from symbody.model.model import Model

_WIDTH: Final = 100
_NUMBER: Final = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?")
_INDENT: Final = "    "
_TARGET: Final = FileTarget(is_alone=True, is_script=True)


def model_to_script(model: Model) -> str:
    """Return a Python script in which ``model`` is an equal model.

    Only names, numbers and texts are written, each as Python writes it: nothing of a model is code. The
    script needs no other file but those of meshes: it holds what is in parts and tables.
    """
    elements = [_element(element) for element in model.elements]
    arguments = [_text(model.name), _list(elements)]
    arguments += [f"gravity={_value(list(model.gravity))}"]
    if model.parameters:
        values = {name: "None" if x is None else _value(x) for name, x in model.parameters.items()}
        arguments.append(f"parameters={_dict_text(values)}")
    if model.inputs:
        arguments.append(f"inputs={list(model.inputs)!r}")
    if model.initial:
        arguments.append(f"initial={_initial(model)}")
    if model.ground:
        arguments.append(f"ground={_value(dict(model.ground))}")
    if model.ground_shapes:
        arguments.append(f"ground_shapes={_value(list(model.ground_shapes))}")
    first = f'"""{_title(model.name)}, written by symbody."""'
    return f"{first}\n\nimport symbody as sb\n\nmodel = {_call('sb.Model', arguments)}\n"


def _initial(model: Model) -> str:
    values = {name: _value(formula) for name, formula in model.initial.items()}
    held = {name: _call("sb.Initial", [values[name], 'priority="hold"']) for name in model.held_initial}
    return _dict_text({**values, **held})


def _title(name: str) -> str:
    """Return a name as it may stand in a docstring."""
    return "".join(letter for letter in name if letter.isprintable() and letter not in '\\"') or "A model"


def _element(element: Element) -> str:
    entry = element.to_entry(_TARGET)
    arguments = [_value(element.name)]
    between = entry.pop("between", None)
    if isinstance(between, list):
        arguments += [f"start={_value(between[0])}", f"end={_value(between[1])}"]
    entry.pop("name", None)
    arguments += [f"{'shapes' if key == 'shape' else key}={_value(node)}" for key, node in entry.items()]
    return _call(f"sb.{type(element).__name__}", arguments)


def _value(node: object) -> str:
    """Return a value as Python writes it; numbers stay numbers where they keep their digits."""
    if isinstance(node, Formula):
        return _number(node) or _text(node.text)
    if isinstance(node, Declared):
        entry = node.to_entry(_TARGET)
        return _call(f"sb.{type(node).__name__}", [f"{key}={_value(item)}" for key, item in entry.items()])
    if isinstance(node, dict):
        return _dict_text({name: _value(item) for name, item in node.items()})
    if isinstance(node, list):
        has_parts = any(isinstance(item, Declared) for item in node)
        return _list(map(_value, node)) if has_parts else f"[{', '.join(map(_value, node))}]"
    return _text(node) if isinstance(node, str) else repr(node)


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
