"""Text to a file so that neither a crash nor a full disk can cost the old content."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import tempfile
from pathlib import Path
from types import MappingProxyType
from typing import Final

from symbody.errors import FormatError, Problem
from symbody.storage import create_file, move_into_place

_CURES: Final = MappingProxyType(
    {
        errno.ENOSPC: "free some space, or choose another disk",
        errno.EDQUOT: "free some space, or choose another disk",
        errno.EROFS: "choose a place that can be written to",
        errno.EACCES: "choose a place that can be written to, or change the permissions",
        errno.EPERM: "choose a place that can be written to, or change the permissions",
        errno.ENOENT: "create the directory first, or check the path",
        errno.ENOTDIR: "check the path: a part of it is a file",
        errno.EISDIR: "give the path of a file, not a directory",
        errno.ELOOP: "fix the symbolic links",
    }
)


def write_text(path: str | os.PathLike[str], text: str, keep: bool = True) -> None:
    """Write UTF-8 text in one step: afterwards the file holds all of it, or is as it was.

    A symbolic link stays one.
    Raises FormatError if it cannot be written.

    Parameters
    ----------
    keep : bool
        Whether the content before is kept beside it with ``.bak`` appended.
    """
    try:
        content = text.encode("utf-8")
    except ValueError as error:
        raise FormatError(_unwritable(os.fsdecode(path), error)) from error
    write_content(path, content, keep)


def write_content(path: str | os.PathLike[str], content: bytes, keep: bool = True) -> None:
    """Write bytes as `write_text` does text; a FormatError if they cannot be written."""
    where = os.fsdecode(path)
    try:
        target = Path(os.path.realpath(where))
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a directory")
        if target.is_file():
            if target.read_bytes() == content:
                return
            if keep:
                replace_content(Path(f"{target}.bak"), target.read_bytes(), like=target)
        replace_content(target, content, like=target)
    except (OSError, ValueError) as error:
        raise FormatError(_unwritable(where, error)) from error


def replace_content(target: Path, content: bytes, like: Path) -> None:
    """Put `content` in the place of `target` in one step, with the permissions of the file `like`.

    Raises OSError if that is impossible; the file that was there is unchanged.
    """
    prefix, is_known = f".{target.name[:100]}.", like.exists()
    if is_known:  # nobody reads a part of what only some may read
        descriptor, name = tempfile.mkstemp(prefix=prefix, dir=target.parent)
    else:
        descriptor, name = create_file(target.parent, prefix)
    try:
        with open(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(descriptor)
        if is_known:
            shutil.copymode(like, name)
        move_into_place(name, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
    _settle(target.parent)


def _settle(folder: Path) -> None:
    """Make a renaming in `folder` outlast a power failure, where the system offers it."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _unwritable(where: str, error: OSError | ValueError) -> Problem:
    reason = error.strerror if isinstance(error, OSError) else None
    what = f"the file cannot be saved: {reason or error}"
    return Problem("file.not_saved", where, what, "an existing file is unchanged", writing_cure(error))


def writing_cure(error: OSError | ValueError) -> str:
    """Return what helps where a file cannot be written."""
    number = error.errno if isinstance(error, OSError) else None
    return _CURES.get(number, "check the path") if number is not None else "check the path"
