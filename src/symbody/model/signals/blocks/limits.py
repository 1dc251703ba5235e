"""Blocks that limit and switch: a follower whose slope is limited, a relay with two thresholds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Final, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import optional
from symbody.model.declarations.fields import OptionalQuantity, Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NOT_NEGATIVE, SAMPLE_TIME, TIME, Demand, Domain
from symbody.model.signals.block import SignalBlock, block, difference, in_brackets
from symbody.model.signals.signal import Signal


@final
@block
class RateLimit(SignalBlock):
    """Follows a signal with a limited slope; slower changes it follows with a first-order lag.

    Sampled, it follows without a lag: from sample to sample by as much as the slopes allow.

    Examples
    --------
    >>> import symbody as sb
    >>> limit = sb.RateLimit("steering", input="demand", rise=0.5, time=0.01)
    >>> [signal.name for signal in limit.signals]
    ['steering']
    """

    equation: ClassVar[str] = "y' = min(rise, max(-fall, (input - y)/time))"
    states: ClassVar[str] = "`y`, the output itself"

    input: Quantity = Quantity("The signal it follows.", scope=Scope.LOAD)
    rise: Quantity = Quantity("Fastest rise per second.", scope=Scope.LOAD, fits=NOT_NEGATIVE)
    time: OptionalQuantity = optional(
        Quantity(
            "Time constant of the lag, short; not used when sampled.", unit="s", scope=Scope.LOAD, fits=TIME
        )
    )
    fall: OptionalQuantity = optional(Quantity(
        "Fastest fall per second, positive; by default equal to rise.", scope=Scope.LOAD,
        fits=NOT_NEGATIVE,
    ))  # fmt: skip
    initial: Quantity = Quantity("Initial output.", default=0)
    sample: OptionalQuantity = optional(
        Quantity("Time between samples; without it the block is continuous.", unit="s", fits=SAMPLE_TIME)
    )

    def check(self, arguments: Arguments) -> None:
        """Note a lag that is missing, or one too many."""
        SignalBlock.check(self, arguments)
        if self.time is None and self.sample is None:
            why = "a continuous output follows its input with a lag"
            fix = "give time, short compared with the motion, or sample, the time between samples"
            arguments.add("block.time", "time", "there is no time constant", why, fix)
        elif self.time is not None and self.sample is not None:
            why = "at each sample it moves towards its input as far as the slopes allow"
            arguments.add("block.time", "time", "a sampled rate limit has no lag", why, "remove time")

    @property
    def continuous(self) -> RateLimit:
        """The block without samples: its lag is the time between them."""
        return RateLimit(**{**self.given_arguments(), "time": self.sample, "sample": None})

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The state."""
        given, rise = in_brackets(self.input), in_brackets(self.rise)
        fall = rise if self.fall is None else in_brackets(self.fall)
        if self.sample is not None:
            dt = in_brackets(self.sample)
            step = f"min({rise}*{dt}, max(-{fall}*{dt}, {given} - {self.name}))"
            value = f"{self.name} + {step}"
            return (Signal(self.name, value, initial=self.initial, sample=self.sample),)
        assert self.time is not None
        time = in_brackets(self.time)
        rate = f"min({rise}, max(-{fall}, ({given} - {self.name})/{time}))"
        return (Signal(self.name, rate=rate, initial=self.initial),)


_THRESHOLDS: Final = Domain(
    "block.thresholds", "it is above the upper threshold: {formula} is {value}",
    "between them the output does not change", "swap them", 0.0,
)  # fmt: skip


@final
@block
class Hysteresis(SignalBlock):
    """A relay with two thresholds, evaluated at each sample; between them its output does not change.

    Examples
    --------
    >>> str(Hysteresis("heater", "20 - T", lower=-1, upper=1, sample=0.1).signals[0].value)
    'if(20 - T > 1, 1, if(20 - T < (-1), 0, heater))'
    """

    equation: ClassVar[str] = "y = high where input > upper, low where input < lower, otherwise unchanged"
    states: ClassVar[str] = "sampled `y`, the output itself"

    input: Quantity = Quantity("The signal to compare.", scope=Scope.LOAD)
    lower: Quantity = Quantity("Threshold below which the output switches to low.", scope=Scope.LOAD)
    upper: Quantity = Quantity("Threshold above which the output switches to high.", scope=Scope.LOAD)
    sample: Quantity = Quantity("Time between samples.", unit="s", fits=SAMPLE_TIME)
    low: Quantity = Quantity("Output below the lower threshold.", default=0, scope=Scope.LOAD)
    high: Quantity = Quantity("Output above the upper threshold.", default=1, scope=Scope.LOAD)
    initial: Quantity = Quantity("Output before the first sample.", default=0)

    def joint_demands(self) -> Iterator[Demand]:
        """Yield the demand on the order of the thresholds."""
        yield Demand("lower", difference(self.upper, self.lower), _THRESHOLDS)

    @property
    def continuous(self) -> None:
        """None: no smooth block is equivalent."""
        return

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The output."""
        given, lower, upper = self.input.text, in_brackets(self.lower), in_brackets(self.upper)
        value = f"if({given} > {upper}, {self.high}, if({given} < {lower}, {self.low}, {self.name}))"
        return (Signal(self.name, value, initial=self.initial, sample=self.sample),)
