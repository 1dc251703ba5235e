"""What does not fit the structure of a model file: misfits of its roles, each with its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, cast

from symbody.errors import FormatError, Problem
from symbody.formats.places import Locate, words
from symbody.formats.schema import NEWER, model_table
from symbody.model.declarations.misfits import Misfit, Path
from symbody.model.model import KINDS

_MAX_PROBLEMS: Final = 50


def check_structure(data: object, locate: Locate) -> Mapping[str, Any]:
    """Return `data`, which has only known keys, all that are needed, and values of the right types.

    Raises
    ------
    FormatError
        With every key and value that does not fit.
    """
    misfits = list(model_table().misfits(data, ()))
    if not misfits:
        return cast("Mapping[str, Any]", data)
    newer = [misfit for misfit in misfits if misfit.code == NEWER]
    problems = [_problem(misfit, data, locate) for misfit in (newer or misfits)[:_MAX_PROBLEMS]]
    if len(misfits) > len(problems) and not newer:
        rest = f"{len(misfits) - len(problems)} more problems are not shown"
        problems.append(Problem("file.more", locate(()), rest, "", "fix the ones above first"))
    raise FormatError(*problems)


def _problem(misfit: Misfit, data: object, locate: Locate) -> Problem:
    path = misfit.path
    shown = ", ".join(part for part in (locate(path), _element(path, data), _inner(path)) if part)
    return Problem(f"file.{misfit.code}", shown, misfit.what, misfit.why, misfit.fix)


def _element(path: Path, data: object) -> str:
    """Return the label of the element in which a path lies, as the model writes it."""
    if not _is_inside(path):
        return ""
    entries = data.get(path[0]) if isinstance(data, Mapping) else None
    entry = entries[int(path[1])] if isinstance(entries, list) else None
    name = entry.get("name") if isinstance(entry, Mapping) else None
    return f"{path[0]} {name}" if isinstance(name, str) else f"{path[0]} {int(path[1]) + 1}"


def _inner(path: Path) -> str:
    return words(path[2:] if _is_inside(path) else path)


def _is_inside(path: Path) -> bool:
    return len(path) >= 2 and isinstance(path[1], int) and path[0] in KINDS
