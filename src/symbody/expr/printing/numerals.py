"""Numbers in formulas that people read: as they were written, or computed ones to a few digits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from symbody.expr.graph import Constant, Exact
from symbody.expr.language.literals import EXACT_DIGITS
from symbody.expr.printing.layout import number_text

_NUMERAL: Final = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)(?:[eE]([+-]?\d+))?")
_LONG_FRACTION: Final = 10_000  # numerators and denominators from here on are those of decimals
# What is printed without an exponent, as Python prints floats.
_LEAST, _MOST = 1e-4, 1e16


@dataclass(frozen=True, slots=True)
class Numerals:
    """How many digits numbers of formulas have.

    Attributes
    ----------
    digits : int, optional
        Significant digits of a computed number; all by default.
    written : frozenset of exact numbers
        Those that a user wrote: they have all digits.
    """

    digits: int | None = None
    written: frozenset[Exact] = frozenset()

    def text(self, value: Constant) -> str:
        """Return a number >= 0; exact ones as fractions where those are short."""
        return self.round_number(value) or full_text(value)

    def round_number(self, value: Constant) -> str:
        """Return a number with fewer digits than it has; empty where it has no more."""
        if self.digits is None or value in self.written:
            return ""
        full = full_text(value)
        if "/" in full:
            exact = Fraction(value)
            if max(exact.numerator, exact.denominator) < _LONG_FRACTION:
                return ""
        elif significant_digits(full) <= self.digits:
            return ""
        return _positional(float(value), self.digits)


ALL_DIGITS: Final = Numerals()


def full_text(value: Constant) -> str:
    """Return a number >= 0 with all its digits, of more than 17 the first 17."""
    if isinstance(value, float):
        return repr(value)
    text = number_text(value)
    top, _, bottom = text.partition("/")
    if bottom and max(len(top), len(bottom)) > EXACT_DIGITS:
        return repr(float(value))
    return text


def significant_digits(text: str) -> int:
    """Return the significant digits of a decimal; zeros at the end of whole numbers count."""
    mantissa = text.lower().partition("e")[0]
    return len(mantissa.replace(".", "").lstrip("0"))


def written_numbers(texts: Iterable[str]) -> frozenset[Exact]:
    """Return the numbers in formulas that are exact: decimals of up to 15 digits.

    >>> sorted(written_numbers(["9.81*m + 1e-3", "2.899053227347741"]))
    [Fraction(1, 1000), Fraction(981, 100)]
    """
    found = set[Exact]()
    for text in texts:
        for match in _NUMERAL.finditer(text):
            if significant_digits(match[1]) <= EXACT_DIGITS and len(match[0]) < 2 * EXACT_DIGITS:
                found.add(Fraction(match[0]))
    return frozenset(found)


def _positional(value: float, digits: int) -> str:
    """Return a number rounded to significant digits, without zeros at its end."""
    rounded = float(f"{value:.{digits - 1}e}")
    if rounded == 0.0 or _LEAST <= rounded < _MOST:
        decimals = digits - 1 - (math.floor(math.log10(rounded)) if rounded else 0)
        text = f"{rounded:.{max(decimals, 0)}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    mantissa, _, exponent = f"{rounded:.{digits - 1}e}".partition("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
