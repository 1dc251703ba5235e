"""Formulas as the page shows them beside their fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any, Final

from symbody.display.formulas import show_formula
from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.expr.printing.mathml_tables import math_element

# Texts of the model file that are names, addresses or words.
_WORDS: Final = frozenset(
    "name type between axis axes angles coordinate coordinates speed_names resolved_in on reaction_on path "
    "kind outside color file inputs layout version coupled speeds first second output "
    "prefix share columns units".split()
)
_MOST: Final = 2000  # formulas of a model that are shown
# What a formula is easier to read for in two dimensions: fractions, powers, functions, rates, indices.
_NOTATION: Final = re.compile(r"[/^(_]|\*\*")
_SHORT: Final = 24  # letters of a formula that is read as it is typed
_LONGEST: Final = 2000  # characters of one


def formula_mathml(text: str, pointer: str = "") -> str:
    """Return a formula as MathML where that reads better than its text, an angle in degrees in radians.

    Raises
    ------
    ExpressionError
        If it is none.
    """
    return _echo(text, Formula.from_value(_degrees_to_radians(text), where=f"#{pointer}" if pointer else ""))


def _echo(text: str, formula: Formula) -> str:
    """Return a formula as the page shows it beside its field; empty where it says no more than the text."""
    value = formula.constant() if text.strip().endswith(" deg") else None
    if value is not None:
        return math_element(f"<mn>{float(value):.6g}</mn><mtext>\u2009rad</mtext>".replace("-", "\u2212"))
    is_plain = formula.is_number or (len(text) < _SHORT and _NOTATION.search(text) is None)
    return "" if is_plain else show_formula(formula)


def model_formulas(data: Mapping[str, Any]) -> dict[str, str]:
    """Return the formulas of a model that are more than numbers as MathML, by JSON pointer."""
    shown: dict[str, str] = {}
    for pointer, text in formula_texts(data, ""):
        if len(shown) >= _MOST:
            break
        try:
            formula = _mathml_of(text)
        except SymbodyError:
            continue  # its field says what is wrong
        if formula is not None:
            shown[pointer] = formula
    return shown


@lru_cache(maxsize=4096)  # a check follows each change, of which most leave all formulas but one as they are
def _mathml_of(text: str) -> str | None:
    """Return a formula as MathML; None where it says no more than its text."""
    return _echo(text, Formula.from_value(_degrees_to_radians(text))) or None


def formula_texts(value: Any, pointer: str) -> Iterator[tuple[str, str]]:
    """Yield the texts of a part of a model that may be formulas, each with its JSON pointer."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            if key not in _WORDS or pointer in ("/parameters", "/initial"):
                yield from formula_texts(entry, f"{pointer}/{str(key).replace('~', '~0').replace('/', '~1')}")
    elif isinstance(value, list):
        for k, entry in enumerate(value):
            yield from formula_texts(entry, f"{pointer}/{k}")
    elif isinstance(value, str) and 0 < len(value) <= _LONGEST:
        yield pointer, value


def _degrees_to_radians(text: str) -> str:
    """Return an angle such as ``"30 deg"`` as a formula in radians."""
    words = text.strip()
    return f"({words[:-3].strip()})*pi/180" if words.endswith(" deg") else words
