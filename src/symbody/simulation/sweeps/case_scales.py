"""`scales_of_cases`: the `Scales` of all cases of a sweep, as arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import (
    TIME_OF_SPAN,
    Scales,
    checked_sizes,
    geometry,
    number_formulas,
    own_equations,
    pose_share,
)
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import formula_function
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import plain_value
from symbody.model.numbers import as_float
from symbody.simulation.sweeps.case_table import CaseTable

Floats = NDArray[np.float64]


def scales_of_cases(
    eqs: EquationSet,
    table: CaseTable,
    near: Mapping[str, Floats],
    span: tuple[float, float],
    given: Mapping[str, float],
) -> Scales:
    """Return the scales of all cases, as `analysis.scales.mechanism_scales` those of one.

    Parameters
    ----------
    near : mapping of name to (cases,) array
        Configurations, whose displacements count where the model has no other length.
    given : mapping of name to float
        Scales, and sizes of states of signals, that the caller chose.
    """

    def largest(formulas: Mapping[str, Value]) -> Floats:
        return _largest(case_values(eqs, table, formulas), table.count)

    def chosen(name: str, found: Floats) -> Floats:
        return np.full(table.count, given[name]) if name in given else found

    bodies, units = eqs.model.bodies, eqs.units
    lengths = largest(geometry(eqs))
    displacements = {name: values for name, values in near.items() if units.get(name) == "m"}
    lengths = np.where(lengths > 0.0, lengths, _largest(displacements, table.count))
    lengths = chosen("length", np.where(lengths > 0.0, lengths, 1.0))
    pulls = case_values(eqs, table, number_formulas(eqs.model.gravity))
    gravity = np.sqrt(sum((pull**2 for pull in pulls.values()), np.zeros(table.count)))
    falls, usual = gravity > 0.0, TIME_OF_SPAN * abs(span[1] - span[0]) or 1.0
    times = chosen("time", np.where(falls, np.sqrt(lengths / np.where(falls, gravity, 1.0)), usual))
    masses = largest(number_formulas([body.mass for body in bodies]))
    moments = largest(number_formulas([moment for body in bodies for moment in body.inertia]))
    masses = np.where(masses > 0.0, masses, moments / lengths**2)
    masses = chosen("mass", np.where(masses > 0.0, masses, 1.0))
    numbers: dict[str, Value] = {}
    if eqs.signal_state_names:
        numbers = case_values(eqs, table, {name: name for name in eqs.parameter_names})
    signals = checked_sizes(eqs, given)
    scales = Scales(lengths, times, masses, signals=signals, numbers=numbers)  # type: ignore[arg-type]
    return _with_equations(eqs, table, scales)


def _with_equations(eqs: EquationSet, table: CaseTable, scales: Scales) -> Scales:
    """Return scales with the sizes of constraints that have units of their own."""
    written = own_equations(eqs)
    if not written:
        return scales
    silent: dict[str, Value] = dict.fromkeys(eqs.input_names, 0)
    function = bound_function(
        eqs, "jacobian", table.fixed_parameters, table.parameter_names, silent, quick=True
    )
    q, moves = pose_share(eqs) * scales.coordinates(eqs), scales.displacements(eqs)
    rows = function(0.0, q, np.zeros_like(moves), (), table.parameters) * moves[:, np.newaxis]
    sizes, usual = np.abs(rows).max(axis=2, initial=0.0), scales.constraints(eqs)
    sizes = np.where((sizes > 0.0) & (sizes < math.inf), sizes, usual)
    return replace(scales, equations={eqs.multiplier_names[k]: sizes[:, k] for k in written})  # type: ignore[arg-type]


def case_values(eqs: EquationSet, table: CaseTable, formulas: Mapping[str, Value]) -> dict[str, Floats]:
    """Return the values (cases,) of each formula in parameters and t, at t = 0."""
    read = {name: Formula.from_value(plain_value(value), where=name) for name, value in formulas.items()}
    numbers = {name: formula.constant() for name, formula in read.items()}
    values = {name: np.full(table.count, as_float(x)) for name, x in numbers.items() if x is not None}
    unknown = {name: formula for name, formula in read.items() if name not in values}
    if unknown:
        function = formula_function(eqs, unknown, table.fixed_parameters, table.parameter_names)
        columns = function(0.0, (), (), (), table.parameters)
        for name, column in zip(unknown, columns if len(unknown) > 1 else (columns,), strict=True):
            values[name] = np.broadcast_to(column, (table.count,))
    return {name: values[name] for name in formulas}


def _largest(columns: Mapping[str, Floats], count: int) -> Floats:
    """Return the largest absolute value in each case, 0 if there is none."""
    return np.asarray(np.max(np.abs([np.zeros(count), *columns.values()]), axis=0))
