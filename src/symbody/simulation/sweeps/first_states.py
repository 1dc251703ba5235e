"""First states of all cases, from functions compiled once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import close
from symbody.analysis.configurations.kept_values import (
    do_values_fit,
    held_initial_values,
    kept_initial_values,
    surplus_initial_values,
)
from symbody.analysis.configurations.plain_assembly import is_plain, plain_assembly, plain_function
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_function
from symbody.analysis.named_values import positions_and_rates, refuse_unknown
from symbody.analysis.scales import Scales
from symbody.analysis.signal_values import without_signals
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.function import CompiledFunction
from symbody.equations.closing_equations import closing_equations
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, CompileError, SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.model import Model, value_problems
from symbody.model.signals.block import SignalBlock
from symbody.model.signals.domains import Demand
from symbody.model.signals.signal import Signal
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.sweeps.case_scales import CaseScales, case_scales, case_values
from symbody.simulation.sweeps.case_table import CaseTable
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FirstStates:
    """Where the cases start.

    Attributes
    ----------
    states : (cases, n) array
        x = (u, q), not a number where there is no such state.
    scales : CaseScales
        What counts as large in each case.
    notes : mapping of int to str
        Why a case has no first state.
    """

    states: Floats
    scales: CaseScales
    notes: Mapping[int, str]


def first_states(
    eqs: EquationSet,
    table: CaseTable,
    guess: Mapping[str, Value],
    inputs: Mapping[str, Value],
    span: tuple[float, float],
    given: Mapping[str, float] | None = None,
) -> FirstStates:
    """Return the first states of all cases.

    Parameters
    ----------
    given : mapping of "length", "time" to float
        Scales that were given.

    Raises
    ------
    AssemblyError
        Listing every unknown name.
    CompileError
        If parameters have no value or names are unknown.
    """
    whole = closing_equations(eqs)
    if whole is not eqs:
        found = first_states(whole, table, guess, inputs, span, given)
        places = [whole.state_names.index(name) for name in eqs.state_names]
        return _first_states(eqs, table, found.states[:, places], found.notes, span, given)
    known_formulas = check_names(eqs, table, guess)
    guessed, fixed = case_values(eqs, table, known_formulas), case_values(eqs, table, table.fixed_initial)
    held = held_initial_values(eqs, (*fixed, *table.initial_names), guess)
    fixed |= case_values(eqs, table, held)
    fixed |= {name: table.initial[:, k] for k, name in enumerate(table.initial_names)}
    notes = impossible_cases(eqs, table)
    states = _of_tree(eqs, table.count, guessed, fixed)
    if states is None:
        scales = case_scales(eqs, table, {**guessed, **fixed}, span, given)
        kept = tuple(kept_initial_values(eqs, fixed, guess)), tuple(surplus_initial_values(eqs, fixed, guess))
        states, notes = _Assembler(eqs, table, inputs, span[0], *kept).all(guessed, fixed, scales, notes)
    states[list(notes)] = np.nan
    return _first_states(eqs, table, states, notes, span, given)


def _first_states(
    eqs: EquationSet,
    table: CaseTable,
    states: Floats,
    notes: Mapping[int, str],
    span: tuple[float, float],
    given: Mapping[str, float] | None,
) -> FirstStates:
    """Return first states with the scales of their cases."""
    places = enumerate(eqs.coordinate_names, len(eqs.speed_names))
    near = {name: np.nan_to_num(states[:, k]) for k, name in places}
    return FirstStates(states, case_scales(eqs, table, near, span, given), notes)


def impossible_cases(eqs: EquationSet, table: CaseTable) -> dict[int, str]:
    """Return the cases in which masses, inertias or arguments of blocks are none, and why."""
    model = eqs.model
    if not isinstance(model, Model) or not table.parameter_names:
        return {}
    formulas: dict[str, Formula] = {}
    for k, body in enumerate(model.bodies):
        for name, own in (("mass", (body.mass,)), ("inertia", body.inertia), ("products", body.products)):
            formulas |= {f"{name} {k} {i}": formula for i, formula in enumerate(own)}
    armatures = [formula for joint in model.joints for formula in joint.armature.values()]
    formulas |= {f"armature {k}": formula for k, formula in enumerate(armatures)}
    demands = _block_demands(model)
    formulas |= {f"demand {k}": formula for k, (_, formula, _) in enumerate(demands)}
    values = case_values(eqs, table, formulas)
    doubtful = np.zeros(table.count, dtype=np.bool_)
    for k, demand in enumerate(demands):
        column = np.broadcast_to(values[f"demand {k}"], doubtful.shape)
        doubtful |= np.array([not demand.domain.has(value) for value in column.tolist()])
    for name, column in values.items():
        if name.startswith(("mass", "armature")):
            doubtful |= column < 0.0
    for k in range(len(model.bodies)):
        three = [[values[f"{name} {k} {i}"] for i in range(3)] for name in ("inertia", "products")]
        doubtful |= _is_doubtful(np.array(three[0]), np.array(three[1]))
    notes = {}
    for k in np.flatnonzero(doubtful).tolist():
        problems = value_problems(model, table.values(k)[0])
        if problems:
            notes[k] = str(CompileError(*problems))
    return notes


def _block_demands(model: Model) -> list[Demand]:
    """Return what signals and blocks demand of formulas of parameters."""
    known = {"pi", *model.parameters}
    blocks = [element for element in model.elements if isinstance(element, Signal | SignalBlock)]
    every = [demand for block in blocks for demand in block.demands()]
    return [one for one in every if one.formula.names and known.issuperset(one.formula.names)]


def _is_doubtful(moments: Floats, products: Floats) -> NDArray[np.bool_]:
    """Return whether tensors, (3, cases) each, may be impossible: a moment is negative, or too large."""
    x, y, z = products
    rows = [[moments[0], x, y], [x, moments[1], z], [y, z, moments[2]]]
    tensors = np.moveaxis(np.array(rows), 2, 0)
    principal = np.linalg.eigvalsh(np.where(np.isfinite(tensors), tensors, 0.0))
    return np.asarray((principal[:, 0] < 0.0) | (principal[:, 0] + principal[:, 1] < principal[:, 2]))


def check_names(eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value]) -> dict[str, Value]:
    """Return what is known of initial values, formulas by name.

    Raises
    ------
    AssemblyError, CompileError
        Listing unknown names, or parameters without value.
    """
    parameter_set(eqs, table.fixed_parameters, table.parameter_names)
    held = held_later(eqs)  # they have values before their first samples
    given = (*table.initial_names, *table.fixed_initial, *guess)
    refuse_unknown(eqs, [name for name in given if name not in held])
    legal = positions_and_rates(eqs)
    of_model: dict[str, Value] = {**eqs.model.initial}
    of_model |= {signal.name: signal.initial for signal in eqs.model.signals if signal.is_state}
    ordered = {**guess, **{name: value for name, value in of_model.items() if name not in guess}}
    return {name: value for name, value in ordered.items() if name in legal}


def _of_tree(
    eqs: EquationSet, count: int, guessed: Mapping[str, Floats], fixed: Mapping[str, Floats]
) -> Floats | None:
    """Return first states where nothing has to be solved for, otherwise None."""
    names = eqs.state_names
    if eqs.multiplier_names or eqs.quaternions:
        return None
    if not {*guessed, *fixed} <= {*names}:
        return None
    states = np.zeros((count, len(names)))
    for k, name in enumerate(names):
        states[:, k] = fixed.get(name, guessed.get(name, 0.0))
    return states


class _Assembler:
    """Closes the loops of one case after the other, with functions that take what varies as arguments."""

    def __init__(
        self,
        eqs: EquationSet,
        table: CaseTable,
        inputs: Mapping[str, Value],
        t: float,
        kept: Sequence[str],
        surplus: Sequence[str],
    ) -> None:
        self._eqs = eqs
        self._kept = kept
        self._surplus = surplus
        self._table = table
        self._inputs = inputs
        self._t = t
        self._angles = frozenset(name for name, unit in eqs.units.items() if unit == "rad")
        self._functions: SingleFlight[None, CompiledFunction] = SingleFlight()
        values = table.fixed_parameters, table.parameter_names, inputs
        self._plain = plain_function(eqs, *values)
        self._assembly = plain_assembly(eqs, self._plain)

    def all(
        self,
        guessed: Mapping[str, Floats],
        fixed: Mapping[str, Floats],
        scales: CaseScales,
        impossible: Mapping[int, str],
    ) -> tuple[Floats, dict[int, str]]:
        """Return the first states of all cases but those that are impossible, and why some have none."""
        table, eqs, notes = self._table, self._eqs, dict(impossible)
        states = np.full((table.count, len(eqs.state_names)), np.nan)
        for k in range(table.count):
            if k in impossible:
                continue
            try:
                states[k] = self._state(k, _row(fixed, k), _row(guessed, k), scales.of_case(k))
            except SymbodyError as error:
                notes[k] = str(error)
        return states, notes

    def _state(self, k: int, fixed: Mapping[str, float], near: Mapping[str, float], sizes: Scales) -> Floats:
        """Return a first state, with positions of the model kept where `assemble` keeps them."""
        kept = {name: near[name] for name in self._kept}
        surplus = {name: near[name] for name in self._surplus}
        if surplus and do_values_fit(self._closure(k, sizes), surplus):
            kept = surplus
        if kept:
            with suppress(AssemblyError):
                return self._closed_state(k, {**fixed, **kept}, near, sizes)
        return self._closed_state(k, fixed, near, sizes)

    def _closed_state(
        self, k: int, fixed: Mapping[str, float], near: Mapping[str, float], sizes: Scales
    ) -> Floats:
        eqs, table = self._eqs, self._table
        if is_plain(eqs, fixed, near) and not self._plain.signature.r:
            constants = self._plain.constants(table.parameters[k])
            plain = self._assembly.solve(constants, sizes, fixed, near, self._t)
            if plain is not None:
                return np.concatenate([plain.u, plain.q])
        q, u = close(self._closure(k, sizes), without_signals(eqs, fixed), without_signals(eqs, near))
        signals = [fixed.get(name, near[name]) for name in eqs.signal_state_names]
        return np.array([*u, *q, *signals])

    def _closure(self, k: int, sizes: Scales) -> ConstraintEvaluator:
        """Return the constraints of a case."""
        eqs, table = self._eqs, self._table
        return ConstraintEvaluator(
            eqs,
            table.values(k)[0],
            self._inputs,
            self._t,
            sizes.coordinates(eqs),
            sizes.displacements(eqs),
            sizes.constraints(eqs)[: len(eqs.formed.holonomic)],
            self._functions.get(None, self._compile).bind(table.parameters[k]),
            self._angles,
            sizes,
        )

    def _compile(self) -> CompiledFunction:
        table = self._table
        return constraint_function(self._eqs, table.fixed_parameters, self._inputs, table.parameter_names)


def _row(columns: Mapping[str, Floats], k: int) -> dict[str, float]:
    return {name: float(column[k]) for name, column in columns.items()}
