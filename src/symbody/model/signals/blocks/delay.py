"""`Delay`: a pure delay by the approximation of Pade."""

from __future__ import annotations

from fractions import Fraction
from math import factorial
from typing import ClassVar, Final, final

from symbody.model.arguments import Arguments
from symbody.model.fields import Quantity
from symbody.model.formula_site import Scope
from symbody.model.signals.block import SignalBlock, in_brackets
from symbody.model.signals.block_fields import block
from symbody.model.signals.blocks.transfer_function import realize
from symbody.model.signals.signal import Signal

_HIGHEST: Final = 10  # coefficients of further orders span more than the digits of a double


@final
@block
class Delay(SignalBlock):
    """A delay, by the approximation of Pade of an order: exact delays are no states."""

    equation: ClassVar[str] = "y(t) = input(t - time), near it for frequencies below order/time"
    states: ClassVar[str] = "`y_1` .. `y_order`"

    input: Quantity = Quantity("What is delayed.", scope=Scope.LOAD)
    time: Quantity = Quantity("How long it is delayed.", unit="s")
    order: Quantity = Quantity("Order of the approximation, 1 to 10.", default=3)

    def check(self, arguments: Arguments) -> None:
        """Note an order that is none."""
        order = self.order.constant()
        if not isinstance(order, int) or not 1 <= order <= _HIGHEST:
            arguments.add(
                "block.order", "order", f"{self.order} is no order of an approximation",
                "the delay becomes a ratio of two polynomials of this degree", f"write 1 to {_HIGHEST}",
            )  # fmt: skip

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states, in which time is counted in delays, and the output."""
        order = int(self.order.constant() or 1)
        weights = [_weight(order, k) for k in range(order, -1, -1)]
        signed = [weight if (order - k) % 2 == 0 else -weight for k, weight in enumerate(weights)]
        numerator, denominator = ([f"({each})" for each in row] for row in (signed, weights))
        return realize(self.name, in_brackets(self.input), numerator, denominator, in_brackets(self.time))


def _weight(n: int, k: int) -> Fraction:
    """Return the coefficient of ``(time s)^k``."""
    return Fraction(factorial(2 * n - k) * factorial(n), factorial(2 * n) * factorial(k) * factorial(n - k))
