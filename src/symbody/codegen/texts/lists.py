"""Long lists of operands, filled into lines."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence as Items
from typing import Final

_WIDTH: Final = 100


def fill_lines(words: Items[str], indent: str, end: str = "") -> list[str]:
    """Return lines of `words` separated by commas, each line with `indent` before and `end` behind it.

    >>> fill_lines(["a", "b"], "    ", " ...")
    ['    a, b ...']
    """
    text = ", ".join(words)
    lines = textwrap.wrap(text, _WIDTH - len(indent), break_long_words=False, break_on_hyphens=False)
    return [f"{indent}{line}{end}" for line in lines]
