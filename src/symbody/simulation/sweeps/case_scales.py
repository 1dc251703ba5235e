"""`CaseScales`: what `analysis.scales.Scales` is for one motion, for all cases of a sweep at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import (
    TIME_OF_SPAN,
    Scales,
    are_lengths,
    checked_scales,
    checked_sizes,
    geometry,
    number_formulas,
    own_equations,
    pose_share,
    state_tolerances,
)
from symbody.analysis.signal_sizes import signal_sizes
from symbody.analysis.signal_values import without_signals
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import formula_function
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import plain_value
from symbody.model.numbers import as_float
from symbody.simulation.sweeps.case_table import CaseTable

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CaseScales:
    """What counts as large in each case.

    Attributes
    ----------
    lengths, times : (cases,) arrays
        As in `Scales` [m, s].
    equations : mapping of name to (cases,) array
        As in `Scales`.
    signals : mapping of name to float
        As in `Scales`.
    driven : (cases, n_s) array
        Sizes of the states of signals by what goes into them.
    """

    eqs: EquationSet
    lengths: Floats
    times: Floats
    equations: Mapping[str, Floats]
    signals: Mapping[str, float]
    driven: Floats

    def of_case(self, k: int) -> Scales:
        """Return the scales of one case."""
        own = {name: float(sizes[k]) for name, sizes in self.equations.items()}
        return Scales(float(self.lengths[k]), float(self.times[k]), equations=own, signals=self.signals)

    def constraints(self) -> Floats:
        """Return what each constraint on positions is measured by, (cases, n_h)."""
        count = len(self.eqs.formed.holonomic)
        found = np.where(are_lengths(self.eqs), self.lengths[:, np.newaxis], 1.0)
        for k, name in enumerate(self.eqs.multiplier_names):
            if name in self.equations:
                found[:, k] = self.equations[name]
        return np.asarray(found[:, :count])

    def coordinates(self) -> Floats:
        """Return what counts as a large change of each coordinate, (cases, n_q)."""
        units = self.eqs.units
        is_length = np.array([units.get(name) == "m" for name in self.eqs.coordinate_names], dtype=np.bool_)
        return np.where(is_length, self.lengths[:, np.newaxis], 1.0)

    def metric(self) -> Floats:
        """Return the sizes of all states and of the constraints on positions, (cases, n_u + n_q + n_h)."""
        units = self.eqs.units
        is_length = np.array([units.get(name) == "m/s" for name in self.eqs.speed_names], dtype=np.bool_)
        displacements = np.where(is_length, self.lengths[:, np.newaxis], 1.0)
        return np.hstack([displacements, self.coordinates(), self.constraints()])

    def tolerances(self, states: Floats, atol: float | None) -> Floats:
        """Return the absolute tolerance of each speed and coordinate, (cases, n)."""
        if atol is not None:
            return np.full_like(states, atol)
        first = np.nan_to_num(states)
        return state_tolerances(self.eqs, self.lengths, self.times, first, self.driven, self.signals)


def case_scales(
    eqs: EquationSet,
    table: CaseTable,
    near: Mapping[str, Floats],
    span: tuple[float, float],
    given: Mapping[str, float] | None,
) -> CaseScales:
    """Return the scales of all cases.

    Parameters
    ----------
    near : mapping of name to (cases,) array
        Configurations, whose displacements count where the model has no other length.
    """
    signals, units = checked_sizes(eqs, given), eqs.units
    checked = checked_scales(without_signals(eqs, given or {}))
    lengths = _largest(case_values(eqs, table, geometry(eqs)), table.count)
    near_ones = {name: np.abs(values) for name, values in near.items() if units.get(name) == "m"}
    lengths = np.where(lengths > 0.0, lengths, _largest(near_ones, table.count))
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    if "length" in checked:
        lengths = np.full(table.count, checked["length"])
    pulls = case_values(eqs, table, number_formulas(eqs.model.gravity))
    gravity = np.sqrt(sum((pull**2 for pull in pulls.values()), np.zeros(table.count)))
    usual = TIME_OF_SPAN * abs(span[1] - span[0]) or 1.0
    falls = gravity > 0.0
    times = np.where(falls, np.sqrt(lengths / np.where(falls, gravity, 1.0)), usual)
    if "time" in checked:
        times = np.full(table.count, checked["time"])
    driven = _sizes_of_signals(eqs, table, lengths, times, checked)
    return CaseScales(eqs, lengths, times, _equations(eqs, table, lengths), signals, driven)


def _sizes_of_signals(
    eqs: EquationSet, table: CaseTable, lengths: Floats, times: Floats, given: Mapping[str, float]
) -> Floats:
    """Return the sizes of the states of signals by what goes into them, (cases, n_s)."""
    if not eqs.signal_state_names:
        return np.zeros((table.count, 0))
    bodies = eqs.model.bodies
    masses = _largest(case_values(eqs, table, number_formulas([body.mass for body in bodies])), table.count)
    inertias = number_formulas([moment for body in bodies for moment in body.inertia])
    moments = _largest(case_values(eqs, table, inertias), table.count)
    masses = np.where(masses > 0.0, masses, moments / lengths**2)
    masses = np.where(masses > 0.0, masses, 1.0)
    if "mass" in given:
        masses = np.full(table.count, given["mass"])
    fixed = {
        name: Formula.from_value(plain_value(value), where=name)
        for name, value in table.fixed_parameters.items()
    }
    varied = {name: table.parameters[:, k] for k, name in enumerate(table.parameter_names)}
    return signal_sizes(eqs, {**fixed, **varied}, lengths, times, masses)


def case_values(eqs: EquationSet, table: CaseTable, formulas: Mapping[str, Value]) -> dict[str, Floats]:
    """Return the values (cases,) of each formula in parameters and t, at t = 0."""
    read = {name: Formula.from_value(plain_value(value), where=name) for name, value in formulas.items()}
    numbers = {name: formula.constant() for name, formula in read.items()}
    known = {name: as_float(number) for name, number in numbers.items() if number is not None}
    others = {name: formula for name, formula in read.items() if name not in known}
    columns: dict[str, Floats] = {}
    if others:
        function = formula_function(eqs, others, table.fixed_parameters, table.parameter_names)
        values = function(0.0, (), (), (), table.parameters)
        columns = dict(zip(others, values if len(others) > 1 else (values,), strict=True))
    return {
        name: np.broadcast_to(known[name] if name in known else columns[name], (table.count,))
        for name in formulas
    }


def _largest(columns: Mapping[str, Floats], count: int) -> Floats:
    """Return the largest absolute value in each case, 0 if there is none."""
    return np.asarray(np.max(np.abs([np.zeros(count), *columns.values()]), axis=0))


def _equations(eqs: EquationSet, table: CaseTable, lengths: Floats) -> dict[str, Floats]:
    """Return what `analysis.scales` measures equations of users by, in each case."""
    rows_of_users, units = own_equations(eqs), eqs.units
    if not rows_of_users:
        return {}
    inputs: dict[str, Value] = dict.fromkeys(eqs.input_names, 0)
    values = table.fixed_parameters, table.parameter_names, inputs
    function = bound_function(eqs, "jacobian", *values, quick=True)
    columns = lengths[:, np.newaxis]
    q = pose_share(eqs) * np.where([units.get(name) == "m" for name in eqs.coordinate_names], columns, 1.0)
    moves = np.where([units.get(name) == "m/s" for name in eqs.speed_names], columns, 1.0)
    rows = function(0.0, q, np.zeros_like(moves), (), table.parameters) * moves[:, np.newaxis]
    sizes = np.abs(rows).max(axis=2, initial=0.0)
    usable = np.isfinite(sizes) & (sizes > 0.0)
    scales = np.where(usable, sizes, np.where(are_lengths(eqs), columns, 1.0))
    return {eqs.multiplier_names[k]: scales[:, k] for k in rows_of_users}
