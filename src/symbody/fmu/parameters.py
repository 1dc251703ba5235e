"""Parameters of an FMU: which are set by an importer, and which follow from others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest
from symbody.expr.language.formula import Formula
from symbody.expr.sequences.dependencies import dependencies
from symbody.expr.sequences.sequence import Sequence
from symbody.model.declarations.arguments import plain_value
from symbody.model.model import resolve_parameters

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FmuParameters:
    """Parameters of an FMU.

    Attributes
    ----------
    given : mapping
        What differs from the model.
    arguments : tuple of str
        Parameters that an importer may set.
    fixed : frozenset of str
        Those among them that it may set only before the motion.
    values : (n,) array
        Their first values.
    calculated : tuple of str
        Parameters that are formulas of others.
    fixed_formulas : mapping
        Those of `given` that are no arguments.
    """

    given: Mapping[str, Value]
    arguments: tuple[str, ...]
    fixed: frozenset[str]
    values: Floats
    calculated: tuple[str, ...]
    fixed_formulas: Mapping[str, Value]

    def with_fixed(self, sequence: Sequence) -> FmuParameters:
        """Return the same with all that a sequence reads fixed."""
        read = frozenset().union(*dependencies(sequence))
        more = {name for place, name in enumerate(self.arguments) if ("p", place) in read}
        return replace(self, fixed=self.fixed | more)

    def fix_values(self, names: tuple[str, ...]) -> FmuParameters:
        """Return the same where some are numbers, not arguments."""
        stays = [name not in names for name in self.arguments]
        arguments = tuple(name for name in self.arguments if name not in names)
        numbers = {name: self.given[name] for name in names if name in self.given}
        return replace(
            self, arguments=arguments, fixed=self.fixed.difference(names), values=self.values[stays],
            fixed_formulas={**self.fixed_formulas, **numbers},
        )  # fmt: skip


def fmu_parameters(eqs: EquationSet, given: Mapping[str, Value], fixed: Iterable[str]) -> FmuParameters:
    """Return the parameters of an FMU.

    Raises UsageError if a name in `fixed` is not a parameter that can be set; ModelError if a parameter has
    no value.
    """
    values = resolve_parameters(eqs.model, given)
    formulas = dict(eqs.model.parameters) | {
        name: Formula.from_value(plain_value(value), where=name) for name, value in given.items()
    }
    calculated = tuple(
        name for name in eqs.parameter_names
        if (formula := formulas[name]) is not None and set(formula.names) - {"pi"}
    )  # fmt: skip
    arguments = tuple(name for name in eqs.parameter_names if name not in calculated)
    problems = [
        Problem("fmu.fixed", "fixed", f"{name!r} is not a parameter that an importer can set",
                "it follows from others" if name in calculated else "", nearest(name, arguments))
        for name in fixed if name not in arguments
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    first = np.array([float(values[name]) for name in arguments])
    others = {name: value for name, value in given.items() if name not in arguments}
    return FmuParameters(dict(given), arguments, frozenset(fixed), first, calculated, others)
