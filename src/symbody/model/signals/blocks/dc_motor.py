"""`DCMotor`: the torque of a motor with brushes, from voltage and speed."""

from __future__ import annotations

from typing import ClassVar, Final, final

from symbody.model.declarations.fields import Quantity
from symbody.model.declarations.formula_site import Scope
from symbody.model.numeric_checks import NOT_NEGATIVE, Domain
from symbody.model.signals.block import SignalBlock, block, in_brackets
from symbody.model.signals.signal import Signal

_INDUCTANCE: Final = Domain(
    "block.domain", "{formula} is {value} H", "the rate of the current is divided by it",
    "give henries above 0, or the torque as a formula", 0.0, above=True,
)  # fmt: skip


@final
@block
class DCMotor(SignalBlock):
    """The torque of a direct-current motor; its current is a state.

    The output is the torque: apply it at the joint whose rate is `speed`.

    Examples
    --------
    >>> import symbody as sb
    >>> motor = sb.DCMotor("T", voltage="V", speed="phi_dot", resistance=0.5, inductance=0.001, constant=0.05)
    >>> [signal.name for signal in motor.signals]
    ['T_current', 'T']
    """

    equation: ClassVar[str] = "y = constant i, inductance i' = voltage - resistance i - constant speed"
    states: ClassVar[str] = "`y_current`"

    voltage: Quantity = Quantity("Voltage at its terminals.", unit="V", scope=Scope.LOAD)
    speed: Quantity = Quantity("Speed of the rotor.", unit="rad/s", scope=Scope.LOAD)
    resistance: Quantity = Quantity("Of the winding.", unit="Ohm", scope=Scope.LOAD, fits=NOT_NEGATIVE)
    inductance: Quantity = Quantity("Of the winding.", unit="H", scope=Scope.LOAD, fits=_INDUCTANCE)
    constant: Quantity = Quantity(
        "Torque per current, and voltage per speed.", unit="N m/A, V s/rad", scope=Scope.LOAD
    )
    initial: Quantity = Quantity("Initial current.", unit="A", default=0)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The current, and the torque."""
        parts = self.voltage, self.speed, self.resistance, self.inductance, self.constant
        voltage, speed, resistance, inductance, constant = (in_brackets(part) for part in parts)
        current = f"{self.name}_current"
        rate = f"({voltage} - {resistance}*{current} - {constant}*{speed})/{inductance}"
        return (
            Signal(current, rate=rate, initial=self.initial),
            Signal(self.name, f"{constant}*{current}"),
        )
