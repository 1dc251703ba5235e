"""The words of an output's name, where names may contain blanks."""

from __future__ import annotations

from collections.abc import Iterable


def output_words(text: str, known: Iterable[str]) -> list[str]:
    """Return the words of a text: what is quoted, the longest known name, or all up to the next blank."""
    names = sorted(known, key=len, reverse=True)
    words = []
    rest = text.strip()
    while rest:
        if rest.startswith('"'):
            word, _, rest = rest[1:].partition('"')
        else:
            word = next((name for name in names if f"{rest} ".startswith(f"{name} ")), rest.split()[0])
            rest = rest[len(word) :]
        words.append(word)
        rest = rest.strip()
    return words
