"""From the words of a message to the place in the file: a line, or a pointer into JSON data."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from symbody.errors import Problem
from symbody.formats.lines import Path, find_line, key_lines

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
