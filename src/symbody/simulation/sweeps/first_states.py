"""First states of all cases, from functions compiled once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import consistent_start
from symbody.analysis.closure import Closure, are_lengths, offsets
from symbody.analysis.named_values import positions_and_rates, refuse_unknown
from symbody.codegen.compile import Value, form_sequence, form_values
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import SymbodyError
from symbody.simulation.sweeps.case_table import CaseTable

Floats = NDArray[np.float64]

_CLOSING = ("constraints", "position_jacobian", "jacobian", "velocity_constraints", "alignment")


@dataclass(frozen=True, slots=True, eq=False)
class FirstStates:
    """Where the cases start.

    Attributes
    ----------
    states : (cases, n) array
        x = (u, q), not a number where there is no such state.
    sizes : (cases,) array
        How large the mechanism is in each case [m], see `analysis.closure.mechanism_size`.
    notes : mapping of int to str
        Why a case has no first state.
    """

    states: Floats
    sizes: Floats
    notes: Mapping[int, str]


def first_states(
    eqs: EquationSet,
    table: CaseTable,
    guess: Mapping[str, Value],
    inputs: Mapping[str, Value],
    t: float,
) -> FirstStates:
    """Return the first states of all cases.

    Raises
    ------
    AssemblyError
        Listing every unknown name.
    CompileError
        If parameters have no value or names are unknown.
    """
    known_formulas = check_names(eqs, table, guess)
    values = _Values(eqs, table)
    known, fixed = values.of(known_formulas), values.of(table.fixed_initial)
    fixed |= {name: table.initial[:, k] for k, name in enumerate(table.initial_names)}
    offset = values.of(offsets(eqs))
    sizes = np.max(np.abs(list(offset.values()) or [np.zeros(table.count)]), axis=0)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    states = _of_tree(eqs, table.count, known, fixed)
    if states is not None:
        return FirstStates(states, sizes, {})
    return _Assembler(eqs, table, inputs, t).all(known, fixed, sizes)


def projection_sizes(eqs: EquationSet, sizes: Floats) -> tuple[Floats, Floats]:
    """Return what closes each constraint, and what counts as a large coordinate, in each case."""
    units = eqs.units
    is_length = np.array([units.get(name) == "m" for name in eqs.coordinate_names], dtype=np.bool_)
    rows = np.array(are_lengths(eqs)[: len(eqs.formed.holonomic)], dtype=np.bool_)
    columns = sizes[:, np.newaxis]
    return np.where(rows, columns, 1.0), np.where(is_length, columns, 1.0)


class _Values:
    """Values of formulas in parameters, in all cases."""

    def __init__(self, eqs: EquationSet, table: CaseTable) -> None:
        self._eqs = eqs
        self._table = table

    def of(self, formulas: Mapping[str, Value]) -> dict[str, Floats]:
        """Return the values (cases,) of each formula."""
        if not formulas:
            return {}
        table = self._table
        sequence = form_values(self._eqs, formulas, table.fixed_parameters, table.parameter_names)
        found = CompiledFunction(*sequence, quick=True)(0.0, (), (), (), table.parameters)
        columns = found if len(formulas) > 1 else (found,)
        return {
            name: np.broadcast_to(column, (table.count,))
            for name, column in zip(formulas, columns, strict=True)
        }


def check_names(eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value]) -> dict[str, Value]:
    """Return what is known of initial values, formulas by name.

    Raises
    ------
    AssemblyError, CompileError
        Listing unknown names, or parameters without value.
    """
    form_values(eqs, {}, table.fixed_parameters, table.parameter_names)
    refuse_unknown(eqs, (*table.initial_names, *table.fixed_initial, *guess))
    legal = positions_and_rates(eqs)
    ordered = {**guess, **{name: value for name, value in eqs.model.initial.items() if name not in guess}}
    return {name: value for name, value in ordered.items() if name in legal}


def _of_tree(
    eqs: EquationSet, count: int, known: Mapping[str, Floats], fixed: Mapping[str, Floats]
) -> Floats | None:
    """Return first states where nothing has to be solved for, otherwise None."""
    names = eqs.state_names
    if eqs.multiplier_names or eqs.quaternions:
        return None
    if not {*known, *fixed} <= {*names}:
        return None
    states = np.zeros((count, len(names)))
    for k, name in enumerate(names):
        states[:, k] = fixed.get(name, known.get(name, 0.0))
    return states


class _Assembler:
    """Closes the loops of one case after the other, with functions that take what varies as arguments."""

    def __init__(self, eqs: EquationSet, table: CaseTable, inputs: Mapping[str, Value], t: float) -> None:
        self._eqs = eqs
        self._table = table
        self._inputs = inputs
        self._t = t
        units = eqs.units
        self._angles = frozenset(name for name, unit in units.items() if unit == "rad")
        self._slides = np.array([units.get(name) == "m/s" for name in eqs.speed_names])
        given = dict.fromkeys(eqs.input_names, 0) | dict(inputs)
        sequence = form_sequence(eqs, _CLOSING, table.fixed_parameters, table.parameter_names, given)
        self._function = CompiledFunction(*sequence, quick=True)

    def all(self, known: Mapping[str, Floats], fixed: Mapping[str, Floats], sizes: Floats) -> FirstStates:
        """Return the first states of all cases."""
        table, notes = self._table, {}
        states = np.full((table.count, len(self._eqs.state_names)), np.nan)
        scales, coordinates = projection_sizes(self._eqs, sizes)
        for k in range(table.count):
            task = Closure(
                self._eqs,
                table.values(k)[0],
                self._inputs,
                self._t,
                coordinates[k],
                np.where(self._slides, sizes[k], 1.0),
                scales[k],
                self._function.bind(table.parameters[k]),
                self._angles,
            )
            try:
                q, u = consistent_start(task, _row(fixed, k), _row(known, k))
                states[k] = np.concatenate([u, q])
            except SymbodyError as error:
                notes[k] = str(error)
        return FirstStates(states, sizes, notes)


def _row(columns: Mapping[str, Floats], k: int) -> dict[str, float]:
    return {name: float(column[k]) for name, column in columns.items()}
