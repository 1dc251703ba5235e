"""Text from a file that may be anything: missing, huge, binary, a device, in another encoding."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

from symbody.errors import FormatError, Problem, nearest

MAX_BYTES: Final = 10_000_000

_CAUSES: Final = MappingProxyType[int | None, tuple[str, str, str]](
    {
        errno.EACCES: ("denied", "reading it is not permitted", "change its permissions, or copy it"),
        errno.EPERM: ("denied", "reading it is not permitted", "change its permissions, or copy it"),
        errno.EISDIR: ("directory", "it is a directory", "name a file in it"),
        errno.ELOOP: ("link_loop", "its symbolic links lead in a circle", "mend the links"),
        errno.ENAMETOOLONG: ("bad_path", "the path is too long", "use a shorter path"),
        errno.ENOTDIR: ("missing", "a part of the path is a file, not a directory", "check the path"),
    }
)
# Byte order marks of encodings that TOML does not allow.
_OTHER_ENCODINGS: Final = ((b"\xff\xfe", "UTF-16"), (b"\xfe\xff", "UTF-16"))


def read_text(path: str | os.PathLike[str]) -> str:
    """Return the text of a file without byte order mark, its lines ended by line feeds.

    Raises
    ------
    FormatError
        If there is no such regular file of up to 10 MB, or it is not UTF-8 text.
    """
    where = os.fsdecode(path) or "''"
    return _decode(_content(path, where), where)


def _content(path: str | os.PathLike[str], where: str) -> bytes:
    try:
        # Without blocking: a pipe would wait for its writer for ever.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        raise FormatError(_missing_problem(where)) from None
    except (OSError, ValueError) as error:
        raise FormatError(_unreadable(where, error)) from error
    try:
        mode = os.fstat(descriptor).st_mode
        if not stat.S_ISREG(mode):
            raise FormatError(_not_regular(where, mode))
        with open(descriptor, "rb", closefd=False) as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise FormatError(_unreadable(where, error)) from error
    finally:
        os.close(descriptor)
    if len(content) <= MAX_BYTES:
        return content
    raise FormatError(
        Problem(
            "file.too_large",
            where,
            f"the file is larger than {MAX_BYTES // 1_000_000} MB",
            "this is not a model file, or it was made by a program",
            "split the mechanism, or check the name of the file",
        )
    )


def _decode(content: bytes, where: str) -> str:
    for mark, encoding in _OTHER_ENCODINGS:
        if content.startswith(mark):
            raise FormatError(_encoding_problem(where, f"the file is encoded as {encoding}"))
    if b"\0" in content:
        raise FormatError(
            Problem(
                "file.binary", where, "the file is not text: it contains zero bytes", "", "name a model file"
            )
        )
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start]
        raise FormatError(
            _encoding_problem(f"{where}:{line}", f"byte 0x{byte:02X} in line {line} is not UTF-8")
        ) from None
    if not text.strip():
        raise FormatError(
            Problem(
                "file.empty",
                where,
                "the file is empty",
                "saving it may have failed",
                'restore it, for instance from the .bak beside it, or begin with name = ".."',
            )
        )
    return text.replace("\r\n", "\n")


def _encoding_problem(where: str, what: str) -> Problem:
    return Problem(
        "file.encoding",
        where,
        what,
        "it was saved by an editor in another encoding, such as Latin-1",
        "save the file as UTF-8",
    )


def _missing_problem(where: str) -> Problem:
    folder = Path(where).parent
    return Problem("file.missing", where, "there is no such file", "", _similar(Path(where).name, folder))


def _similar(name: str, folder: Path) -> str:
    try:
        names: Sequence[str] = sorted(entry.name for entry in os.scandir(folder))[:1000]
    except OSError:
        return f"there is no directory {str(folder)!r} either"
    if not names:
        return f"the directory {str(folder)!r} is empty: give the path of a file"
    suffixes = Path(name).suffix or ".toml", ".toml"
    alike = [[other for other in names if other.endswith(suffix)] for suffix in suffixes]
    return nearest(name, next(filter(None, alike), names))


def _unreadable(where: str, error: OSError | ValueError) -> Problem:
    number = error.errno if isinstance(error, OSError) else None
    if number in _CAUSES:
        code, what, fix = _CAUSES[number]
        return Problem(f"file.{code}", where, what, "", fix)
    if isinstance(error, OSError):
        reason = error.strerror or type(error).__name__
        return Problem("file.unreadable", where, f"the file cannot be read: {reason}", "", "check the path")
    return Problem("file.bad_path", repr(where), f"this is not a path: {error}", "", "check the path")


def _not_regular(where: str, mode: int) -> Problem:
    if stat.S_ISDIR(mode):
        return _unreadable(where, OSError(errno.EISDIR, ""))
    kinds = ((stat.S_ISFIFO, "a pipe"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"))
    word = next((name for test, name in kinds if test(mode)), "no regular file")
    return Problem("file.not_a_file", where, f"it is {word}", "", "name a regular file")
