"""`RateLimit`: a follower whose slope is limited."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.fields import OptionalQuantity, Quantity
from symbody.model.formula_site import Scope
from symbody.model.signals.block import SignalBlock, in_brackets
from symbody.model.signals.block_fields import block
from symbody.model.signals.signal import Signal


@final
@block
class RateLimit(SignalBlock):
    """A follower whose slope is limited; what is slower it follows with a first-order lag."""

    equation: ClassVar[str] = "y' = min(rise, max(-fall, (input - y)/time))"
    states: ClassVar[str] = "`y`, the output itself"

    input: Quantity = Quantity("What it follows.", scope=Scope.LOAD)
    rise: Quantity = Quantity("Fastest rise per second.", scope=Scope.LOAD)
    time: Quantity = Quantity("Time constant of the lag, short.", unit="s", scope=Scope.LOAD)
    fall: OptionalQuantity = OptionalQuantity(
        "Fastest fall per second, positive; by default as fast as the rise.", scope=Scope.LOAD
    )
    initial: Quantity = Quantity("Output at the start.", default=0)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The state."""
        given, time, rise = (in_brackets(part) for part in (self.input, self.time, self.rise))
        fall = rise if self.fall is None else in_brackets(self.fall)
        rate = f"min({rise}, max(-{fall}, ({given} - {self.name})/{time}))"
        return (Signal(self.name, rate=rate, initial=self.initial),)
