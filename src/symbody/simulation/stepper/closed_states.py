"""Closed states beside the present one of a stepper."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble, close
from symbody.analysis.constraint_evaluator import constraint_evaluator
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.solving.ropes import ropes
from symbody.simulation.stepper.numbers import StepNumbers, state_values
from symbody.simulation.stepper.step_problem import StepProblem

Floats = NDArray[np.float64]


def close_again(problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value]) -> Floats:
    """Return the closed state (u, q, s) nearest to the present one with values of parameters."""
    eqs, formulas, x = problem.settings.eqs, problem.own_laws.formulas, numbers.x[:-1].copy()
    if ropes(eqs.formed):  # which of them are taut follows from the state
        return state_values(nearest_state(problem, numbers, parameters, {}))
    scales = mechanism_scales(eqs, parameters, problem.sizes.scales.sizes)
    n_u, n = len(eqs.speed_names), len(eqs.speed_names) + len(eqs.coordinate_names)
    evaluator = constraint_evaluator(eqs, parameters, formulas, numbers.t, scales, signals=x[n:])
    near = dict(zip(eqs.coordinate_names, x[n_u:n].tolist(), strict=True))
    q, u = close(evaluator, {}, near, x[:n_u])
    return np.concatenate([u, q, x[n:]])


def nearest_state(
    problem: StepProblem, numbers: StepNumbers, parameters: Mapping[str, Value], inputs: Mapping[str, float]
) -> State:
    """Return the present state, closed, with accelerations and multipliers; `inputs` are those of steps."""
    eqs = problem.settings.eqs
    near = dict(zip(eqs.state_names, numbers.x.tolist(), strict=False))
    given = {**problem.own_laws.formulas, **inputs}
    return assemble(eqs, None, near, parameters, given, numbers.t, scales=problem.sizes.scales.sizes)
