"""`Relation`: the sign between two sides that are printed: that of an equation or of a one-sided row."""

from __future__ import annotations

from enum import StrEnum


class Relation(StrEnum):
    """The sign between two sides; its value is that of plain text."""

    EQUAL = "="
    AT_LEAST = ">="
    AT_MOST = "<="

    @property
    def latex(self) -> str:
        """The sign in LaTeX."""
        return {"=": "=", ">=": r"\ge", "<=": r"\le"}[self.value]

    @property
    def mathml(self) -> str:
        """The sign in MathML."""
        return {"=": "=", ">=": "\u2265", "<=": "\u2264"}[self.value]

    @property
    def sympy(self) -> str:
        """The class of SymPy."""
        return {"=": "Eq", ">=": "Ge", "<=": "Le"}[self.value]
