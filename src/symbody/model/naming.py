"""What a name may be: elements have display names, symbols have names that formulas can contain."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from symbody.errors import Problem
from symbody.expr.language.tokens import KEYWORDS, MAX_NAME, is_name, normalize

GROUND: Final = "ground"
CENTRE: Final = "CoM"
RESERVED_SYMBOLS: Final = {"t": "time", "pi": "the circle constant"}

_SYMBOL_CURE: Final = "use letters, digits and _, beginning with a letter or _"


def symbol_problem(name: object, where: str) -> Problem | None:
    """Return what is wrong with the name of a parameter, input, coordinate or speed, or None.

    Words of Python, C or SymPy are legal: a name is only a name.
    """
    found = _text_problem(name, where)
    if found is not None or not isinstance(name, str):
        return found
    if name in RESERVED_SYMBOLS:
        what = f"the name {name!r} is reserved: it is {RESERVED_SYMBOLS[name]}"
        return Problem("names.reserved", where, what, "", f"rename it, for instance {name}_1")
    if name in KEYWORDS:
        what = f"{name!r} is a word of the expression language"
        why = "a formula could not refer to the symbol"
        return Problem("names.keyword", where, what, why, f"rename it, for instance {name}_1")
    if not is_name(normalize(name)):
        what = f"{name!r} cannot be written in a formula"
        why = "symbols have names of letters, digits and _, so that formulas can contain them"
        return Problem("names.not_a_symbol", where, what, why, _SYMBOL_CURE)
    return None


def element_problem(name: object, where: str) -> Problem | None:
    """Return what is wrong with the name of a body, joint, frame or force, or None.

    Blanks and any alphabet are legal; what does not print, the dot of addresses and quotes are not.
    """
    found = _text_problem(name, where)
    if found is not None or not isinstance(name, str):
        return found
    if name.lower() == GROUND:
        fix = "rename the element; frames of the ground go into [ground.frames]"
        return Problem("names.reserved", where, f"the name {name!r} is reserved for the fixed frame", "", fix)
    for mark in ".\"'":
        if mark in name:
            why = "addresses are written Body.Frame, and names with spaces are quoted in outputs"
            fix = f"remove the {mark!r}, or replace it by _"
            return Problem("names.mark", where, f"the name {name!r} contains {mark!r}", why, fix)
    return None


@lru_cache(maxsize=4096)  # of large models, whose joints name their coordinates again and again
def make_symbol(name: str) -> str:
    """Return the name of an element made fit for formulas: every other character becomes ``_``.

    >>> make_symbol("upper arm")
    'upper_arm'
    """
    text = normalize(name)
    if not text.isidentifier():
        text = "".join(c if c == "_" or f"a{c}".isidentifier() else "_" for c in text)
    return text if is_name(text) and text not in RESERVED_SYMBOLS else f"_{text}"


def _text_problem(name: object, where: str) -> Problem | None:
    if not isinstance(name, str):
        what = f"{name!r} of type {type(name).__name__} is not a name"
        return Problem("names.not_text", where, what, "", "give a text")
    if not name.strip():
        return Problem("names.empty", where, "the name is empty", "", "give it a name")
    if len(name) > MAX_NAME:
        what = f"a name of {len(name)} characters ({name[:24]!r}...)"
        why = "only generated names are this long"
        return Problem("names.too_long", where, what, why, f"use at most {MAX_NAME} characters")
    if not name.isprintable():
        hidden = next(c for c in name if not c.isprintable())
        what = f"the name {name!a} contains U+{ord(hidden):04X}, which does not print"
        why = "it probably came with pasted text, and makes the name look different from what it is"
        return Problem("names.control_character", where, what, why, "type the name again")
    if name != name.strip():
        what = f"the name {name!r} begins or ends with a space"
        return Problem("names.blank", where, what, "", f"write {name.strip()!r}")
    if name.isdigit():
        what = f"the name {name!r} has only digits"
        return Problem("names.digits", where, what, "it would be read as a number", f"write _{name}")
    return None
