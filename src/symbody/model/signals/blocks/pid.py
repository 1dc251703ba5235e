"""`PID`: a controller with proportional, integral and filtered derivative part."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import OptionalField, list_of, optional
from symbody.model.declarations.fields import OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NOT_NEGATIVE, SAMPLE_TIME, TIME, Demand, Domain
from symbody.model.signals.block import NamedGains, SignalBlock, block, difference, in_brackets
from symbody.model.signals.signal import Signal

_LIMITS: Final = Domain(
    "block.limits", "the lower limit is above the upper: {formula} is {value}",
    "the first is the lower limit, the second the upper", "swap them", 0.0,
)  # fmt: skip
_TRACKING: Final = Domain(
    "block.tracking", "p = {formula} is {value}, and there is no tracking",
    "at limits the integral is reset with the time constant p/i",
    "give tracking, a time in seconds", nonzero=True,
)  # fmt: skip
_SAME_SIGN: Final = Domain(
    "block.tracking", "p i = {formula} is {value}, and there is no tracking",
    "at limits the integral would diverge with the time constant p/i",
    "give p and i the same sign, or give tracking, a time in seconds", 0.0,
)  # fmt: skip


@final
@block
class PID(SignalBlock):
    """A controller with proportional, integral and filtered derivative parts; those without gain are omitted.

    Where the output is limited, the integral is driven back by what the limits cut off, divided by
    `tracking`. Sampled, the integral is a sum (Euler forward, counted from the next sample on), and the
    filtered derivative a difference (Euler backward).

    Examples
    --------
    >>> [signal.name for signal in PID("servo", "error", {"p": 2, "i": 1}, limits=(-1, 1)).signals]
    ['servo_integral', 'servo_unlimited', 'servo']
    """

    equation: ClassVar[str] = (
        "y = p e + integral of i e + d (e - filtered)/filter, filter filtered' = e - filtered"
    )
    states: ClassVar[str] = "`y_integral`, `y_filtered`; sampled `y_integral`, `y_derivative`, `y_error`"

    input: Quantity = Quantity("The error e.", scope=Scope.LOAD)
    gains: NamedGains = NamedGains(
        "p, i, d, and filter, the time constant [s] of the derivative.", words=("p", "i", "d", "filter")
    )
    limits: OptionalField[Iterable[Value], tuple[Formula, ...]] = optional(
        list_of(
            Quantity("Lower and upper limit of the output.", scope=Scope.LOAD), 2, nouns="limits",
            why="the first is the lower limit, the second the upper", fix='write limits = ["-Tmax", "Tmax"]',
            instead=(0, 0),
        ),
        is_nullable=True,
    )  # fmt: skip
    tracking: OptionalQuantity = optional(Quantity(
        "Time constant with which the integral is reset at limits (anti-windup); by default "
        "p/i.", unit="s", scope=Scope.LOAD,
        fits=TIME,
    ))  # fmt: skip
    initial: Quantity = Quantity("Initial integral part.", default=0)
    sample: OptionalQuantity = optional(
        Quantity(
            "Time between samples of a digital controller; without it the controller is continuous.",
            unit="s",
            fits=SAMPLE_TIME,
        )
    )

    def check(self, arguments: Arguments) -> None:
        """Note a derivative without filter, and limits without a time in which to reset the integral."""
        SignalBlock.check(self, arguments)
        if self._has("d") and not self._has("filter") and self.sample is None:
            arguments.add(
                "block.derivative", "gains.d", "there is no filter for the derivative",
                "the derivative of an error that contains rates is an acceleration, which depends on the "
                "output",
                'give gains = { .., d = "kd", filter = "Tf" } with a time Tf of about a tenth of d/p',
            )  # fmt: skip
        if self.limits is not None and self._has("i") and self.tracking is None and not self._has("p"):
            missing = "p is 0" if "p" in self.gains else "there is no p"
            what = "the time constant of the reset at limits is missing"
            why = f"the default is p/i, but {missing}"
            arguments.add("block.tracking", "limits", what, why, "give tracking, a time in seconds")
        if not self._has("i") and self.initial.constant() != 0:
            what = "there is no integral part that could start with it"
            why = "the integral alone has an initial value, and i is 0"
            arguments.add("signal.initial", "initial", what, why, "leave initial out, or give a gain i")

    def joint_demands(self) -> Iterator[Demand]:
        """Yield the demands on the filter, on the order of limits, and on p and i where p/i is a time."""
        if "filter" in self.gains:
            yield Demand("gains.filter", self.gains["filter"], TIME if self.sample is None else NOT_NEGATIVE)
        if self.limits is None:
            return
        yield Demand("limits", difference(self.limits[1], self.limits[0]), _LIMITS)
        if self._has("i") and self._has("p") and self.tracking is None:
            p, i = self.gains["p"], self.gains["i"]
            yield Demand("gains", p, _TRACKING)
            yield Demand("gains", Formula.from_value(f"({p.text})*({i.text})"), _SAME_SIGN)

    @property
    def continuous(self) -> PID:
        """The block without samples; a derivative without filter gets one as long as a sample."""
        gains = dict(self.gains)
        if self._has("d") and not self._has("filter") and self.sample is not None:
            gains["filter"] = self.sample
        return PID(**{**self.given_arguments(), "gains": gains, "sample": None})

    def _has(self, gain: str) -> bool:
        formula = self.gains.get(gain)
        return formula is not None and formula.constant() != 0

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Integral and filter as far as there are any, and the output."""
        if self.sample is not None:
            return self._sampled_signals(in_brackets(self.sample))
        name, error = self.name, in_brackets(self.input)
        gains = {word: in_brackets(gain) for word, gain in self.gains.items()}
        states, terms = [], []
        if self._has("p"):
            terms.append(f"{gains['p']}*{error}")
        if self._has("i"):
            rate = f"{gains['i']}*{error}{self._lead_back(gains)}"
            states.append(Signal(f"{name}_integral", rate=rate, initial=self.initial))
            terms.append(f"{name}_integral")
        if self._has("d"):
            change = f"({error} - {name}_filtered)/{gains['filter']}"
            states.append(Signal(f"{name}_filtered", rate=change))
            terms.append(f"{gains['d']}*{change}")
        return (*states, *self._output(terms))

    def _output(self, terms: list[str]) -> list[Signal]:
        """Return the sum of the parts, and within limits the output."""
        name, sample = self.name, self.sample
        total = " + ".join(terms) or "0"
        if self.limits is None:
            return [Signal(name, total, sample=sample)]
        low, high = (in_brackets(limit) for limit in self.limits)
        limited = Signal(name, f"min({high}, max({low}, {name}_unlimited))", sample=sample)
        return [Signal(f"{name}_unlimited", total, sample=sample), limited]

    def _sampled_signals(self, dt: str) -> tuple[Signal, ...]:
        """Return the parts of one sample after the other, each held until the next."""
        name, error = self.name, in_brackets(self.input)
        gains = {word: in_brackets(gain) for word, gain in self.gains.items()}
        before, after, terms = [], [], []
        if self._has("p"):
            terms.append(f"{gains['p']}*{error}")
        if self._has("i"):
            terms.append(f"{name}_integral")
            summed = f"{name}_integral + {dt}*({gains['i']}*{error}{self._lead_back(gains)})"
            after.append(Signal(f"{name}_integral", summed, initial=self.initial, sample=self.sample))
        if self._has("d"):
            part = f"{gains['d']}*({error} - {name}_error)"
            if self._has("filter"):
                time = gains["filter"]
                part = f"({time}*{name}_derivative + {part})/({time} + {dt})"
            else:
                part = f"{part}/{dt}"
            before = [
                Signal(f"{name}_derivative", part, sample=self.sample),
                Signal(f"{name}_error", error, sample=self.sample),
            ]
            terms.append(f"{name}_derivative")
        return (*before, *self._output(terms), *after)

    def _lead_back(self, gains: dict[str, str]) -> str:
        if self.limits is None:
            return ""
        cut = f"({self.name} - {self.name}_unlimited)"
        if self.tracking is not None:
            return f" + {cut}/{in_brackets(self.tracking)}"
        return f" + {cut}*{gains['i']}/{gains['p']}"
