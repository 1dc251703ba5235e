"""Results on the disk that the next process need not find again: sequences and object code.

One file for each, named after a hash of everything it follows from. It begins with a hash of the rest: a file
that was cut or changed is thrown away and made again. Only files in a folder of the user's own are read.
Whatever fails here is as if nothing had been stored: a home that cannot be written to is not an error.

`read_sealed` and `write_sealed` do so with a file at any place.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from secrets import token_hex
from typing import Final

# Names a folder, or is "off".
VARIABLE: Final = "SYMBODY_CACHE"
LIMIT: Final = 256 * 2**20  # bytes in all; what was used longest ago goes first
_KEPT: Final = 0.75  # of the limit, when something has to go
# Looking through thousands of files takes as long as compiling a small function: one in so many stores does.
EVERY: Final = 32
_ENDING: Final = ".stored"
_DIGEST: Final = 32
_PAUSES: Final = (0.01, 0.03, 0.1, 0.3, 0.6)  # [s]


def folder() -> Path | None:
    """Return where results are stored, None if they are not to be."""
    chosen = os.environ.get(VARIABLE, "")
    if chosen:
        return None if chosen.lower() in ("off", "0", "no", "none") else Path(chosen)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", "")
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME", "") or "~/.cache"
    path = os.path.expanduser(base)
    return Path(path, "symbody") if os.path.isabs(path) else None


def load_stored(key: bytes) -> bytes | None:
    """Return the content stored under `key`, None if there is none that can be trusted."""
    place = folder()
    if place is None or not _is_own(place):
        return None
    path = _path(place, key)
    content = read_sealed(path, key)
    if content is not None:
        with suppress(OSError):
            os.utime(path)  # it was used now
    return content


def store(key: bytes, content: bytes) -> None:
    """Store `content` under `key`; processes that do so at the same time do not meet."""
    place = folder()
    if place is None:
        return
    with suppress(OSError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_own(place):
            return
        path = _path(place, key)
        write_sealed(path, key, content)
        if int(path.name[:4], 16) % EVERY == 0:
            _evict(place)


def read_sealed(path: Path, key: bytes, owners: frozenset[int] | None = None) -> bytes | None:
    """Return the content that `write_sealed` wrote; else delete the file and return None.

    Parameters
    ----------
    key : bytes
        What it was written under.
    owners : set of int, optional
        The users whose files are read, if nobody else can write to these; by default those of anybody.
    """
    try:
        with path.open("rb") as file:
            if owners is not None and not _belongs(os.fstat(file.fileno()), owners):
                return None
            found = file.read()  # all of it from one open file, whatever takes its place meanwhile
    except OSError:
        return None
    content = found[_DIGEST:]
    if found[:_DIGEST] == _digest(key, content):
        return content
    with suppress(OSError):
        path.unlink()
    return None


def write_sealed(path: Path, key: bytes, content: bytes) -> None:
    """Write a file so that nobody ever sees a part of it.

    Raises
    ------
    OSError
        If that cannot be done.
    """
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(_digest(key, content) + content)
        move_into_place(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def move_into_place(name: str | os.PathLike[str], target: Path) -> None:
    """Put a finished file in the place of another in one step.

    Windows refuses that while anybody has the other one open, if only for an instant, as programs that look
    for viruses or index files do: it is asked again for a second.

    Raises
    ------
    OSError
        If that cannot be done.
    """
    for pause in _PAUSES if sys.platform == "win32" else ():
        try:
            os.replace(name, target)
        except PermissionError:
            time.sleep(pause)
        else:
            return
    os.replace(name, target)


def _is_own(place: Path) -> bool:
    """Return whether nobody else can put files there."""
    if sys.platform == "win32":  # folders of a user are closed to others there
        return place.is_dir()
    try:
        status = place.stat()
    except OSError:
        return False
    return _belongs(status, frozenset({os.geteuid()}))


def _belongs(status: os.stat_result, owners: frozenset[int]) -> bool:
    return sys.platform == "win32" or (status.st_uid in owners and not status.st_mode & 0o022)


def _evict(place: Path) -> None:
    found = []
    with os.scandir(place) as entries:
        for entry in entries:
            with suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                found.append((status.st_mtime, status.st_size, entry.path))
    total = sum(size for _, size, _ in found)
    if total <= LIMIT:
        return
    for _, size, path in sorted(found):
        if total <= _KEPT * LIMIT:
            return
        with suppress(OSError):
            os.unlink(path)
            total -= size


def _path(place: Path, key: bytes) -> Path:
    return place / (sha256(key).hexdigest() + _ENDING)


def _digest(key: bytes, content: bytes) -> bytes:
    return sha256(sha256(key).digest() + content).digest()


def create_file(folder: Path, prefix: str, suffix: str = "") -> tuple[int, str]:
    """Create a file with the permissions of any new one, and return its descriptor and a path of its own.

    Those of `tempfile.mkstemp` are for their owner alone. The system is asked by creating one: `os.umask`
    tells the permissions by changing them, for the files of all threads.

    Raises
    ------
    OSError
        If there can be no file.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL
    for word in ("O_CLOEXEC", "O_NOFOLLOW", "O_BINARY"):  # as far as the system has them
        flags |= getattr(os, word, 0)
    while True:
        path = os.path.join(folder, f"{prefix}{token_hex(8)}{suffix}")
        with suppress(FileExistsError):
            return os.open(path, flags, 0o666), path
