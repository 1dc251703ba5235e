"""A mechanism as a Modelica model: what is declared, and the sequence that its equations are written from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.held_inputs import refuse_held
from symbody.analysis.state import State
from symbody.codegen.compile import compile
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.texts.modelica import Declaration, ModelDeclarations, model_text
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import switches
from symbody.errors import Problem, UsageError
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.model.model import Model, resolve_parameters
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import Baumgarte
from symbody.simulation.sweeps.case_by_case import reason_for_simulate

Floats = NDArray[np.float64]

# Zero at the start; what is shown of how far loops open.
_CLOSED: Final = ("constraints", "velocity_constraints")
_FACTOR: Final = re.compile(r"([A-Za-z]+)(?:\^(-?\d+))?")


def modelica_model(eqs: EquationSet, outputs: tuple[str, ...], parameters: Mapping[str, Value] | None) -> str:
    """Return the Modelica model of a mechanism.

    Parameters
    ----------
    outputs : tuple of str
        What becomes an output, besides the constraints.
    parameters : mapping, optional
        Values to put in; None leaves parameters that are not formulas of others as parameters.

    Raises
    ------
    UsageError
        If its motion changes its equations on the way, or constraints depend on others.
    AssemblyError, CompileError
        If there is no first state, or an output is unknown.
    """
    _check_motion(eqs)
    state = assemble(eqs, parameters=parameters or {})
    if state.has_dependent_constraints:
        raise UsageError(
            Problem("modelica.constraints", eqs.model.name,
                    "some constraints of this mechanism are redundant where its loops are closed",
                    "a Modelica tool would get a singular linear system",
                    "remove the redundant constraints (sb.redundancy(eqs) names them), or export an FMU "
                    "with save_fmu")
        )  # fmt: skip
    free = _plain_parameters(eqs) if parameters is None else ()
    stabilized = Baumgarte().applied(eqs) if eqs.multiplier_names else eqs
    closed = _closed_outputs(eqs)
    values = resolve_parameters(eqs.model, parameters or {})
    shown = tuple(name for name in dict.fromkeys(outputs) if name not in closed)
    sequence, _ = form_sequence(stabilized, ("xdot", *closed, *shown), parameters or {}, free)
    declared = ModelDeclarations(
        eqs.model.name,
        [Declaration(name, _unit(eqs, name), float(values[name])) for name in free],
        [Declaration(name, _unit(eqs, name)) for name in eqs.input_names],
        list(_states(eqs, state, is_assembled=not closed)),
        {name: _unit(eqs, name) for name in shown},
        closed if not eqs.quaternions else (),
        tuple(_remarks(eqs, free, is_closed=bool(closed))),
    )
    return model_text(fold_constants(written_out(sequence)), declared)


def _check_motion(eqs: EquationSet) -> None:
    refuse_held(eqs, "a Modelica model")
    reason = reason_for_simulate(eqs, InputLaws({}, {}, (), {}), None, None)
    if switches(eqs.formed):
        reason = "; ".join(filter(None, ("joints stick and slip, ropes slacken, or stops open", reason)))
    if reason:
        raise UsageError(
            Problem("modelica.motion", eqs.model.name,
                    f"this mechanism cannot be exported to Modelica: {reason}",
                    "the equations of a Modelica model cannot change",
                    "give friction a smooth law, replace ropes by springs, give limits a stiffness, or use "
                    "simulate")
        )  # fmt: skip


def _plain_parameters(eqs: EquationSet) -> tuple[str, ...]:
    """Return the parameters that are not formulas of others."""
    formulas = eqs.model.parameters
    return tuple(
        name for name in eqs.parameter_names
        if (formula := formulas[name]) is None or not set(formula.names) - {"pi"}
    )  # fmt: skip


def _closed_outputs(eqs: EquationSet) -> tuple[str, ...]:
    if not eqs.multiplier_names:
        return ()
    return _CLOSED if eqs.formed.holonomic else _CLOSED[1:]


def _states(eqs: EquationSet, state: State, *, is_assembled: bool) -> Iterator[Declaration]:
    """Yield the states with their assembled values, and whether these are chosen or follow."""
    names = (*eqs.speed_names, *eqs.coordinate_names, *eqs.signal_state_names)
    values = (*state.u.values(), *state.q.values(), *state.s.values())
    is_all = is_assembled or bool(eqs.quaternions)
    free = (True,) * len(names) if is_all else _free_states(eqs, state)
    for name, value, is_free in zip(names, values, free, strict=True):
        yield Declaration(name, _unit(eqs, name), float(value), is_free)


def _free_states(eqs: EquationSet, state: State) -> tuple[bool, ...]:
    """Return which states (u, q, s) are chosen where the others follow from the constraints."""
    q, u, s = (np.array(list(group.values())) for group in (state.q, state.u, state.s))
    function = compile(eqs, ["position_jacobian", "jacobian"], state.parameters, quick=True)
    values = function(state.t, q, u, np.zeros(len(eqs.input_names)), s=s)
    by_q, jacobian = (np.asarray(value) for value in values)
    chosen = {eqs.speed_names[k] for k in eqs.mobility.independent_speeds}
    speeds = _free_columns(jacobian, [name in chosen for name in eqs.speed_names])
    positions = _free_columns(
        by_q[: len(eqs.formed.holonomic)], [f"{name}_dot" in chosen for name in eqs.coordinate_names]
    )
    return (*speeds, *positions, *(True for _ in eqs.signal_state_names))


def _free_columns(matrix: Floats, is_preferred: list[bool]) -> list[bool]:
    """Return which variables of linear equations are chosen, those preferred as far as possible."""
    matrix = matrix / np.maximum(np.abs(matrix).max(axis=1, initial=0.0, keepdims=True), 1e-300)
    free = [True] * matrix.shape[1]
    for wanted in (False, True):
        columns = [k for k, preferred in enumerate(is_preferred) if preferred is wanted]
        while columns and matrix.shape[0]:
            sizes = np.abs(matrix[:, columns])
            row, place = divmod(int(sizes.argmax()), len(columns))
            if sizes[row, place] < 1e-9:
                break
            column = columns.pop(place)
            pivot = matrix[row] / matrix[row, column]
            matrix = np.delete(matrix - np.outer(matrix[:, column], pivot), row, axis=0)
            free[column] = False
    return free


def _unit(eqs: EquationSet, name: str) -> str:
    """Return the unit of a name as Modelica writes it, empty where it is not known.

    Products are points there, powers digits: N.m, kg.m2, rad/s.
    """
    unit = eqs.units.get(name, "") or ""
    above, *below = unit.replace("(", "").replace(")", "").split("/")
    parts = [_product(part) for part in (above, *below)]
    if not unit or len(below) > 1 or any(part is None for part in parts):
        return ""
    factors = [part or "" for part in parts]
    if len(factors) == 2 and "." in factors[1]:
        factors[1] = f"({factors[1]})"
    return "/".join(factors)


def _product(text: str) -> str | None:
    if text.strip() == "1":
        return "1"
    factors = [_FACTOR.fullmatch(word) for word in text.replace("*", " ").split()]
    if not factors or None in factors:
        return None
    return ".".join(f"{match[1]}{match[2] or ''}" for match in factors if match is not None)


def _remarks(eqs: EquationSet, free: tuple[str, ...], *, is_closed: bool) -> Iterator[str]:
    yield "Written by symbody from a model; SI units."
    if is_closed:
        yield "Constraints enter as accelerations with Baumgarte stabilization, which keeps loops closed."
        yield "Accelerations and multipliers follow from linear equations."
        yield "Initial values that are not fixed are solved for."
    if eqs.quaternions and is_closed:
        yield "There are quaternions: all initial values are fixed, consistent with the parameters below."
    model = eqs.model
    tables = [table.name for table in model.tables] if isinstance(model, Model) else []
    inputs = [name for name in tables if name in eqs.input_names]
    if inputs:
        yield f"The model has tables for the inputs {', '.join(inputs)}: connect a source of these values."
    left = [name for name in eqs.parameter_names if name not in free]
    if left and free:
        yield (
            f"Parameters that follow from others appear in the equations as parameters: {len(left)} of them."
        )
