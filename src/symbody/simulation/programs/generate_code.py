"""`generate_code`: equations as source text of any language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

import numpy as np

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.held_inputs import refuse_held
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.signature import source_text
from symbody.codegen.texts.modelica import Declaration, ModelDeclarations, model_text
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import switches
from symbody.errors import Problem, UsageError
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.program import written_out
from symbody.model.model import Model, resolve_parameters
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.methods.constraints import Baumgarte
from symbody.simulation.programs.free_states import free_states
from symbody.simulation.sweeps.sweep_job import reason_for_simulate


@named_after(3)
@checked_arguments
def generate_code(
    eqs: EquationSet,
    outputs: str | Iterable[str],
    language: str = "c",
    parameters: Mapping[str, Value] | None = None,
) -> str:
    """Return source text that computes the `outputs`.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    outputs : str or iterable of str
        Names of outputs, or expressions in them, as for `compile`; ``eqs.outputs()`` lists the names.
    language : str
        "c" for C99, "python" for a module that needs NumPy alone, "fortran" for Fortran 2008, "matlab"
        (or "octave"), "julia", "rust", "javascript" for an ES module, "jax", "casadi", or "modelica" for a
        model with states and their derivatives, of which the outputs may be none; each text explains itself
        at its head.
    parameters : mapping, optional
        Values to put in; an empty mapping puts in those of the model, None leaves every parameter an
        argument, in the order of ``eqs.parameters``.

    Returns
    -------
    str
        The text of one file with a function ``f`` of time, coordinates q, speeds u, inputs r and parameters
        p, in the orders of ``eqs.coordinate_names``, ``eqs.speed_names``, ``eqs.input_names`` and
        ``eqs.parameter_names``.

    Raises
    ------
    CompileError
        If the language or an output is unknown, or parameters have no value.
    UsageError, AssemblyError
        If a motion is not a Modelica model, or has no first state.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> text = sb.generate_code(eqs, "udot", language="python")
    >>> [line for line in text.splitlines() if line.startswith("def f")]
    ['def f(t, q, u, r=(), p=()):']
    """
    if isinstance(language, str) and language.lower() == "modelica":
        return modelica_model(eqs, (outputs,) if isinstance(outputs, str) else tuple(outputs), parameters)
    free = eqs.parameter_names if parameters is None else ()
    sequence, signature = form_sequence(eqs, outputs, parameters or {}, free)
    return source_text(sequence, language, signature)


# Zero at the start; what is shown of how far loops open.
_CLOSED: Final = ("constraints", "velocity_constraints")
_FACTOR: Final = re.compile(r"([A-Za-z]+)(?:\^(-?\d+))?")


def modelica_model(eqs: EquationSet, outputs: tuple[str, ...], parameters: Mapping[str, Value] | None) -> str:
    """Return the Modelica model of a mechanism.

    Raises UsageError if its motion changes its equations on the way, or constraints depend on others;
    AssemblyError, CompileError if there is no first state, or an output is unknown.

    Parameters
    ----------
    outputs : tuple of str
        What becomes an output, besides the constraints.
    parameters : mapping, optional
        Values to put in; None leaves parameters that are not formulas of others as parameters.
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
        reason = "; ".join(filter(None, ("joints stick and slip, ropes slacken, or gaps open", reason)))
    if reason:
        raise UsageError(
            Problem("modelica.motion", eqs.model.name,
                    f"this mechanism cannot be exported to Modelica: {reason}",
                    "the equations of a Modelica model cannot change",
                    "give friction a smooth law, replace ropes by springs, give limits and contacts a "
                    "stiffness, or use simulate")
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
    values = (*state.u.values(), *state.q.values(), *state.s.values())
    free = (True,) * len(values)
    if not (is_assembled or eqs.quaternions):
        r, chosen = np.zeros(len(eqs.input_names)), eqs.mobility.independent_speeds
        free = free_states(eqs, state.parameters, np.array(values), r, chosen)
    for name, value, is_free in zip(eqs.state_names, values, free, strict=True):
        yield Declaration(name, _unit(eqs, name), float(value), is_free)


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
