"""Formulas as a script writes them, ``r^2 = b^2 - sqrt(c^2 - a^2)``, as LaTeX.

A blank is a product, a prime a derivative by time, `cross` a vector product. Nothing is computed: the
parts are replaced where they stand.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from symbody.expr.printing.latex import latex_name

_TOKEN: Final = re.compile(r"[A-Za-z]\w*'*|\d+|\+-|-\+|[-+*/^=<>|(),.]")
_SIGNS: Final = {
    "+-": r"\pm",
    "-+": r"\mp",
    "*": r"\,",
    ".": r"\cdot",
    "cross": r"\times",
    "sum": r"\sum",
    "pi": r"\pi",
}
_FUNCTIONS: Final = {
    **{name: rf"\{name}" for name in ("sin", "cos", "tan", "cot", "exp", "ln")},
    **{f"a{name}": rf"\arc{name}" for name in ("sin", "cos", "tan")},
    **{name: rf"\operatorname{{{name}}}" for name in ("atan2", "sn", "cn", "dn")},
}
_AROUND: Final = {"sqrt": r"\sqrt", "^": "^"}
_LONG: Final = 40  # letters of a formula that has a line to itself: browsers do not break formulas
_DOTS: Final = {1: r"\dot", 2: r"\ddot"}


def typeset(formula: str) -> str:
    """Return a formula as LaTeX."""
    tokens = _TOKEN.findall(formula)
    if "".join(tokens) != "".join(formula.split()):
        raise ValueError(f"{formula!r} has a sign that {_TOKEN.pattern} does not know")
    return _join(tokens)


def with_formulas(text: str) -> str:
    """Return a text with what stands between backquotes typeset, and what is long on a line of its own."""
    parts = re.split(r"`([^`]+)`([,.:;]?)", text)
    made = parts[0]
    for formula, sign, rest in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        latex = typeset(formula)
        if len(formula) < _LONG:
            made += f"${latex}${sign}{rest}"
        else:
            made = f"{made.rstrip()}\n\n```math\n{latex}{sign}\n```\n\n{rest.lstrip()}"
    return made.strip()


def _join(tokens: Sequence[str]) -> str:
    made = ""
    k = 0
    while k < len(tokens):
        token, follows = tokens[k], "".join(tokens[k + 1 : k + 2])
        if token in ("sqrt", "^"):
            end = _closing(tokens, k + 1) if follows == "(" else k + 1
            inner = _join(tokens[k + 2 : end]) if follows == "(" else _word(follows, "")
            made += f"{_AROUND[token]}{{{inner}}}"
            k = end
        else:
            word = _word(token, follows)
            made += _blank(made, word) + word
        k += 1
    return made


def _blank(made: str, word: str) -> str:
    """Return what separates a word from what stands before it."""
    if word.startswith(r"\mathrm") and made[-1:].isdigit() | made.endswith("}"):
        return r"\,"
    return " " if word[0].isalpha() and re.search(r"\\[a-z]+$", made) else ""


def _word(token: str, follows: str) -> str:
    if token in _FUNCTIONS and follows == "(":
        return _FUNCTIONS[token]
    if token in _SIGNS or not token[0].isalpha():
        return _SIGNS.get(token, token)
    name = token.rstrip("'")
    head, *index = latex_name(name).split("_", 1)
    dots = _DOTS.get(len(token) - len(name))
    return "_".join([f"{dots}{{{head}}}" if dots else head, *index])


def _closing(tokens: Sequence[str], start: int) -> int:
    """Return where the bracket closes that opens at `start`."""
    depth = 0
    for k in range(start, len(tokens)):
        depth += (tokens[k] == "(") - (tokens[k] == ")")
        if depth == 0:
            return k
    raise ValueError(f"a bracket is never closed: {' '.join(tokens)}")
