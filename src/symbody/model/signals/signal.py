"""`Signal`: a name for a formula, for an output of the mechanism, or for a state that has a rate."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.arguments import Arguments
from symbody.model.element import Element
from symbody.model.element_fields import element
from symbody.model.fields import OptionalQuantity, OptionalText, Quantity, SymbolElementName
from symbody.model.formula_site import Scope


@final
@element
class Signal(Element):
    """A name that formulas may contain: of a value, of an output of the mechanism, or of a state with a rate.

    Examples
    --------
    >>> Signal("error", "theta_ref - theta").is_state
    False
    >>> Signal("i", rate="(V - R*i - ke*theta_dot)/L", initial=2).is_state
    True
    """

    kind: ClassVar[str] = "signal"

    name: SymbolElementName = SymbolElementName("Unique among the symbols of the model.")
    value: OptionalQuantity = OptionalQuantity("Formula that the name stands for.", scope=Scope.LOAD)
    output: OptionalText = OptionalText("Output of the mechanism that the name stands for.")
    rate: OptionalQuantity = OptionalQuantity(
        "Derivative in time; it makes the signal a state.", scope=Scope.LOAD
    )
    initial: Quantity = Quantity("Value at the start, of a state.", default=0)

    @property
    def is_state(self) -> bool:
        """Whether the signal has a rate."""
        return self.rate is not None

    def check(self, arguments: Arguments) -> None:
        """Note a signal that is not exactly one of the three, and an initial value of what has none."""
        forms = {"value": self.value, "output": self.output, "rate": self.rate}
        given = [word for word, argument in forms.items() if argument is not None]
        if len(given) != 1:
            what = f"{' and '.join(given)} are given" if given else "neither value, output nor rate is given"
            why = "a signal is a name for one formula, for one output, or a state with one rate"
            arguments.add("signal.one_of", "", what, why, "give exactly one of value, output and rate")
        if given == ["value"] or given == ["output"]:
            if self.initial.constant() != 0:
                why = "what it is follows from its formula at every time"
                cure = "leave initial out, or give a rate"
                arguments.add("signal.initial", "initial", "only a state has an initial value", why, cure)
