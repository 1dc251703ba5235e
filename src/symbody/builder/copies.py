"""Files that a model names, copied beside it where it is saved in another folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from typing import Any, Final

from symbody.errors import SymbodyError
from symbody.formats.reading import parse_toml, read_text
from symbody.model.tables.inner_path import inner_path, lies_within

_DEEPEST: Final = 8  # parts of parts
_ENDINGS: Final = (".toml", ".csv")


def copy_files(data: Mapping[str, Any], before: str, folder: str, depth: int = 0) -> None:
    """Copy parts and tables of a model from the folder `before`, as far as they are not there already.

    What is missing, or lies outside the folder, is left out: the check of the model names it.
    """
    if depth > _DEEPEST or os.path.realpath(before) == os.path.realpath(folder):
        return
    for kind, file in _named_files(data):
        try:
            source, target = inner_path(file, before, file), _target(file, folder)
            if not os.path.exists(target):
                os.makedirs(os.path.dirname(target), exist_ok=True)
                shutil.copyfile(source, target)
            if kind == "include":
                part = parse_toml(read_text(source), file)
                copy_files(part, os.path.dirname(source), os.path.dirname(target), depth + 1)
        except (SymbodyError, OSError):
            continue


def _target(file: str, folder: str) -> str:
    """Return where a file goes; it stays inside the folder, also where that holds links.

    Raises
    ------
    OSError
        If it would leave the folder.
    """
    root = os.path.realpath(folder)
    target = os.path.join(root, file)
    if not lies_within(os.path.realpath(target), root):
        raise OSError(f"{file} leads out of {folder}")
    return target


def _named_files(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for kind in ("include", "table"):
        entries = data.get(kind)
        for entry in entries if isinstance(entries, list) else []:
            file = entry.get("file") if isinstance(entry, Mapping) else None
            if isinstance(file, str) and file.lower().endswith(_ENDINGS):
                yield kind, file
