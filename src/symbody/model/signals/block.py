"""`SignalBlock`: what expands into signals, the last of which bears its name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import SymbolElementName
from symbody.model.element import Element
from symbody.model.numeric_checks import NumericChecks
from symbody.model.signals.domains import FINITE, Demand, Domain
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

    def check(self, arguments: Arguments) -> None:
        """Note numbers outside of their domains; formulas are judged when their parameters have values."""
        check = NumericChecks({})
        self.check_numbers(check, "")
        for problem in check.problems:
            arguments.add(problem.code, problem.where, problem.what, problem.why, problem.fix)

    def demands(self) -> Iterator[Demand]:
        """Yield every formula with its domain, then what several have to fulfil together."""
        for name, field in self.fields.items():
            fits = getattr(field, "fits", None)
            domain = fits if isinstance(fits, Domain) else FINITE
            sites = field.formula_sites(self, getattr(self, name), name)
            yield from (Demand(site.path, site.formula, domain) for site in sites)
        yield from self.joint_demands()

    def joint_demands(self) -> Iterator[Demand]:
        """Yield what several arguments have to fulfil together, and what depends on the others given."""
        return iter(())

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers outside of their domains, as far as parameters have values."""
        for path, formula, domain in self.demands():
            domain(check, formula, f"{label}, {path}" if label else path)

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
