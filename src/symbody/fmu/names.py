"""Names of variables by the structured convention of the standard."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_QUOTABLE: Final = re.compile(r"[A-Za-z_0-9!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]")


def variable_name(name: str) -> str:
    """Return a name of the model, or of an output, as a structured name.

    >>> variable_name("theta"), variable_name("reaction B Fx"), variable_name("2*theta + phi")
    ('theta', 'reaction.B.Fx', "'2*theta + phi'")
    """
    words = name.split()
    is_path = len(words) > 1 and _PLAIN.fullmatch(words[0]) is not None and not re.search(r"[-+*/^<>=]", name)
    return ".".join(_part(word) for word in words) if is_path else _part(name)


def rate_name(name: str) -> str:
    """Return the name of the derivative of a state.

    >>> rate_name("theta")
    'der(theta)'
    """
    return f"der({variable_name(name)})"


def entry_name(name: str, shape: tuple[int, ...], place: int) -> str:
    """Return the name of one entry of an output, counted by rows; indices count from 1.

    >>> entry_name("reaction B", (6,), 0), entry_name("energy", (), 0), entry_name("M", (2, 2), 2)
    ('reaction.B[1]', 'energy', 'M[2,1]')
    """
    indices = []
    for size in reversed(shape):
        place, k = divmod(place, size)
        indices.append(str(k + 1))
    return variable_name(name) + (f"[{','.join(reversed(indices))}]" if shape else "")


def unique_names(names: Iterable[str]) -> list[str]:
    """Return names of which no two are the same: later ones get a number."""
    taken: set[str] = set()
    result = []
    for name in names:
        unique, number = name, 2
        while unique in taken:
            stem = name[:-1] if name.endswith("'") else name
            unique = f"{stem}_{number}'" if name.endswith("'") else f"{stem}_{number}"
            number += 1
        taken.add(unique)
        result.append(unique)
    return result


def identifier(name: str) -> str:
    """Return the name of a model as an identifier of C.

    >>> identifier("slider crank-2"), identifier("3d")
    ('slider_crank_2', 'm_3d')
    """
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if _PLAIN.fullmatch(plain) else f"m_{plain}"


def _part(word: str) -> str:
    if _PLAIN.fullmatch(word):
        return word
    letters = (letter if _QUOTABLE.fullmatch(letter) else _escape(letter) for letter in word)
    return f"'{''.join(letters)}'"


def _escape(letter: str) -> str:
    if letter in "'\"\\":
        return f"\\{letter}"
    return " " if letter.isspace() else f"#{ord(letter):x}#"
