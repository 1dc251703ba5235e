"""Files of users are not overwritten without a word."""

from __future__ import annotations

from pathlib import Path

from symbody.errors import Problem, UsageError


def refuse_overwriting(path: Path, force: bool) -> None:
    """Refuse a path where a file is, unless it may be overwritten.

    Raises
    ------
    UsageError
        If there is a file.
    """
    if path.exists() and not force:
        raise UsageError(Problem("cli.file_exists", str(path), "the file exists already", "", "add --force"))
