"""Between the text of a model file and the data that the page edits, complete or not.

A mechanism under construction is not a model yet: it is opened, saved and recovered as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Final, cast

from tomlkit.exceptions import TOMLKitError

from symbody.builder.page_problems import PageProblem, page_notes, page_problems, pointer_parts
from symbody.errors import FormatError, Problem, SymbodyError, number_in_words
from symbody.expr.language.formula import Formula
from symbody.formats.native import from_data, model_to_toml, read_layout, to_data
from symbody.formats.places import find_line, key_lines
from symbody.formats.reading import parse_toml
from symbody.formats.toml_text import key_comments, write_layout, write_toml
from symbody.model.declarations.field import Node
from symbody.model.model import Model
from symbody.model.parts.include import Include

_MARK: Final = "\N{ZERO WIDTH NO-BREAK SPACE}"
# Texts that are none but look like numbers: orders of turns such as "313", and names.
_WORDS: Final = frozenset({"angles", "name"})


@dataclass(frozen=True, slots=True)
class Opened:
    """What a text says.

    Attributes
    ----------
    data : dict
        JSON form of the file, with formulas and numbers as texts, and with ``layout`` where there is one.
    model : Model or None
        None where the data are not a model.
    problems : list of dict
        Why they are none, for the page.
    comments : mapping of name to str
        What the file says behind its parameters.
    """

    data: dict[str, Any]
    model: Model | None
    problems: list[PageProblem]
    comments: Mapping[str, str] = field(default_factory=dict)


def data_from_text(text: str, name: str, folder: str = "") -> Opened:
    """Return the data of a model file; paths of parts and tables begin in `folder`.

    Raises
    ------
    FormatError
        If it is not TOML: nothing of it can be edited.
    """
    plain = _plain(text)
    content = parse_toml(plain, name)
    data = _as_texts(content)
    comments = key_comments(plain, "parameters")
    try:
        model = from_data(content, folder=folder)
    except SymbodyError as error:
        lines = key_lines(plain)
        problems = [_with_line(each, lines) for each in page_problems(error.problems, data)]
        return Opened(data, None, problems, comments)
    layout = content.get("layout")
    content_data = to_data(model)
    notes = [_part_note(include) for include in model.includes]
    data = {**content_data, "layout": layout} if layout else content_data
    return Opened(data, model, page_notes(notes, data), comments)


def _part_note(include: Include) -> str:
    count = number_in_words(len(include.part.elements), "element")
    return (
        f"part {include.prefix} of {include.file}, {count}: it is simulated with the model and saved with "
        f"the file; the diagram shows it as one box. Edit the part in its own file"
    )


def text_from_data(data: Mapping[str, Any], onto: str = "", folder: str = "") -> str:
    """Return the text of a model file.

    Parameters
    ----------
    onto : str
        The text that was there; where it says the same it is kept to the byte, line ends too.
    folder : str
        Where paths of parts and tables begin.

    Raises
    ------
    FormatError
        If the data hold something that no file can say.
    """
    plain = _plain(onto)
    text = _text(data, plain, folder)
    if text == plain:
        return onto
    if "\r\n" in onto:
        text = text.replace("\n", "\r\n")
    return _MARK + text if onto.startswith(_MARK) else text


def _text(data: Mapping[str, Any], onto: str, folder: str) -> str:
    """Return the text in which lines end with line feeds."""
    try:
        model = from_data(data, folder=folder)
        is_base = _is_model(onto, folder)
        text = model_to_toml(model, onto, folder=folder) if is_base else _incomplete_text(data, onto)
    except SymbodyError:
        text = _incomplete_text(data, onto)
    layout = data.get("layout") or {}
    try:
        old = read_layout(text)
    except FormatError:
        old = {}
    return text if _same(old, layout) else _with_layout(text, layout)


def _is_model(text: str, folder: str) -> bool:
    """Return whether a text is a model file, or nothing at all: what a complete model can be written onto."""
    try:
        return not text.strip() or data_from_text(text, "", folder).model is not None
    except FormatError:
        return True  # nothing of it can be kept


def _with_layout(text: str, layout: Mapping[str, Any]) -> str:
    try:
        return write_layout(text, _drop_nulls(layout))
    except (TypeError, ValueError, RecursionError, TOMLKitError) as error:
        raise FormatError(
            Problem("file.layout", "layout", f"it cannot be written to a file: {error}",
                    fix="remove layout: the diagram then places its parts itself")
        ) from None  # fmt: skip


def _incomplete_text(data: Mapping[str, Any], onto: str) -> str:
    """Return the text of data that are not a model, on an older text where that is possible."""
    content = _nodes(_drop_nulls({key: value for key, value in data.items() if key != "layout"}))
    try:
        before = _nodes(_no_layout(data_from_text(onto, "").data)) if onto.strip() else {}
        text = write_toml(content, onto, before)
        if _says(_nodes(_as_texts(_no_layout(parse_toml(text, "")))), content, before):
            return text
    except (SymbodyError, TOMLKitError, TypeError, ValueError, KeyError):
        pass  # what was there is no base for it
    try:
        return write_toml(content)
    except (TOMLKitError, TypeError, ValueError) as error:
        raise FormatError(
            Problem("builder.not_writable", "model", f"it cannot be written to a file: {error}",
                    fix="undo the last change")
        ) from None  # fmt: skip


def _says(whole: Node | None, part: Node, before: Node | None) -> bool:
    """Return whether a text says all of a content; what did not change it says as it did before."""
    if part == before:
        return True
    if isinstance(whole, dict) and isinstance(part, dict):
        old = before if isinstance(before, dict) else {}
        return all(_says(whole.get(key), node, old.get(key)) for key, node in part.items())
    if isinstance(whole, list) and isinstance(part, list):
        old_entries = _index_by_name(before)
        return len(whole) == len(part) and all(
            _says(each, node, old_entries.get(_name(node))) for each, node in zip(whole, part, strict=True)
        )
    return whole == part


def _index_by_name(nodes: Node | None) -> dict[str, Node]:
    return {_name(node): node for node in nodes if _name(node)} if isinstance(nodes, list) else {}


def _name(node: Node) -> str:
    name = node.get("name") if isinstance(node, dict) else None
    return name if isinstance(name, str) else ""


def _no_layout(content: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in content.items() if key != "layout"}


def _nodes(value: Mapping[str, Any]) -> dict[str, Node]:
    return {key: _node(entry, key) for key, entry in value.items()}


def _node(value: Any, key: str = "") -> Node:
    """Return data as the writer takes them: texts that are numbers become numbers again."""
    if isinstance(value, Mapping):
        return _nodes(value)
    if isinstance(value, list):
        return [_node(entry) for entry in value]
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float | Decimal):
        return _formula(str(value)) or str(value)
    if isinstance(value, str):
        number = None if key in _WORDS else _formula(value)
        return number if number is not None and number.is_number else value
    raise FormatError(
        Problem("builder.not_writable", key, f"{type(value).__name__} cannot be written to a file",
                fix="give a text, a number, True or False, a list or a mapping")
    )  # fmt: skip


def _formula(text: str) -> Formula | None:
    if not text or not (text[-1].isdigit() and text.lstrip("-")[:1].isdigit()):
        return None
    try:
        return Formula.from_value(text)
    except SymbodyError:
        return None


def _as_texts(value: Any, key: str = "") -> Any:
    """Return TOML data with numbers as texts, so that none changes its digits on the way through the page."""
    if isinstance(value, Mapping):
        return {name: entry if name == "layout" else _as_texts(entry, name) for name, entry in value.items()}
    if isinstance(value, list):
        return [_as_texts(entry) for entry in value]
    if isinstance(value, bool | str) or value is None or key == "version":
        return value
    return str(value)


def _drop_nulls(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _drop_nulls(entry) for key, entry in value.items() if entry is not None}
    return [_drop_nulls(entry) for entry in value] if isinstance(value, list) else value


def _same(old: Any, new: Any) -> bool:
    """Return whether two layouts say the same: 1 and 1.0 do."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        return old.keys() == new.keys() and all(_same(old[key], new[key]) for key in old)
    if isinstance(old, list) and isinstance(new, list):
        return len(old) == len(new) and all(_same(a, b) for a, b in zip(old, new, strict=True))
    numbers = (int, float, Decimal)
    if isinstance(old, numbers) and isinstance(new, numbers):
        return float(old) == float(new)
    return bool(old == new)


def _plain(text: str) -> str:
    return text.removeprefix(_MARK).replace("\r\n", "\n")


def _with_line(problem: PageProblem, lines: Mapping[Any, int]) -> PageProblem:
    parts = pointer_parts(problem["pointer"])
    path = tuple(int(part) if part.isdecimal() else part for part in parts)
    return {**problem, "line": find_line(cast("dict[Any, int]", lines), path)}
