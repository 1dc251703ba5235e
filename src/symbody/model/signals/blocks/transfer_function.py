"""`TransferFunction`: a linear block given by two polynomials."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import comb
from typing import ClassVar, Final, final

from symbody.errors import ModelError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import list_of, optional
from symbody.model.declarations.fields import Formulas, OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import SAMPLE_TIME, Demand, Domain
from symbody.model.signals.block import SignalBlock, block, in_brackets
from symbody.model.signals.signal import Signal

_LEADING: Final = Domain(
    "block.no_polynomial", "{formula} is {value}",
    "the first coefficient belongs to the highest power and must not be 0",
    "remove leading powers with a zero coefficient",
    nonzero=True,
)  # fmt: skip


@final
@block
class TransferFunction(SignalBlock):
    """A linear block given by the coefficients of two polynomials, highest power first; it starts at rest.

    Sampled, they are polynomials in z, as `control.tf(numerator, denominator, dt)` takes them.

    Examples
    --------
    >>> [signal.name for signal in TransferFunction("y", "u", [1], [1, 2, 1]).signals]
    ['y_1', 'y_2', 'y']
    """

    equation: ClassVar[str] = "y = numerator(s)/denominator(s) input; sampled, of z"
    states: ClassVar[str] = "`y_1`, `y_2`, ..: as many as the denominator's degree"

    input: Quantity = Quantity("The input signal.", scope=Scope.LOAD)
    numerator: Formulas = list_of(Quantity("Its coefficients, highest power first."))
    denominator: Formulas = list_of(Quantity("Its coefficients, highest power first; the first is not 0."))
    sample: OptionalQuantity = optional(
        Quantity(
            "Time between samples; the polynomials are then in z, without it in s.",
            unit="s",
            fits=SAMPLE_TIME,
        )
    )

    def check(self, arguments: Arguments) -> None:
        """Note polynomials that make no proper transfer function."""
        SignalBlock.check(self, arguments)
        if not self.numerator or not self.denominator:
            what = "the polynomials have no leading coefficients"
            why = "the first coefficient belongs to the highest power"
            fix = "write denominator = [1, 2, 1] for s^2 + 2 s + 1"
            arguments.add("block.no_polynomial", "denominator", what, why, fix)
        elif len(self._numerator) > len(self.denominator):
            arguments.add(
                "block.improper", "numerator", "its degree is higher than that of the denominator",
                "this differentiates its input, and the derivative of a rate is an acceleration",
                "raise the degree of the denominator, for instance with a filter (1 + T s) and a short time "
                "T",
            )  # fmt: skip

    def joint_demands(self) -> Iterator[Demand]:
        """Yield the demand on the first coefficient of the denominator."""
        if self.denominator:
            yield Demand("denominator[0]", self.denominator[0], _LEADING)

    @property
    def _numerator(self) -> tuple[Formula, ...]:
        """The numerator without the zeros in front, which no input passes."""
        zeros = [entry.constant() == 0 for entry in self.numerator]
        return self.numerator[zeros.index(False) if False in zeros else len(zeros) :]

    @property
    def signals(self) -> tuple[Signal, ...]:
        """A chain of integrators, and the output."""
        numerator = [in_brackets(entry) for entry in self._numerator]
        denominator = [in_brackets(entry) for entry in self.denominator]
        if self.sample is not None:
            return _sampled_signals(self, numerator, denominator)
        return realize(self.name, in_brackets(self.input), numerator, denominator)

    @property
    def continuous(self) -> TransferFunction | None:
        """The block by the bilinear rule of Tustin, z = (1 + s dt/2)/(1 - s dt/2)."""
        assert self.sample is not None
        half, n = f"({in_brackets(self.sample)}/2)", len(self.denominator) - 1
        numerator, denominator = (
            [in_brackets(entry) for entry in row] for row in (self._numerator, self.denominator)
        )
        padded = ["0"] * (n + 1 - len(numerator)) + numerator
        top, bottom = (_bilinear(row, half) for row in (padded, denominator))
        try:
            return TransferFunction(self.name, self.input, top, bottom)
        except ModelError:  # a pole at z = -1 is one at infinity
            return None


def _bilinear(coefficients: Sequence[str], half: str) -> list[str]:
    """Return the coefficients of powers of s, highest first, of a polynomial in z times (1 - half s)^n."""
    n = len(coefficients) - 1
    rows = [
        [sum((-1) ** j * comb(k, j) * comb(n - k, power - j) for j in range(power + 1)) for k in range(n + 1)]
        for power in range(n, -1, -1)
    ]
    sums = [" + ".join(f"({c})*{a}" for c, a in zip(row, coefficients, strict=True)) for row in rows]
    return [f"({total})*{half}^{n - place}" for place, total in enumerate(sums)]


def _sampled_signals(
    block: TransferFunction, numerator: Sequence[str], denominator: Sequence[str]
) -> tuple[Signal, ...]:
    """Return what enters a chain of delays, the output, and the delays, the last first."""
    name, given, n = block.name, in_brackets(block.input), len(denominator) - 1
    first, lower = denominator[0], denominator[1:]
    b = ["0"] * (n + 1 - len(numerator)) + list(numerator)
    delays = [f"{name}_{k + 1}" for k in range(n)]
    fed_back = "".join(f" - {a}*{x}" for a, x in zip(lower, delays, strict=True))
    chain = [f"{name}_0", *delays]
    terms = [f"{weight}*{x}" for weight, x in zip(b, chain, strict=True) if weight != "0"]
    moves = zip(delays[::-1], chain[-2::-1], strict=True)
    values = [(f"{name}_0", f"({given}{fed_back})/{first}"), (name, " + ".join(terms) or "0"), *moves]
    return tuple(Signal(own, value, sample=block.sample) for own, value in values)


def realize(
    name: str, given: str, numerator: Sequence[str], denominator: Sequence[str]
) -> tuple[Signal, ...]:
    """Return a transfer function as a chain of integrators ``name_1 .. name_n`` and the output `name`.

    With a(s) x_1 = u, x_k is the derivative of x_1 of order k - 1: the controllable canonical form.
    """
    n = len(denominator) - 1
    b = ["0"] * (n + 1 - len(numerator)) + list(numerator)
    first, lower = denominator[0], denominator[:0:-1]  # coefficients of x_1, x_2, ..
    states = [f"{name}_{k + 1}" for k in range(n)]
    fed_back = "".join(f" - {a}*{x}" for a, x in zip(lower, states, strict=True))
    rates = [*states[1:], f"({given}{fed_back})/{first}"]
    chain = [Signal(state, rate=rate) for state, rate in zip(states, rates[:n], strict=True)]
    terms = []
    for k, state in enumerate(states):
        direct = "" if b[0] == "0" else f" - {b[0]}*{lower[k]}/{first}"
        if direct or b[n - k] != "0":
            terms.append(f"({b[n - k]}{direct})*{state}")
    if b[0] != "0":
        terms.append(f"{b[0]}/{first}*{given}")
    return (*chain, Signal(name, " + ".join(terms) or "0"))
