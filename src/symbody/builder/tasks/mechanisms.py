"""Mechanisms of the last few models: what values of their parameters do not change.

A check, a picture and a drag of the same mechanism share it, so that equations are formed once for each
structure, however often a value is typed anew.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from symbody.analysis.configurations.positions import PositionSolver, position_solver
from symbody.analysis.constraint_evaluator import constraint_function
from symbody.builder.tasks.reading import Data, Latest, model_key
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import exchange_values, form_equations
from symbody.model.model import Model

_FORMING: Final = 10.0  # seconds that equations may take before a job has to form them


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """What values of parameters do not change.

    Attributes
    ----------
    eqs : EquationSet
        With the values of the model that they were formed of.
    constraints : CompiledFunction
        Their constraints, with all parameters as arguments.
    """

    eqs: EquationSet
    constraints: CompiledFunction

    def with_values(self, model: Model) -> EquationSet:
        """Return the equations of the same mechanism with the values of another model."""
        return exchange_values(self.eqs, model)

    def solver(self, eqs: EquationSet, parameters: Mapping[str, Value] | None = None) -> PositionSolver:
        """Return what closes the loops for the values of equations, or others."""
        return position_solver(eqs, parameters or {}, self.constraints)


_MECHANISMS: Final[Latest[Mechanism]] = Latest(4)
_SOLVERS: Final[Latest[PositionSolver]] = Latest(4)


def mechanism_of(data: Data, folder: str, make: Callable[[], Model]) -> Mechanism:
    """Return the mechanism of a model, formed if it is not among the last few.

    Parameters
    ----------
    make : callable
        Returns the model of the data.

    Raises
    ------
    SymbodyError
        If there are no equations.
    """
    return _MECHANISMS.get(_structure_key(data, folder), lambda: _form(make()))


def solver_of(data: Data, folder: str, model: Model) -> PositionSolver:
    """Return what closes the loops of a model, made if it is not among the last few.

    Raises
    ------
    SymbodyError
        If there are no equations, or parameters have no values.
    """

    def make() -> PositionSolver:
        mechanism = mechanism_of(data, folder, lambda: model)
        return mechanism.solver(mechanism.with_values(model))

    return _SOLVERS.get(model_key(data, folder), make)


def formed_count() -> int:
    """Return how many sets of equations this process has formed."""
    return _MECHANISMS.count


def _structure_key(data: Data, folder: str) -> str:
    """Return what tells a mechanism from all others, whatever the values of its parameters."""
    given: Mapping[str, Any] = data.get("parameters") or {}
    return model_key({**data, "parameters": sorted(given)}, folder)


def _form(model: Model) -> Mechanism:
    eqs = form_equations(model, time_limit=_FORMING)
    return Mechanism(eqs, constraint_function(eqs, {}, {}, eqs.parameter_names))
