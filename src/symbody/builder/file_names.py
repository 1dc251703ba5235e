"""Names of files that are offered to be stored."""

from __future__ import annotations


def file_stem(name: str) -> str:
    """Return a name that every system takes for a file.

    >>> file_stem("a/b: c")
    'a_b_c'
    """
    plain = "".join(letter if letter.isalnum() or letter in "-_" else " " for letter in name)
    return "_".join(plain.split())[:60] or "model"
