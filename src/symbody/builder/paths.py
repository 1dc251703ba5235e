"""Which files the page may name: those inside the roots, after all links are followed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from symbody.builder.refusal import refusal

# Names that Windows takes for devices, in every folder and with every ending.
_DEVICES: Final = frozenset(
    {"con", "prn", "aux", "nul", "conin$", "conout$"}
    | {f"{word}{k}" for word in ("com", "lpt") for k in "0123456789\u00b9\u00b2\u00b3"}
)
_LONGEST: Final = 4096


def contained_path(path: str, roots: Sequence[Path]) -> Path:
    """Return a path with all links followed.

    Raises
    ------
    UsageError
        If it is not a path, or lies outside the roots.
    """
    if not path or len(path) > _LONGEST or any(ord(letter) < 32 for letter in path):
        raise refusal("builder.bad_path", path[:80], "this is not a path", fix="name a file")
    given = Path(path).expanduser()
    if not given.is_absolute():
        raise refusal("builder.bad_path", path, "the path is not absolute", fix="give the whole path")
    if os.name == "nt" and path.replace("/", "\\").startswith("\\\\"):
        raise _outside_roots(path, roots)
    if any(part.split(".")[0].strip().lower() in _DEVICES for part in given.parts):
        raise refusal("builder.bad_path", path, "the path names a device", fix="choose another name")
    try:
        real = Path(os.path.realpath(given))
    except (OSError, ValueError):
        raise refusal("builder.bad_path", path, "this is not a path", fix="name a file") from None
    if not any(real.is_relative_to(root) for root in roots):
        raise _outside_roots(path, roots)
    return real


def with_ending(path: Path, endings: Iterable[str]) -> Path:
    """Return a path that ends as files of its kind do.

    Raises
    ------
    UsageError
        If it ends otherwise.
    """
    allowed = tuple(endings)
    if path.suffix.lower() not in allowed:
        raise refusal(
            "builder.ending",
            str(path),
            f"files ending in {path.suffix!r} cannot be opened or saved here",
            fix=f"choose a file that ends in {' or '.join(allowed)}",
        )
    return path


def _outside_roots(path: str, roots: Sequence[Path]) -> Exception:
    return refusal(
        "builder.outside_roots",
        path,
        "the file is outside the folders of this builder",
        f"it was started with {', '.join(map(str, roots))}",
        "start symbody builder in the folder of the file",
    )
