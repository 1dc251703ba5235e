"""`Delay`: a pure delay by the approximation of Pade; sampled, an exact one."""

from __future__ import annotations

from fractions import Fraction
from math import factorial
from typing import ClassVar, Final, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.fields import OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.signals.block import SignalBlock, in_brackets
from symbody.model.signals.block_fields import block
from symbody.model.signals.blocks.transfer_function import realize
from symbody.model.signals.signal import Signal, check_sample

_HIGHEST: Final = 10  # coefficients of further orders span more than the digits of a double
_MOST: Final = 1000  # samples
_EXACT: Final = 1e-9  # share by which times in decimals may miss a whole number of samples


@final
@block
class Delay(SignalBlock):
    """A delay, by the approximation of Pade of an order: exact delays are not states.

    Sampled, it is exact: what was sampled `time` ago, 0 before that.
    """

    equation: ClassVar[str] = "y(t) = input(t - time), near it for frequencies below order/time"
    states: ClassVar[str] = "`y_1` .. `y_order`; sampled `y_1` .. `y_n`, n = time/sample"

    input: Quantity = Quantity("What is delayed.", scope=Scope.LOAD)
    time: Quantity = Quantity("How long it is delayed.", unit="s")
    order: Quantity = Quantity("Order of the approximation, 1 to 10.", default=3)
    sample: OptionalQuantity = OptionalQuantity(
        "Time between samples, of which the delay is a multiple; continuous without.", unit="s"
    )

    def check(self, arguments: Arguments) -> None:
        """Note an order that is none, and a delay that is not a number of samples."""
        check_sample(arguments, self.sample)
        if self.sample is not None and self._samples is None:
            arguments.add(
                "block.delay_samples", "time",
                f"{self.time} is not a multiple of the sample time {self.sample}",
                f"a sampled delay keeps a value of each sample, {_MOST} at most",
                "give both as numbers, such as time = 0.05, sample = 0.01",
            )  # fmt: skip
        order = self.order.constant()
        if not isinstance(order, int) or not 1 <= order <= _HIGHEST:
            arguments.add(
                "block.order", "order", f"{self.order} is not an order of an approximation",
                "the delay becomes a ratio of two polynomials of this degree", f"write 1 to {_HIGHEST}",
            )  # fmt: skip

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states, in which time is counted in delays, and the output."""
        if self.sample is not None:
            return self._sampled_signals()
        order = int(self.order.constant() or 1)
        weights = [_weight(order, k) for k in range(order, -1, -1)]
        signed = [weight if (order - k) % 2 == 0 else -weight for k, weight in enumerate(weights)]
        numerator, denominator = ([f"({each})" for each in row] for row in (signed, weights))
        return realize(self.name, in_brackets(self.input), numerator, denominator, in_brackets(self.time))

    @property
    def _samples(self) -> int | None:
        """How many samples the delay lasts; None where that is not a number."""
        time, sample = self.time.constant(), None if self.sample is None else self.sample.constant()
        if time is None or sample is None or not sample > 0:
            return None
        ratio = float(time) / float(sample)
        count = round(ratio) if 0.0 <= ratio <= _MOST else -1
        return count if count >= 0 and abs(ratio - count) <= _EXACT * max(ratio, 1.0) else None

    def _sampled_signals(self) -> tuple[Signal, ...]:
        """Return the output, then what was sampled: the oldest first, each takes the place of the next."""
        count = self._samples or 0
        places = [f"{self.name}_{k + 1}" for k in range(count)]
        chain = zip([self.name, *places[::-1]], [*places[::-1], in_brackets(self.input)], strict=True)
        return tuple(Signal(name, value, sample=self.sample) for name, value in chain)


def _weight(n: int, k: int) -> Fraction:
    """Return the coefficient of ``(time s)^k``."""
    return Fraction(factorial(2 * n - k) * factorial(n), factorial(2 * n) * factorial(k) * factorial(n - k))
