"""`scales_of_cases`: the `Scales` of all cases of a sweep, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import (
    Scales,
    checked_sizes,
    equation_sizes,
    geometry,
    largest_magnitude,
    number_formulas,
    own_equations,
    pose_share,
    scales_of_quantities,
)
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.quantities import Quantities
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
    signals, bodies, units = checked_sizes(eqs, given), eqs.model.bodies, eqs.units
    chosen: Any = {name: np.full(table.count, size) for name, size in given.items() if name not in signals}
    groups: list[dict[str, Value]] = [
        geometry(eqs), number_formulas(eqs.model.gravity), number_formulas([body.mass for body in bodies]),
        number_formulas([moment for body in bodies for moment in body.inertia]),
    ]  # fmt: skip
    names = eqs.parameter_names if eqs.signal_state_names else ()
    groups.append({name: name for name in names})
    together = {f"{k} {name}": formula for k, group in enumerate(groups) for name, formula in group.items()}
    columns = iter(case_values(eqs, table, together).values())
    quantities: list[Any] = [[next(columns) for _ in group] for group in groups]
    numbers = quantities.pop()
    nothing = np.zeros(table.count)
    length, moved = nothing, [x for name, x in near.items() if units.get(name) == "m"]
    for sizes in (moved, quantities[0]):  # displacements count where there is no other length
        largest = nothing + largest_magnitude(sizes)
        length = np.where(largest > 0.0, largest, length)
    made: Any = Quantities(*quantities), chosen.get("length", length), chosen, signals
    values: Any = dict(zip(names, numbers, strict=True))
    scales = replace(scales_of_quantities(*made).fit_span(*span), numbers=values)
    if not own_equations(eqs):
        return scales
    silent: dict[str, Value] = dict.fromkeys(eqs.input_names, 0)
    function = bound_function(
        eqs, "jacobian", table.fixed_parameters, table.parameter_names, silent, quick=True
    )
    q, still = pose_share(eqs) * scales.coordinates(eqs), np.zeros((table.count, len(eqs.speed_names)))
    return replace(
        scales, equations=equation_sizes(eqs, function(0.0, q, still, (), table.parameters), scales)
    )


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
