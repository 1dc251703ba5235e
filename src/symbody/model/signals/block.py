"""`SignalBlock`: what expands into signals, the last of which bears its name."""

from __future__ import annotations

from typing import ClassVar

from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import SymbolElementName
from symbody.model.element import Element
from symbody.model.signals.signal import Signal


@element
class SignalBlock(Element):
    """Signals that belong together, under one name.

    Attributes
    ----------
    equation, states : str
        For the documentation: what its output is, and which states it has.
    """

    kind: ClassVar[str] = "block"
    equation: ClassVar[str]
    states: ClassVar[str]

    name: SymbolElementName = SymbolElementName("Name of the output, unique among the symbols of the model.")

    @property
    def continuous(self) -> SignalBlock | None:
        """The block without samples; None where it has no continuous equivalent."""
        return type(self)(**{**self.given_arguments(), "sample": None})

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The signals that it stands for."""
        raise NotImplementedError


def in_brackets(formula: Formula) -> str:
    """Return a formula as part of another."""
    text = formula.text
    return text if text.isidentifier() or text.replace(".", "", 1).isdigit() else f"({text})"
