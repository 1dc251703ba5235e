"""Long lines of formulas broken in front of their signs, as the rows of a book."""

from __future__ import annotations

import re
from itertools import accumulate
from shutil import get_terminal_size
from typing import Final

# Where a line may break: before a sign, else at the blank of a product.
_SIGN: Final = re.compile(r" (?=[-+=] )")
_BLANK: Final = re.compile(r" ")
_LEAST: Final = 80
_MOST: Final = 100
_HANGING: Final = "    "
_SHORT: Final = 10  # letters: a row "= 0" is better not alone
_FILLED: Final = 0.5  # of a row, before a sign in fewer brackets is not preferred to a fuller row


def text_width() -> int:
    """Return the columns of the terminal, within 80 and 100; 100 where there is none."""
    return min(max(get_terminal_size((_MOST, 0)).columns, _LEAST), _MOST)


def wrap_formula(line: str, width: int) -> list[str]:
    """Return a line as rows of at most `width` letters where its signs or blanks allow it.

    A row ends in front of the sign that stands in the fewest brackets, of equals the last one; rows after the
    first are indented.

    Parameters
    ----------
    width : int
        Letters of a row; 0 leaves the line as it is.
    """
    indent = line[: len(line) - len(line.lstrip())]
    rows: list[str] = []
    while width and len(line) > width:
        place = _break_place(line, width, len(indent) + 2 * len(_HANGING))
        if place is None:
            break
        rows.append(line[:place])
        line = f"{indent}{_HANGING}{line[place + 1 :]}"
    return [*rows, line]


def _break_place(line: str, width: int, start: int) -> int | None:
    """Return the blank at which a row ends, or None where nothing can be broken behind `start`."""
    depths = list(accumulate((letter in "([") - (letter in ")]") for letter in line))
    for sign in (_SIGN, _BLANK):
        places = [found.start() for found in sign.finditer(line, start) if found.start() <= width]
        filled = [place for place in places if place >= _FILLED * width]
        if filled or places:
            return min(
                filled or places, key=lambda place: (depths[place], len(line) - place < _SHORT, -place)
            )
    following = _BLANK.search(line, max(width, start))
    return None if following is None else following.start()
