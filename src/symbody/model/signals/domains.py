"""`Domain`: which values an argument of a block may have, literal ones and those of parameters alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from symbody.expr.language.formula import Formula
from symbody.model.numeric_checks import NumericChecks


@dataclass(frozen=True, slots=True)
class Domain:
    """The numbers that an argument may be: finite, and as it says.

    Calling it notes a value that is outside; a formula whose names have no values is not judged.

    Attributes
    ----------
    code, what, why, fix : str
        Of the problem; `what` with ``{formula}`` and ``{value}``.
    least : float
        None is below.
    above : bool
        Whether `least` itself is none.
    nonzero : bool
        Whether 0 is none.
    """

    code: str
    what: str
    why: str
    fix: str
    least: float = -math.inf
    above: bool = False
    nonzero: bool = False

    def has(self, value: float) -> bool:
        """Return whether a number is one of it."""
        if not math.isfinite(value) or value < self.least:
            return False
        return not (self.above and value == self.least) and not (self.nonzero and value == 0.0)

    def __call__(self, check: NumericChecks, formula: Formula, where: str) -> None:
        """Note a value that is outside."""
        value = check.value(formula, where)
        if value is not None and not self.has(value):
            what = self.what.format(formula=formula, value=f"{value:g}")
            check.refuse(self.code, where, what, self.why, self.fix)


class Demand(NamedTuple):
    """A formula of a block, or what follows from several, with its domain."""

    path: str
    formula: Formula
    domain: Domain


FINITE: Final = Domain("block.domain", "{formula} is {value}", "it is not a number", "give other values")
SAMPLE_TIME: Final = Domain(
    "signal.sample", "the time between samples, {formula}, is {value} s",
    "samples are taken at the start and after every such time", "give seconds, such as sample = 0.01",
    0.0, above=True,
)  # fmt: skip
TIME: Final = Domain(
    "block.domain", "{formula} is {value} s", "this is the time constant of a state, which divides its rate",
    "give seconds above 0, short compared with the motion", 0.0, above=True,
)  # fmt: skip
NOT_NEGATIVE: Final = Domain("block.domain", "{formula} is {value}", "a sign is wrong", "give 0 or more", 0.0)


def difference(high: Formula, low: Formula) -> Formula:
    """Return the formula ``high - low``."""
    return Formula.from_value(f"({high.text}) - ({low.text})")
