"""Files of users are not overwritten without a word."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from symbody.errors import Problem, UsageError

# What pictures and pages that symbody writes have near their beginning, and how far that is looked for.
_MARKS: Final = (b"Software\x00symbody", b'<meta name="generator" content="symbody')
_REACH: Final = 4096


def refuse_overwriting(path: Path, force: bool, *, is_default: bool = False) -> None:
    """Refuse a path where a file is, unless it may be overwritten.

    Parameters
    ----------
    is_default : bool
        Whether nobody gave the path: then a picture or page that symbody wrote there is made anew.

    Raises
    ------
    UsageError
        If there is a file.
    """
    if not path.exists() or force or (is_default and _is_ours(path)):
        return
    if not is_default:
        raise UsageError(Problem("cli.file_exists", str(path), "the file already exists", "", "add --force"))
    raise UsageError(
        Problem("cli.file_exists", str(path), "the file already exists, and symbody did not write it",
                "results are written next to the model, under its name",
                "add --force, or choose another file with --out")
    )  # fmt: skip


def _is_ours(path: Path) -> bool:
    """Return whether a picture or page was written by symbody."""
    try:
        with path.open("rb") as file:
            head = file.read(_REACH)
    except OSError:
        return False
    return any(mark in head for mark in _MARKS)
