"""Paths that model files contain: relative, and inside the folder of the model file."""

from __future__ import annotations

import os
import re
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Final

from symbody.errors import FormatError, ModelError, Problem, nearest

_DRIVE: Final = re.compile(r"[A-Za-z]:")
_WHY: Final = (
    "a model file may only refer to files in its own folder, so that it can be copied and shared with them"
)


def inner_path(path: str, folder: str, where: str) -> str:
    """Return where a file is that a model file names.

    Raises ModelError if the path is absolute, leaves the folder, also by a link, or if there is no such file.

    Parameters
    ----------
    path : str
        As it is written, with slashes.
    folder : str
        Of the model file; "" is the working directory.
    where : str
        What messages call the place of the path.
    """
    _check_words(path, where)
    root = os.path.realpath(folder or os.curdir)
    place = os.path.realpath(os.path.join(root, path))
    if not lies_within(place, root):
        what = f"{path!r} is a link that leaves the folder of the model file"
        raise _refusal("file.outside", where, what, _WHY, "copy the file into the folder")
    if not os.path.exists(place):
        why = "paths are relative to the folder of the model file"
        raise _refusal("file.missing", where, f"there is no file {path!r}", why, _similar(place, root))
    if not os.path.isfile(place):
        raise _refusal(
            "file.not_a_file", where, f"{path!r} is not a regular file", "", "choose a regular file"
        )
    return place


def lies_within(place: str, root: str) -> bool:
    """Return whether a place is a folder or below it, both without links."""
    try:
        return os.path.commonpath([root, place]) == root
    except ValueError:  # on another drive
        return False


def path_from(path: str, home: str, folder: str) -> str:
    """Return a path that begins in `home` from a folder, with slashes; the whole path if on another drive."""
    if os.path.realpath(folder) == os.path.realpath(home):
        return path
    place = os.path.join(home, path)
    try:
        return FilePath(os.path.relpath(place, folder)).as_posix()
    except ValueError:
        return FilePath(os.path.abspath(place)).as_posix()


def saved_path(path: str, home: str, folder: str | None, where: str, word: str, it: str) -> str:
    """Return a path as `path_from`, unchanged without a folder; a FormatError if it leaves that."""
    place = path if folder is None else path_from(path, home, folder)
    if place.startswith("..") or os.path.isabs(place):
        what = f"{path!r} is outside the folder in which the model is saved"
        why = "a model file may only refer to files in its own folder"
        fix = f"copy the {word} into the folder first, or save the model next to {it}"
        raise FormatError(Problem("file.outside", where, what, why, fix))
    return place


def _check_words(path: str, where: str) -> None:
    if not path.strip() or not path.isprintable() or "\\" in path:
        fix = 'write for instance "data/road.csv", with slashes'
        raise _refusal("file.bad_path", where, f"{path!r} is not the path of a file", "", fix)
    if os.path.isabs(path) or path.startswith(("/", "~")) or _DRIVE.match(path) or "://" in path:
        fix = f"put the file next to the model file and write {os.path.basename(path)!r}"
        what = f"{path!r} is not relative to the folder of the model file"
        raise _refusal("file.outside", where, what, _WHY, fix)
    if ".." in PurePosixPath(path).parts:
        fix = "put the file into the folder of the model file or one below it"
        raise _refusal("file.outside", where, f"{path!r} leaves the folder of the model file", _WHY, fix)


def _similar(place: str, root: str) -> str:
    try:
        names = sorted(os.listdir(os.path.dirname(place)))[:1000]
    except OSError:
        return f"there is no folder {os.path.relpath(os.path.dirname(place), root)!r} either"
    ending = os.path.splitext(place)[1]
    return nearest(os.path.basename(place), [name for name in names if name.endswith(ending)] or names)


def _refusal(code: str, where: str, what: str, why: str, fix: str) -> ModelError:
    return ModelError(Problem(code, where, what, why, fix))
