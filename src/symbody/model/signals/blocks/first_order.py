"""`FirstOrder`: a lag."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.declarations.fields import Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import TIME
from symbody.model.signals.block import SignalBlock, block, in_brackets
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
