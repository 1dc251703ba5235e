"""Closed states beside the present one of a stepper."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble, close
from symbody.analysis.configurations.unsubstituted import with_followers
from symbody.analysis.constraint_evaluator import constraint_evaluator
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.closing_equations import closing_equations
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.simulation.stepper.numbers import StepNumbers, state_values
from symbody.simulation.stepper.step_problem import StepProblem

Floats = NDArray[np.float64]


def close_again(problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value]) -> Floats | None:
    """Return the closed state (u, q, s) nearest to the present one with values of parameters.

    Of mechanisms in which nothing has to be closed None.
    """
    eqs, formulas, x = problem.settings.eqs, problem.own_laws.formulas, numbers.x[:-1].copy()
    whole = closing_equations(eqs)
    if not (whole.multiplier_names or whole.quaternions):
        return None
    if unilateral_elements(eqs.formed):  # which of them are taut follows from the state
        return state_values(nearest_state(problem, numbers, parameters, {}))
    scales = mechanism_scales(whole, parameters, problem.problem.scales.sizes)
    signals = x[len(eqs.speed_names) + len(eqs.coordinate_names) :]
    evaluator = constraint_evaluator(whole, parameters, formulas, numbers.t, scales, signals=signals)
    present = dict(zip(eqs.state_names, x.tolist(), strict=True))
    present = with_followers(eqs, present, problem.parameters)
    near = {name: present[name] for name in whole.coordinate_names}
    q, u = close(evaluator, {}, near, np.array([present[name] for name in whole.speed_names]))
    closed = dict(zip((*whole.coordinate_names, *whole.speed_names), [*q, *u], strict=True))
    return np.array([closed.get(name, present[name]) for name in eqs.state_names])


def nearest_state(
    problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value], inputs: Mapping[str, float]
) -> State:
    """Return the present state, closed, with accelerations and multipliers; `inputs` are those of steps."""
    eqs = problem.settings.eqs
    near = dict(zip(eqs.state_names, numbers.x.tolist(), strict=False))
    given = {**problem.own_laws.formulas, **inputs}
    return assemble(
        eqs, None, near, parameters=parameters, inputs=given, t=numbers.t, scales=problem.problem.scales.sizes
    )
