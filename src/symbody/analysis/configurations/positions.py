"""Configurations without velocities and accelerations: what a picture of a mechanism needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble, consistent_positions
from symbody.analysis.configurations.kept_values import held_initial_values
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.named_values import named_values
from symbody.analysis.scales import mechanism_scales
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import constant_values
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements


@dataclass(frozen=True, slots=True, eq=False)
class PositionSolver:
    """Closes the loops of one mechanism again and again, with its own values of the parameters.

    Attributes
    ----------
    evaluator : ConstraintEvaluator or None
        None where gaps decide what is closed.
    parameters : mapping of name to number or formula
        Take the place of the model's values.
    """

    eqs: EquationSet
    evaluator: ConstraintEvaluator | None
    parameters: Mapping[str, Value] = field(default_factory=dict)

    def positions(self, fixed: Mapping[str, Value], guess: Mapping[str, Value]) -> dict[str, float]:
        """Return all coordinates q where the loops close, as `assemble` finds them.

        Raises
        ------
        AssemblyError
            As `assemble`; but accelerations need not exist.
        """
        if self.evaluator is None:
            return dict(assemble(self.eqs, fixed, guess, parameters=self.parameters).q)
        fixed = {**held_initial_values(self.eqs, fixed, guess), **fixed}
        model = self.eqs.model.initial
        guessed: dict[str, Value] = {
            **guess,
            **{name: value for name, value in model.items() if name not in guess},
        }
        near = named_values(self.eqs, guessed, self.parameters, strict=set(guess))
        values = named_values(self.eqs, fixed, self.parameters, strict=set(fixed)) if fixed else {}
        q = consistent_positions(self.evaluator, values, near)
        return dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))

    def nearest(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coordinates (n_q,) nearest to others at which the loops close.

        The initial values of the model have no part in it.

        Raises
        ------
        AssemblyError
            If they close nowhere near.
        """
        guess = dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))
        if self.evaluator is None:
            return np.array(list(assemble(self.eqs, None, guess, parameters=self.parameters).q.values()))
        return consistent_positions(self.evaluator, {}, guess)


def position_solver(
    eqs: EquationSet,
    parameters: Mapping[str, Value] | None = None,
    constraints: CompiledFunction | None = None,
) -> PositionSolver:
    """Return a solver that closes the loops of a mechanism.

    Parameters
    ----------
    parameters : mapping of name to number or formula, optional
        Take the place of the model's values.
    constraints : CompiledFunction, optional
        A `constraint_function` with all parameters free: solvers for several values share it.

    Raises
    ------
    ModelError, CompileError
        If parameters have no values.
    """
    given = dict(parameters or {})
    if unilateral_elements(eqs.formed):
        return PositionSolver(eqs, None, given)
    near = named_values(eqs, dict(eqs.model.initial), given, strict=set())
    scales = mechanism_scales(eqs, given, None, near)
    bound = None if constraints is None else constraints.bind(_numbers(eqs, given))
    return PositionSolver(eqs, constraint_evaluator(eqs, given, {}, 0.0, scales, bound), given)


def _numbers(eqs: EquationSet, parameters: Mapping[str, Value]) -> list[float]:
    """Return the values of all parameters, in their order."""
    values = constant_values(eqs, {name: name for name in eqs.parameter_names}, parameters)
    return [values[name] for name in eqs.parameter_names]
