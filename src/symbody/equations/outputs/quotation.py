"""Outputs that stand without quotes inside a formula: how the formula is meant."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

# What may follow the name of a reaction, and the words of a frame's motion.
_ENTRY: Final = r"(?: [FM][xyz])?"
_FRAME: Final = r"frame (?:vdot|wdot|r|v|R|w)(?: [^\W\d][\w.]*){1,4}"


def quotation_cure(text: str, outputs: Iterable[str]) -> str:
    """Return what to type where outputs inside a formula lack their quotes; empty where none do.

    >>> quotation_cure("2*reaction A Fx", ["reaction A"])
    "inside a formula outputs stand in single quotes: 2*'reaction A Fx'"
    >>> quotation_cure("[reaction A Fx]^2", ["reaction A"])
    "inside a formula outputs stand in single quotes: 'reaction A Fx'^2"
    """
    if re.search(r"[-+*/^(<>,]", text) is None:
        return ""
    names = sorted((name for name in outputs if " " in name), key=len, reverse=True)
    words = "|".join([*(re.escape(name) + _ENTRY for name in names), _FRAME])
    bare = rf"(?<![\w'])(?:\"({words})\"|\[({words})\]|({words}))(?![\w'])"
    quoted = re.sub(bare, lambda found: f"'{found[1] or found[2] or found[3]}'", text)
    return "" if quoted == text else f"inside a formula, write outputs in single quotes: {quoted}"
