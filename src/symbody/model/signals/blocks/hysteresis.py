"""`Hysteresis`: a relay with two thresholds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Final, final

from symbody.model.declarations.fields import Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import SAMPLE_TIME, Demand, Domain
from symbody.model.signals.block import SignalBlock, block, difference, in_brackets
from symbody.model.signals.signal import Signal

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
