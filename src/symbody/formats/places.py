"""Where things stand in a model file: lines of a TOML text, and places as messages write them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.errors import Problem

Path = tuple[str | int, ...]

_TOKEN: Final = re.compile(
    r"(?P<string>\"\"\"(?:[^\\]|\\.)*?\"{3,5}|'''.*?'{3,5}|\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*')"
    r"|(?P<comment>\#[^\n]*)"
    r"|(?P<newline>\n)"
    r"|(?P<mark>[\[\]{},=.])"
    r"|(?P<word>[^\s\[\]{},=.\"'\#]+)",
    re.DOTALL,
)
_ESCAPE: Final = re.compile(r"\\(?:u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(.))", re.DOTALL)
_ESCAPES: Final = MappingProxyType({"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", "e": "\x1b"})


class _Token(NamedTuple):
    kind: str
    text: str
    line: int


def key_lines(text: str) -> dict[Path, int]:
    """Return the line, counted from 1, on which each key and each entry of a list begins."""
    return _Scanner(text).lines


def find_line(lines: dict[Path, int], path: Path) -> int | None:
    """Return the line of the innermost part of `path` that has one."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


class _Scanner:
    """Walks through one text; made for it and dropped."""

    __slots__ = ("_counts", "_tokens", "lines")

    def __init__(self, text: str) -> None:
        self.lines: dict[Path, int] = {}
        self._counts: dict[Path, int] = {}  # entries so far of each array of tables
        self._tokens = _tokens(text)
        table: Path = ()
        for token in self._tokens:
            if token.text == "[" and token.kind == "mark":
                table = self._header()
            elif token.kind in ("word", "string"):
                self._pair(token, table)

    def _header(self) -> Path:
        """Read a table header behind its first bracket; return the path of the table."""
        first = next(self._tokens)
        is_array = first.kind == "mark"
        keys = self._keys(next(self._tokens) if is_array else first, "]")
        path: Path = ()
        for key in keys[:-1]:
            self.lines.setdefault((*path, key), first.line)
            path = self._last_entry((*path, key))
        path = (*path, keys[-1])
        self.lines.setdefault(path, first.line)
        if not is_array:
            return self._last_entry(path)
        next(self._tokens)  # the second closing bracket
        self._counts[path] = self._counts.get(path, 0) + 1
        path = self._last_entry(path)
        self.lines[path] = first.line
        return path

    def _last_entry(self, path: Path) -> Path:
        """Return the path of the last entry if `path` is an array of tables."""
        count = self._counts.get(path)
        return path if count is None else (*path, count - 1)

    def _keys(self, token: _Token, closing: str) -> list[str]:
        """Read a dotted key that begins with `token`, up to the mark `closing`."""
        keys = []
        while not (token.kind == "mark" and token.text == closing):
            if token.kind in ("word", "string"):
                keys.append(_unquote(token.text))
            token = next(self._tokens)
        return keys

    def _key(self, token: _Token, table: Path) -> Path:
        """Read a key up to its equals sign, and note the line of each of its parts."""
        path = table
        for key in self._keys(token, "="):
            path = (*path, key)
            self.lines.setdefault(path, token.line)
        return path

    def _pair(self, token: _Token, table: Path) -> None:
        """Read a key and its value, to the end of the line on which the value ends."""
        path = self._key(token, table)
        opened: list[tuple[Path, bool]] = []  # path of each open bracket, and whether it is a list
        places: list[int] = []  # next entry of each
        is_fresh = True  # a value, or a key of an inline table, comes next
        for token in self._tokens:
            if token.kind == "newline" and not opened:
                return
            if token.kind == "mark" and token.text in ",]}":
                is_fresh = token.text == ","
                if not is_fresh:
                    opened.pop()
                    places.pop()
            elif is_fresh and token.kind != "newline":
                is_fresh = False
                if opened:
                    token, path = self._item(token, opened[-1], places)
                if token.kind == "mark":
                    opened.append((path, token.text == "["))
                    places.append(0)
                    is_fresh = True

    def _item(self, token: _Token, opened: tuple[Path, bool], places: list[int]) -> tuple[_Token, Path]:
        """Enter an item of a list or inline table; return the first token of its value, and its path."""
        container, is_list = opened
        if not is_list:
            path = self._key(token, container)
            return next(item for item in self._tokens if item.kind != "newline"), path
        path = (*container, places[-1])
        places[-1] += 1
        self.lines[path] = token.line
        return token, path


def _tokens(text: str) -> Iterator[_Token]:
    line = 1
    for found in _TOKEN.finditer(text):
        kind = found.lastgroup or ""
        if kind != "comment":
            yield _Token(kind, found.group(), line)
        line += found.group().count("\n")


def _unquote(key: str) -> str:
    if key[0] == "'":
        return key[1:-1]
    return _ESCAPE.sub(_character, key[1:-1]) if key[0] == '"' else key


def _character(found: re.Match[str]) -> str:
    code = found.group(1) or found.group(2)
    return chr(int(code, 16)) if code else _ESCAPES.get(found.group(3), found.group(3))


# Takes the path of a key; returns the place, such as "model.toml:12".
Locate = Callable[[Path], str]


def line_locator(text: str, where: str) -> Locate:
    """Return what finds keys in a legal TOML text called `where`."""
    lines = key_lines(text)

    def locate(path: Path) -> str:
        line = find_line(lines, path)
        return where if line is None else f"{where}:{line}"

    return locate


def pointer(path: Path) -> str:
    """Return the JSON pointer of a key, as a fragment: ``"#/joint/2/axis"``."""
    parts = (str(part).replace("~", "~0").replace("/", "~1") for part in path)
    return "#" + "".join(f"/{part}" for part in parts)


def relocate(problems: Iterable[Problem], bases: Mapping[str, Path], locate: Locate) -> list[Problem]:
    """Return problems of a model with the place in the file put before the words of the model.

    Parameters
    ----------
    bases : mapping of label to path
        Where each element stands: ``{"joint slider": ("joint", 0)}``; "model" is the file itself.
    """
    return [
        replace(
            problem,
            where="; ".join(_add_location(part, bases, locate) for part in _places(problem.where, bases)),
        )
        for problem in problems
    ]


def _places(where: str, labels: Iterable[str]) -> list[str]:
    """Return the places that a message names: each begins with a label, in which ``"; "`` may stand."""
    pieces = where.split("; ")
    found = pieces[:1]
    for piece in pieces[1:]:
        is_inside = any(label.startswith(f"{found[-1]}; {piece.partition(', ')[0]}") for label in labels)
        found = [*found[:-1], f"{found[-1]}; {piece}"] if is_inside else [*found, piece]
    return found


def words(path: Path) -> str:
    """Return the path of a key as the model writes it: ``"frames.tip.at[1]"``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def _add_location(where: str, bases: Mapping[str, Path], locate: Locate) -> str:
    label = max((label for label in bases if f"{where}, ".startswith(f"{label}, ")), key=len, default=None)
    if label is None:
        return ", ".join(part for part in (locate(()), where) if part)
    rest = where[len(label) :].removeprefix(", ")
    key = rest.partition(", ")[0]
    parts = re.findall(r"\[(\d+)\]|([^.\[\]]+)", key)
    path = (*bases[label], *(int(place) if place else name for place, name in parts))
    shown = [rest] if label == "model" else [label, rest]
    return ", ".join(part for part in (locate(path), *shown) if part)
