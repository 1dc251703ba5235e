"""`TransferFunction`: a linear block given by two polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.arguments import Arguments
from symbody.model.fields import Quantity
from symbody.model.formula_site import Scope
from symbody.model.signals.block import SignalBlock, in_brackets
from symbody.model.signals.block_fields import Coefficients, block
from symbody.model.signals.signal import Signal


@final
@block
class TransferFunction(SignalBlock):
    """A linear block given by the coefficients of two polynomials, highest power first; it starts at rest.

    Examples
    --------
    >>> [signal.name for signal in TransferFunction("y", "u", [1], [1, 2, 1]).signals]
    ['y_1', 'y_2', 'y']
    """

    equation: ClassVar[str] = "y = numerator(s)/denominator(s) input"
    states: ClassVar[str] = "`y_1`, `y_2`, ..: as many as the denominator's degree"

    input: Quantity = Quantity("What goes in.", scope=Scope.LOAD)
    numerator: Coefficients = Coefficients("Its coefficients, highest power first.")
    denominator: Coefficients = Coefficients("Its coefficients, highest power first; the first is not 0.")

    def check(self, arguments: Arguments) -> None:
        """Note polynomials that make no proper transfer function."""
        if not self.numerator or not self.denominator or self.denominator[0].constant() == 0:
            arguments.add(
                "block.no_polynomial", "denominator", "the polynomials have no leading coefficients",
                "the first coefficient belongs to the highest power",
                "write denominator = [1, 2, 1] for s^2 + 2 s + 1",
            )  # fmt: skip
        elif len(self._numerator) > len(self.denominator):
            arguments.add(
                "block.improper", "numerator", "its degree is above the denominator's",
                "that is a derivative, and of a rate an acceleration",
                "give the denominator more powers, such as a filter (1 + T s) with a short time T",
            )  # fmt: skip

    @property
    def _numerator(self) -> tuple[Formula, ...]:
        """The numerator without the zeros in front, which no input passes."""
        zeros = [entry.constant() == 0 for entry in self.numerator]
        return self.numerator[zeros.index(False) if False in zeros else len(zeros) :]

    @property
    def signals(self) -> tuple[Signal, ...]:
        """A chain of integrators, and the output."""
        numerator = [in_brackets(entry) for entry in self._numerator]
        return realize(
            self.name, in_brackets(self.input), numerator, [in_brackets(a) for a in self.denominator]
        )


def realize(
    name: str, given: str, numerator: Sequence[str], denominator: Sequence[str], unit: str = ""
) -> tuple[Signal, ...]:
    """Return a transfer function as a chain of integrators ``name_1 .. name_n`` and the output `name`.

    With a(s) x_1 = u, x_k is the derivative of x_1 of order k - 1: the controllable canonical form. Where
    time is counted in a `unit`, the polynomials are those of s times it.
    """
    n = len(denominator) - 1
    b = ["0"] * (n + 1 - len(numerator)) + list(numerator)
    first, lower = denominator[0], denominator[:0:-1]  # coefficients of x_1, x_2, ..
    states = [f"{name}_{k + 1}" for k in range(n)]
    fed_back = "".join(f" - {a}*{x}" for a, x in zip(lower, states, strict=True))
    rates = [*states[1:], f"({given}{fed_back})/{first}"]
    rates = [f"{rate}/{unit}" for rate in rates] if unit else rates
    chain = [Signal(state, rate=rate) for state, rate in zip(states, rates[:n], strict=True)]
    terms = []
    for k, state in enumerate(states):
        direct = "" if b[0] == "0" else f" - {b[0]}*{lower[k]}/{first}"
        if direct or b[n - k] != "0":
            terms.append(f"({b[n - k]}{direct})*{state}")
    if b[0] != "0":
        terms.append(f"{b[0]}/{first}*{given}")
    return (*chain, Signal(name, " + ".join(terms) or "0"))
