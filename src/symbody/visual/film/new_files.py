"""Files that appear when they are finished: until then, and after a fault, what was there before stays."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from symbody.errors import EnvironmentFault, Problem
from symbody.storage import new_file_mode


@contextmanager
def file_replacement(path: Path) -> Iterator[Path]:
    """Yield the path of a new file beside `path`, with the same suffix, that takes its place at the end.

    Raises
    ------
    EnvironmentFault
        If there can be no file.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=".", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise _unwritable(path, error) from error
    draft = Path(name)
    try:
        yield draft
        draft.chmod(new_file_mode())
        draft.replace(path)
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        draft.unlink(missing_ok=True)


def _unwritable(path: Path, error: OSError) -> EnvironmentFault:
    return EnvironmentFault(
        Problem("film.unwritable", str(path), f"the picture cannot be written: {error.strerror or error}",
                fix="choose a folder that exists, is yours and has room")
    )  # fmt: skip
