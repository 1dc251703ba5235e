"""First states of all cases, and the `Scales` of all of them as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.configurations.kept_values import held_initial_values
from symbody.analysis.named_values import positions_and_rates, refuse_unknown
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
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.formation.quantities import Quantities
from symbody.codegen.formation.values import formula_function
from symbody.equations.closing_equations import closing_equations
from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError, SymbodyError
from symbody.expr.language.formula import Formula
from symbody.model.checks.physics import check_element
from symbody.model.declarations.arguments import plain_value
from symbody.model.model import Model, value_problems
from symbody.model.numbers import as_float
from symbody.model.numeric_checks import Demand, DemandList, Domain
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.sweeps.case_table import CaseTable

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FirstStates:
    """Where the cases start.

    Attributes
    ----------
    states : (cases, n) array
        x = (u, q, s), not a number where there is no such state.
    scales : Scales
        What counts as large, in arrays (cases,).
    notes : mapping of int to str
        Why a case has no first state.
    """

    states: Floats
    scales: Scales
    notes: Mapping[int, str]


def first_states(
    eqs: EquationSet,
    table: CaseTable,
    guess: Mapping[str, Value],
    inputs: Mapping[str, Value],
    span: tuple[float, float],
    scales: Mapping[str, float],
) -> FirstStates:
    """Return the first states of all cases, by `assemble` where something has to be solved for.

    Raises AssemblyError listing every unknown name; CompileError if parameters have no value or names are
    unknown.

    Parameters
    ----------
    scales : mapping of name to float
        Those that the caller chose.
    """
    guesses = check_names(eqs, table, guess)
    states = _states_of_tree(eqs, table, guess, guesses)
    notes = {} if states is None else impossible_cases(eqs, table)
    if states is None:
        states = np.full((table.count, len(eqs.state_names)), np.nan)
        for k in range(table.count):
            parameters, fixed = table.values(k)
            try:
                first = assemble(
                    eqs, fixed, guess, parameters=parameters, inputs=inputs, t=span[0], scales=scales
                )
            except SymbodyError as error:
                notes[k] = str(error)
            else:
                states[k] = [*first.u.values(), *first.q.values(), *first.s.values()]
    states[list(notes)] = np.nan
    places = enumerate(eqs.coordinate_names, len(eqs.speed_names))
    near = {name: np.nan_to_num(states[:, k]) for k, name in places}
    return FirstStates(states, scales_of_cases(eqs, table, near, span, scales), notes)


def _states_of_tree(
    eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value], guesses: Mapping[str, Value]
) -> Floats | None:
    """Return first states where nothing has to be solved for, otherwise None."""
    names = eqs.state_names
    held = held_initial_values(eqs, (*table.fixed_initial, *table.initial_names), guess)
    fixed = {**held, **table.fixed_initial}
    is_tree = not (eqs.multiplier_names or eqs.quaternions) and closing_equations(eqs) is eqs
    if not is_tree or not {*guesses, *fixed, *table.initial_names} <= {*names}:
        return None
    values = case_values(eqs, table, {**guesses, **fixed})
    values |= {name: table.initial[:, k] for k, name in enumerate(table.initial_names)}
    nothing = np.zeros(table.count)
    return np.stack([values.get(name, nothing) for name in names], axis=1)


def impossible_cases(eqs: EquationSet, table: CaseTable) -> dict[int, str]:
    """Return the cases in which values are none that elements can have, and why."""
    model = eqs.model
    if not isinstance(model, Model) or not table.parameter_names:
        return {}
    formulas: dict[str, Formula] = {}
    for k, body in enumerate(model.bodies):
        for name, own in (("inertia", body.inertia), ("products", body.products)):
            formulas |= {f"{name} {k} {i}": formula for i, formula in enumerate(own)}
    demands = _demands(model)
    formulas |= {f"demand {k}": demand.formula for k, demand in enumerate(demands)}
    values = case_values(eqs, table, formulas)
    doubtful = np.zeros(table.count, dtype=np.bool_)
    for k, demand in enumerate(demands):
        doubtful |= _are_outside(demand.domain, values[f"demand {k}"])
    for k in range(len(model.bodies)):
        three = [[values[f"{name} {k} {i}"] for i in range(3)] for name in ("inertia", "products")]
        doubtful |= _is_doubtful(np.array(three[0]), np.array(three[1]))
    notes = {}
    for k in np.flatnonzero(doubtful).tolist():
        problems = value_problems(model, table.values(k)[0])
        if problems:
            notes[k] = str(CompileError(*problems))
    return notes


def _demands(model: Model) -> list[Demand]:
    """Return what elements demand of formulas of parameters."""
    known, found = {"pi", *model.parameters}, DemandList()
    for element in model.elements:
        check_element(found, element, "")
    return [one for one in found.demands if one.formula.names and known.issuperset(one.formula.names)]


def _are_outside(domain: Domain, values: Floats) -> NDArray[np.bool_]:
    """Return which of some numbers are none of a domain."""
    inside = np.isfinite(values) & (values >= domain.least) & (values <= domain.most)
    if domain.above:
        inside &= values != domain.least
    return ~(inside & (values != 0.0) if domain.nonzero else inside)


def _is_doubtful(moments: Floats, products: Floats) -> NDArray[np.bool_]:
    """Return whether tensors, (3, cases) each, may be impossible: a moment is negative, or too large."""
    x, y, z = products
    rows = [[moments[0], x, y], [x, moments[1], z], [y, z, moments[2]]]
    tensors = np.moveaxis(np.array(rows), 2, 0)
    principal = np.linalg.eigvalsh(np.where(np.isfinite(tensors), tensors, 0.0))
    return np.asarray((principal[:, 0] < 0.0) | (principal[:, 0] + principal[:, 1] < principal[:, 2]))


def check_names(eqs: EquationSet, table: CaseTable, guess: Mapping[str, Value]) -> dict[str, Value]:
    """Return what is known of initial values, formulas by name.

    Raises AssemblyError, CompileError listing unknown names, or parameters without value.
    """
    parameter_set(eqs, table.fixed_parameters, table.parameter_names)
    held = held_later(eqs)  # they have values before their first samples
    names = (*table.initial_names, *table.fixed_initial, *guess)
    refuse_unknown(eqs, [name for name in names if name not in held])
    legal = positions_and_rates(eqs)
    of_model: dict[str, Value] = {**eqs.model.initial}
    of_model |= {signal.name: signal.initial for signal in eqs.model.signals if signal.is_state}
    ordered = {**guess, **{name: value for name, value in of_model.items() if name not in guess}}
    return {name: value for name, value in ordered.items() if name in legal}


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
