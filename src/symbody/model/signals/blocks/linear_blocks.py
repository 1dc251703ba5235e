"""Linear blocks: a lag, a transfer function, matrices, and a delay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import comb, factorial, sqrt
from typing import ClassVar, Final, final

from symbody.errors import ModelError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import list_of, optional
from symbody.model.declarations.fields import Formulas, OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NOT_NEGATIVE, SAMPLE_TIME, TIME, Demand, Domain
from symbody.model.signals.block import FormulaRows, Rows, SignalBlock, block, in_brackets
from symbody.model.signals.signal import Signal


@final
@block
class FirstOrder(SignalBlock):
    """A first-order lag: the output is a state that follows the input.

    Examples
    --------
    >>> import symbody as sb
    >>> lag = sb.FirstOrder("pressure", input="valve", time=0.1, gain=2)
    >>> [signal.name for signal in lag.signals]
    ['pressure']
    """

    equation: ClassVar[str] = "time y' = gain input - y"
    states: ClassVar[str] = "`y`, the output itself"

    input: Quantity = Quantity("The signal it follows.", scope=Scope.LOAD)
    time: Quantity = Quantity("Time constant.", unit="s", scope=Scope.LOAD, fits=TIME)
    gain: Quantity = Quantity("Ratio of output to input at rest.", default=1, scope=Scope.LOAD)
    initial: Quantity = Quantity("Initial output.", default=0)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The state."""
        given, time, gain = (in_brackets(part) for part in (self.input, self.time, self.gain))
        rate = f"({gain}*{given} - {self.name})/{time}"
        return (Signal(self.name, rate=rate, initial=self.initial),)


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


@final
@block
class StateSpace(SignalBlock):
    """A linear block ``x' = A x + B u``, ``y = C x + D u`` with any numbers of inputs and outputs.

    Sampled, ``A x + B u`` is the state at the next sample. Its output bears its name; several outputs are
    ``name_1``, ``name_2``, and so on.

    Examples
    --------
    >>> import symbody as sb
    >>> filter = sb.StateSpace("y", ["F"], A=[[0, 1], [-4, -0.4]], B=[[0], [1]], C=[[1, 0]])
    >>> [signal.name for signal in filter.signals]
    ['y_x1', 'y_x2', 'y']
    """

    equation: ClassVar[str] = "x' = A x + B u, y = C x + D u; if sampled, A x + B u is the next x"
    states: ClassVar[str] = "`y_x1`, `y_x2`, .."

    inputs: Formulas = list_of(Quantity("The inputs u.", scope=Scope.LOAD))
    A: FormulaRows = list_of(list_of(Quantity("(n, n), row by row.")))
    B: FormulaRows = list_of(list_of(Quantity("(n, inputs), row by row.")))
    C: FormulaRows = list_of(list_of(Quantity("(outputs, n), row by row.")))
    D: FormulaRows = list_of(list_of(Quantity("(outputs, inputs), row by row; by default 0.")), default=())
    initial: Formulas = list_of(Quantity("Initial states, by default 0."), default=())
    sample: OptionalQuantity = optional(
        Quantity(
            "Time between samples; x' is then the next x, without it the rate of x.",
            unit="s",
            fits=SAMPLE_TIME,
        )
    )

    def check(self, arguments: Arguments) -> None:
        """Note matrices that do not fit each other."""
        SignalBlock.check(self, arguments)
        n, m, p = len(self.A), len(self.inputs), len(self.C)
        for name, rows, height, width in (
            ("A", self.A, n, n), ("B", self.B, n, m), ("C", self.C, p, n), ("D", self.D or ((),) * p, p, m),
        ):  # fmt: skip
            fits = len(rows) == height and all(len(row) == width for row in rows)
            if not fits and not (name == "D" and not self.D):
                why = f"A is {n} by {n}, and there are {m} inputs and {p} outputs"
                cure = f"give {height} rows of {width}"
                arguments.add("block.matrix", name, f"{name} is not {height} by {width}", why, cure)
        if self.initial and len(self.initial) != n:
            what = f"there are {len(self.initial)} initial values"
            arguments.add("block.matrix", "initial", what, f"there are {n} states", f"give {n}")

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states, and the outputs."""
        states = [f"{self.name}_x{k + 1}" for k in range(len(self.A))]
        given = [in_brackets(formula) for formula in self.inputs]
        starts: Sequence[Formula | int] = self.initial or (0,) * len(states)
        rates = [_row_sum(a, states, b, given) for a, b in zip(self.A, self.B, strict=True)]
        direct: Rows = self.D or ((),) * len(self.C)
        values = [_row_sum(c, states, d, given if d else ()) for c, d in zip(self.C, direct, strict=True)]
        alone = len(values) == 1
        names = [self.name if alone else f"{self.name}_{k + 1}" for k in range(len(values))]
        pairs = zip(names, values, strict=True)
        outputs = [Signal(name, value, sample=self.sample) for name, value in pairs]
        if self.sample is None:
            rows = zip(states, rates, starts, strict=True)
            return (*(Signal(x, rate=rate, initial=x0) for x, rate, x0 in rows), *outputs)
        following = [f"{self.name}_next{k + 1}" for k in range(len(states))]
        nexts = zip(following, rates, strict=True)
        computed = [Signal(x, rate, sample=self.sample) for x, rate in nexts]
        moves = zip(states, following, starts, strict=True)
        moved = [Signal(x, value, initial=x0, sample=self.sample) for x, value, x0 in moves]
        return (*outputs, *computed, *moved)

    @property
    def continuous(self) -> None:
        """None: give the matrices of the continuous block."""
        return


def _row_sum(
    first: Sequence[Formula], states: Sequence[str], second: Sequence[Formula], given: Sequence[str]
) -> str:
    """Return a row of ``first x + second u``."""
    factors = [*zip(first, states, strict=True), *zip(second, given, strict=True)]
    terms = [f"{in_brackets(factor)}*{x}" for factor, x in factors if factor.constant() != 0]
    return " + ".join(terms) or "0"


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
