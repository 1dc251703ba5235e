"""What is not part of the expression language: which fault it is, and what to type instead."""

from __future__ import annotations

import unicodedata
from typing import Final

from symbody.errors import Problem
from symbody.expr.language.caret import Source, printable

_DATA: Final = "an expression is data, never code: only numbers, names, operators and the listed functions"

# Mark -> code, fact, cure.
_MARKS: Final = {
    "string": ("string", "quoted text is not allowed in an expression", "write names without quotes"),
    "output": ("string", "an output of the mechanism cannot be read in this formula",
               "write names without quotes; a force reads an output by a signal, output = \"length S\", and "
               "its name here; results, plots, events and laws of inputs read outputs in quotes"),
    "prime": ("prime", "a prime is not a derivative here", "write x_dot for the rate of x"),
    ".": ("attribute", "attributes are not supported here", "write names without dots"),
    "[": ("subscript", "indexing is not supported here", "give every quantity its own name, such as x_1"),
    "]": ("subscript", "indexing is not supported here", "give every quantity its own name, such as x_1"),
    "{": ("braces", "braces have no meaning here", "write ( and ), and x_1 for x_{1}"),
    "}": ("braces", "braces have no meaning here", "write ( and ), and x_1 for x_{1}"),
    ":=": ("assignment", "an expression cannot assign", "define the quantity as a parameter"),
    "=": ("equals", "'=' is not an operator", "write a - b for the equation a = b, or == inside if(...)"),
    ":": ("syntax", "':' has no meaning here (no lambda, slice or dictionary)", "write the bare formula"),
    "`": ("backtick", "a backtick has no meaning here", "delete it"),
    "//": ("syntax", "'//' is not an operator", "write floor(a/b)"),
    "%": ("syntax", "'%' is not an operator", "write mod(a, b), or divide a percentage by 100"),
    "<>": ("syntax", "'<>' is not an operator", "write !="),
    "=<": ("syntax", "'=<' is not an operator", "write <="),
    "=>": ("syntax", "'=>' is not an operator", "write >="),
    "&&": ("syntax", "'&&' is not an operator", "write and"),
    "&": ("syntax", "'&' is not an operator", "write and"),
    "||": ("syntax", "'||' is not an operator", "write or"),
    "|": ("syntax", "'|' is not an operator", "write or for conditions, abs(x) for |x|"),
    "!": ("syntax", "'!' is not an operator (no factorial)", "write not for conditions"),
    "~": ("syntax", "'~' is not an operator", "write not"),
    "?": ("syntax", "'?' is not an operator", "write if(condition, a, b)"),
    "#": ("syntax", "comments are not allowed in an expression", "write the comment next to it in the file"),
    ";": ("syntax", "';' has no meaning here", "write one expression"),
}  # fmt: skip
_OTHER_MARK: Final = ("syntax", "this is not an operator", "write + - * / ** and the listed functions")

# Characters that look like one of ours -> what to type.
_LOOKALIKES: Final = {
    **dict.fromkeys("×·⋅∙∗", "write *"),
    **dict.fromkeys("÷∕⁄", "write /"),
    **dict.fromkeys("‐‒–—―", "write - for minus"),
    **dict.fromkeys("‘’′“”″", "write names without quotes, and x_dot for the rate of x"),
    "≤": "write <=", "≥": "write >=", "≠": "write !=", "≈": "write abs(a - b) < tolerance", "¬": "write not",
    "∧": "write and", "∨": "write or", "√": "write sqrt(x)", "∞": "leave the limit out: infinity is not "
        "supported",
    "°": 'write deg after the number, as in "30 deg", where an angle is expected, or multiply by pi/180',
}  # fmt: skip


def mark_problem(source: Source, offset: int, mark: str) -> Problem:
    """Return the problem of an ASCII mark; `mark` is ``"string"``, ``"output"`` or ``"prime"`` for quotes."""
    code, what, fix = _MARKS.get(mark, _OTHER_MARK)
    return source.problem(f"expression.{code}", offset + 1, what, _DATA, fix)


def character_problem(source: Source, offset: int) -> Problem:
    """Return the problem of a control character, or of one outside ASCII that no name may contain."""
    character = source.text[offset]
    name = unicodedata.name(character, "unnamed")
    label = f"U+{ord(character):04X} ({name.lower()})"
    category = unicodedata.category(character)
    if category[0] in "CMZ" or (category[0] == "L"):
        return source.problem(
            "expression.control_character",
            offset + 1,
            f"the character {label} is invisible",
            "it probably came with pasted text, and makes a text look different from what it is",
            "delete it and type this part again",
        )
    return source.problem(
        "expression.character",
        offset + 1,
        f"the character {printable(character)}, {label}, is not part of the language",
        "it came with pasted text, or from a keyboard layout",
        _LOOKALIKES.get(character) or _digit_fix(character) or "write names with letters, digits and _",
    )


def _digit_fix(character: str) -> str:
    """Return the cure for digits of other scripts, superscripts, subscripts and fractions, or ``""``."""
    kind = unicodedata.decomposition(character).split(" ")[0]
    plain = unicodedata.normalize("NFKC", character).replace("\N{FRACTION SLASH}", "/")
    if kind == "<super>" and plain.isascii():
        return f"write **{plain}"
    if kind == "<sub>" and plain.isascii():
        return f"write _{plain}"
    if kind == "<fraction>" and plain.isascii():
        return f"write ({plain})"
    value = unicodedata.digit(character, None)
    return "" if value is None else f"write {value}"
