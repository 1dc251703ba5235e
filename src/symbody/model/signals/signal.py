"""`Signal`: a name for a formula, for an output of the mechanism, for a state, or for a held value."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import OptionalField, optional
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import OptionalQuantity, OutputText, Quantity, SymbolElementName
from symbody.model.declarations.formula_site import Scope
from symbody.model.element import Element
from symbody.model.numeric_checks import SAMPLE_TIME, Demand, NumericChecks


@final
@element
class Signal(Element):
    """A name that formulas may contain: for a value, an output of the mechanism, or a state with a rate.

    Examples
    --------
    >>> Signal("error", "theta_ref - theta").is_state
    False
    >>> Signal("i", rate="(V - R*i - ke*theta_dot)/L", initial=2).is_state
    True
    >>> Signal("measured", "theta", sample=0.01).is_held
    True
    """

    kind: ClassVar[str] = "signal"

    name: SymbolElementName = SymbolElementName("Unique among the symbols of the model.")
    value: OptionalQuantity = optional(Quantity("Formula that defines the signal.", scope=Scope.LOAD))
    output: OptionalField[str, str | None] = optional(
        OutputText("Output of the mechanism that defines the signal."), is_nullable=True
    )
    rate: OptionalQuantity = optional(
        Quantity("Time derivative; it makes the signal a state.", scope=Scope.LOAD)
    )
    initial: Quantity = Quantity(
        "Initial value of a state, or of a sampled value before the first sample.", default=0
    )
    sample: OptionalQuantity = optional(Quantity(
        "Time between samples; the value or output is held constant from one sample to the next.", unit="s",
        fits=SAMPLE_TIME,
    ))  # fmt: skip

    @property
    def signals(self) -> tuple[Signal, ...]:
        """It alone."""
        return (self,)

    @property
    def is_state(self) -> bool:
        """Whether the signal has a rate."""
        return self.rate is not None

    @property
    def is_held(self) -> bool:
        """Whether the value is held from sample to sample."""
        return self.sample is not None

    def demands(self) -> Iterator[Demand]:
        """Yield the time between samples with its domain."""
        if self.sample is not None:
            yield Demand("sample", self.sample, SAMPLE_TIME)

    def check(self, arguments: Arguments) -> None:
        """Note a signal that is not exactly one of the three, and an initial value of what has none."""
        forms = {"value": self.value, "output": self.output, "rate": self.rate}
        given = [word for word, argument in forms.items() if argument is not None]
        if len(given) != 1:
            what = f"{' and '.join(given)} are given" if given else "neither value, output nor rate is given"
            why = "a signal is a name for a formula or an output, or a state with a rate"
            arguments.add("signal.one_of", "", what, why, "give exactly one of value, output and rate")
        check = NumericChecks({})
        self.check_numbers(check, "signal")
        for problem in check.problems:
            arguments.add(problem.code, "sample", problem.what, problem.why, problem.fix)
        if self.sample is not None and self.rate is not None:
            why = "a rate is integrated continuously, but a sampled value stays constant between samples"
            following = f"{self.name} + {self.sample}*({self.rate})"
            cure = f"write the value after one sample: value = {following!r}, or leave sample out"
            arguments.add("signal.sampled_rate", "sample", "a state with a rate is not sampled", why, cure)
        if (given == ["value"] or given == ["output"]) and self.sample is None:
            if self.initial.constant() != 0:
                why = "its formula determines its value at all times"
                cure = "remove initial, or give a rate or a sample time"
                what = "only states and sampled values have an initial value"
                arguments.add("signal.initial", "initial", what, why, cure)
