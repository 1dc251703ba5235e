"""`scales_of_cases`: the `Scales` of all cases of a sweep, as arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

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
    signals, bodies, units = checked_sizes(eqs, given), eqs.model.bodies, eqs.units
    chosen = {name: np.full(table.count, size) for name, size in given.items() if name not in signals}
    groups: list[dict[str, Value]] = [
        geometry(eqs), number_formulas(eqs.model.gravity), number_formulas([body.mass for body in bodies]),
        number_formulas([moment for body in bodies for moment in body.inertia]),
    ]  # fmt: skip
    names = eqs.parameter_names if eqs.signal_state_names else ()
    groups.append({name: name for name in names})
    together = {f"{k} {name}": formula for k, group in enumerate(groups) for name, formula in group.items()}
    columns = iter(case_values(eqs, table, together).values())
    geometric, pulls, masses, moments, numbers = ([next(columns) for _ in group] for group in groups)
    lengths = _largest(geometric, table.count)
    displacements = _largest([x for name, x in near.items() if units.get(name) == "m"], table.count)
    lengths = np.where(lengths > 0.0, lengths, displacements)
    lengths = chosen.get("length", np.where(lengths > 0.0, lengths, 1.0))
    gravity = np.sqrt(sum((pull**2 for pull in pulls), np.zeros(table.count)))
    falls, usual = gravity > 0.0, TIME_OF_SPAN * abs(span[1] - span[0]) or 1.0
    times = np.where(falls, np.sqrt(lengths / np.where(falls, gravity, 1.0)), usual)
    largest = _largest(masses, table.count)
    largest = np.where(largest > 0.0, largest, _largest(moments, table.count) / lengths**2)
    sizes: Any = lengths, chosen.get("time", times), chosen.get("mass", np.where(largest > 0.0, largest, 1.0))
    values: Any = dict(zip(names, numbers, strict=True))
    scales = Scales(sizes[0], sizes[1], sizes[2], signals=signals, numbers=values)
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
    equations: Any = {eqs.multiplier_names[k]: sizes[:, k] for k in written}
    return replace(scales, equations=equations)


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


def _largest(columns: Sequence[Floats], count: int) -> Floats:
    """Return the largest absolute value in each case, 0 if there is none."""
    return np.asarray(np.max(np.abs([np.zeros(count), *columns]), axis=0))
