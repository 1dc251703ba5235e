"""`Delay`: a pure delay by the approximation of Pade; sampled, an exact one."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import factorial, sqrt
from typing import ClassVar, Final, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import optional
from symbody.model.declarations.fields import OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NOT_NEGATIVE, SAMPLE_TIME, TIME, Demand
from symbody.model.signals.block import SignalBlock, block, in_brackets
from symbody.model.signals.signal import Signal

_HIGHEST: Final = 10  # above that the fastest pole costs more steps than the delay gains in exactness
_MOST: Final = 1000  # samples
_EXACT: Final = 1e-9  # share by which times in decimals may miss a whole number of samples


@final
@block
class Delay(SignalBlock):
    """A delay, by a Pade approximation: an exact delay has no finite number of states.

    Sampled, it is exact: the output is what was sampled `time` ago, and 0 before that.

    Examples
    --------
    >>> import symbody as sb
    >>> delay = sb.Delay("late", "x", time=0.02, order=2)
    >>> [signal.name for signal in delay.signals]
    ['late_1', 'late_2', 'late']
    """

    equation: ClassVar[str] = "y(t) = input(t - time), approximately, for frequencies below order/time"
    states: ClassVar[str] = "`y_1` .. `y_order`; sampled `y_1` .. `y_n`, n = time/sample"

    input: Quantity = Quantity("The signal to delay.", scope=Scope.LOAD)
    time: Quantity = Quantity("Length of the delay.", unit="s")
    order: Quantity = Quantity("Order of the approximation, 1 to 10.", default=3)
    sample: OptionalQuantity = optional(Quantity(
        "Time between samples, of which the delay is a multiple; without it the block is "
        "continuous.", unit="s",
        fits=SAMPLE_TIME,
    ))  # fmt: skip

    def check(self, arguments: Arguments) -> None:
        """Note an order that is not valid, and a delay that is not a whole number of samples."""
        SignalBlock.check(self, arguments)
        if self.sample is not None and self._samples is None:
            what = f"{self.time} is not a multiple of the sample time {self.sample}"
            why = f"a sampled delay stores one value per sample, {_MOST} at most"
            fix = "give both as numbers, such as time = 0.05, sample = 0.01"
            arguments.add("block.delay_samples", "time", what, why, fix)
        order = self.order.constant()
        if not isinstance(order, int) or not 1 <= order <= _HIGHEST:
            what = f"{self.order} is not a valid order of approximation"
            why = "the delay is approximated by a ratio of two polynomials of this degree"
            arguments.add("block.order", "order", what, why, f"write 1 to {_HIGHEST}")

    def joint_demands(self) -> Iterator[Demand]:
        """Yield the demand on the time: sampled, a delay may be zero."""
        yield Demand("time", self.time, TIME if self.sample is None else NOT_NEGATIVE)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states, in which time is counted in delays, and the output."""
        if self.sample is not None:
            return self._sampled_signals()
        order = int(self.order.constant() or 1)
        given, time = in_brackets(self.input), in_brackets(self.time)
        states = [f"{self.name}_{k + 1}" for k in range(order)]
        damping, couplings = _schwarz_form(order)
        inflow = _near_root(2 * damping)
        rates = [""] * order
        for k, coupling in enumerate(couplings):
            forward = _near_root(coupling)
            rates[k] += f" + ({forward})*{states[k + 1]}"
            rates[k + 1] += f" - ({coupling / forward})*{states[k]}"
        rates[-1] += f" - ({damping})*{states[-1]} + ({inflow})*{given}"
        chain = [Signal(x, rate=f"({rate})/{time}") for x, rate in zip(states, rates, strict=True)]
        passed = f"({2 * damping / inflow})*{states[-1]}"
        output = f"{given} - {passed}" if order % 2 == 0 else f"{passed} - {given}"
        return (*chain, Signal(self.name, output))

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


def _schwarz_form(n: int) -> tuple[Fraction, list[Fraction]]:
    """Return the damping of the last state and the couplings of neighbours, the first two first.

    The denominator P_n of an all-pass is (s + damping) P_{n-1} + coupling P_{n-2}, and each lower P_k is
    s P_{k-1} + coupling P_{k-2}. With couplings as products of equal factors, of opposite sign, this is the
    balanced realization: no state grows beyond the input that it stores (Schwarz, ZAMP 7, 1956).
    """
    damping = _weight(n, n - 1) / _weight(n, n)
    monic = [_weight(n, k) / _weight(n, n) for k in range(n + 1)]
    high = [entry if (n - k) % 2 == 0 else Fraction(0) for k, entry in enumerate(monic)]
    low = [entry / damping if (n - k) % 2 else Fraction(0) for k, entry in enumerate(monic[:n])]
    couplings: list[Fraction] = []
    while len(low) > 1:
        rest = [entry - before for entry, before in zip(high, [Fraction(0), *low], strict=True)]
        degree = len(low) - 2
        couplings.insert(0, rest[degree])
        high, low = low, [entry / rest[degree] for entry in rest[: degree + 1]]
    return damping, couplings


def _near_root(number: Fraction) -> int:
    """Return a whole number near the square root: so coefficients are ratios, and the delay is as exact."""
    return max(round(sqrt(number)), 1)


def _weight(n: int, k: int) -> Fraction:
    """Return the coefficient of ``(time s)^k``."""
    return Fraction(factorial(2 * n - k) * factorial(n), factorial(2 * n) * factorial(k) * factorial(n - k))
