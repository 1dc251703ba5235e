"""`Setting`: the equations, values and motion that a report is about, with what several sections need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_sections import numerals_of
from symbody.errors import SymbodyError
from symbody.expr.printing.numerals import Numerals
from symbody.simulation.results.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """What a report is about.

    Attributes
    ----------
    eqs : EquationSet
    run : Trajectory or None
        A motion to be shown.
    parameters : mapping of name to value
        Values in place of the model's.
    digits : int or None
        Significant digits of computed numbers in formulas; all by default.
    start : State or str
        The first configuration; the reason in words where there is none.
    """

    eqs: EquationSet
    run: Trajectory | None
    parameters: Mapping[str, Value]
    digits: int | None = None
    start: State | str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", self._assemble())

    @property
    def numerals(self) -> Numerals:
        """How many digits numbers of formulas have."""
        return numerals_of(self.eqs.formed.topology.model, self.digits)

    def _assemble(self) -> State | str:
        try:
            return assemble(self.eqs, parameters=self.parameters)
        except SymbodyError as error:
            return reason(error)


def reason(error: SymbodyError) -> str:
    """Return the first problem of an error as a sentence."""
    problem = error.problems[0]
    text = f"{problem.where}: {problem.what}" if problem.where else problem.what
    fix = problem.fix.rstrip(".")
    return f"{text}. {fix[:1].upper()}{fix[1:]}." if fix else f"{text}."
