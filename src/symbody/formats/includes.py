"""The ``[[include]]`` tables of model files: parts that are model files themselves."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from symbody.errors import FormatError, ModelError, Problem
from symbody.formats.lines import Path
from symbody.formats.places import Locate, line_locator, relocate
from symbody.formats.reading import read_text
from symbody.formats.toml_syntax import parse_toml
from symbody.model.declarations.field import Node
from symbody.model.model import Model
from symbody.model.parts.include import Include
from symbody.model.tables.inner_path import inner_path, path_between

# Reads the model of JSON data: places, folder, and the files that are being read.
ReadModel = Callable[[object, Locate, str, tuple[str, ...]], Model]

KIND: Final = "include"


@dataclass(frozen=True, slots=True)
class IncludedParts:
    """The parts of a model file, and where things of theirs stand.

    Attributes
    ----------
    includes : tuple of Include
        One for each table.
    paths : mapping of label to path
        Where each included element stands, as a path that `locate` understands.
    locate : callable
        Places of the model file, behind them those of the part's file.
    """

    includes: tuple[Include, ...]
    paths: Mapping[str, Path]
    locate: Locate


def read_includes(
    entries: Sequence[Mapping[str, Any]],
    locate: Locate,
    folder: str,
    reading: tuple[str, ...],
    read: ReadModel,
) -> IncludedParts:
    """Return the parts of the tables of a model file.

    Raises
    ------
    FormatError, ModelError
        With file and line of the part, for what is wrong in it.
    """
    includes: list[Include] = []
    paths: dict[str, Path] = {}
    places: list[Locate] = []
    problems: list[Problem] = []
    for k, entry in enumerate(entries):
        path: Path = (KIND, k)
        paths[f"{KIND} {entry['prefix']}"] = path
        try:
            part, where = _read_part(entry, f"{locate((*path, 'file'))}, include {entry['prefix']}", folder,
                                     reading, read)  # fmt: skip
            includes.append(_make(entry, part, folder))
            places.append(where)
        except ModelError as error:
            problems += _fault_places(error.problems, entry, path, locate)
            continue
        for element in part.elements:
            own = [other for other in part.elements if other.kind == element.kind]
            paths[f"{element.kind} {entry['prefix']}_{element.name}"] = (
                *path, "of", len(places) - 1, element.kind, own.index(element)
            )  # fmt: skip
    if problems:
        raise ModelError(*problems)

    def locate_part(path: Path) -> str:
        if path[:1] != (KIND,) or path[2:3] != ("of",):
            return locate(path)
        return f"{locate(path[:2])}, {places[int(path[3])](path[4:])}"

    return IncludedParts(tuple(includes), paths, locate_part)


def _fault_places(
    problems: Sequence[Problem], entry: Mapping[str, Any], path: Path, locate: Locate
) -> Sequence[Problem]:
    """Return faults of the table with its line; those of the part's file have theirs."""
    label = f"{KIND} {entry['prefix']}"
    of_table = all(problem.where.startswith(label) for problem in problems)
    return relocate(problems, {label: path}, locate) if of_table else problems


def _read_part(
    entry: Mapping[str, Any], where: str, folder: str, reading: tuple[str, ...], read: ReadModel
) -> tuple[Model, Locate]:
    """Return the model of a part's file, and what finds lines in it."""
    file = str(entry["file"])
    place = inner_path(file, folder, where)
    if place in reading:
        names = [os.path.basename(name) for name in (*reading[reading.index(place) :], place)]
        raise ModelError(
            Problem("include.circle", where, f"the file includes itself: {' -> '.join(names)}",
                    "a part would contain itself endlessly", "remove one of these includes")
        )  # fmt: skip
    shown = os.path.join(folder, file)
    try:
        text = read_text(place)
        places = line_locator(text, shown)
        return read(parse_toml(text, shown), places, os.path.dirname(shown), (*reading, place)), places
    except FormatError as error:
        raise ModelError(*error.problems) from error


def _make(entry: Mapping[str, Any], part: Model, folder: str) -> Include:
    return Include(
        part,
        entry["prefix"],
        entry.get("at", "ground"),
        entry.get("connect", {}),
        entry.get("share", ()),
        entry.get("parameters", {}),
        file=entry["file"],
        folder=folder,
    )


def include_entry(include: Include, folder: str | None) -> dict[str, Node]:
    """Return the table of an include; its path leads from `folder`, None leaves it as it is.

    Raises
    ------
    FormatError
        If the part lies outside of the folder.
    """
    place = include.file
    if folder is not None and os.path.realpath(folder) != os.path.realpath(include.folder):
        place = path_between(os.path.join(include.folder, include.file), folder)
    if place.startswith("..") or os.path.isabs(place):
        raise FormatError(
            Problem("file.outside", f"include {include.prefix}, file",
                    f"{include.file!r} is outside the folder in which the model is saved",
                    "a model file may only refer to files in its own folder",
                    "copy the part into the folder first, or save the model next to it")
        )  # fmt: skip
    entry: dict[str, Node] = {"file": place, "prefix": include.prefix}
    if include.at.full_name != "ground":
        entry["at"] = include.at.full_name
    if include.share:
        entry["share"] = list(include.share)
    for key in ("connect", "parameters"):
        values = getattr(include, key)
        if values:
            entry[key] = dict(values)
    return entry
