"""The variables of an FMU, in the order of their value references."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.closed_gaps import with_closed_gaps
from symbody.codegen.formation.sequences import form_sequence
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_row
from symbody.expr.sequences.dependencies import Symbols, dependencies
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.program import written_out
from symbody.fmu.functions import Floats, ModelFunction, are_symbols
from symbody.fmu.names import entry_name, rate_name, unique_names, variable_name
from symbody.fmu.program import FmuProgram
from symbody.kernels.modes.mode_problem import LOOSE

Flags = NDArray[np.bool_]

VIOLATION: Final = "largest position constraint over the size of the mechanism, 0 for open mechanisms"


@dataclass(frozen=True, slots=True)
class FmuVariable:
    """A real number of an FMU.

    Attributes
    ----------
    name : str
        By the structured naming convention.
    causality, variability, initial : str
        As the standards define them; `initial` is empty where it follows from the others.
    start : float or None
        First value, of those that can be set.
    unit : str
        SI unit; empty where it is not known.
    description : str
        In the words of the model.
    nominal : float or None
        What counts as large.
    derivative : int or None
        Value reference of the state whose derivative this is.
    dependencies : tuple of (int, str) or None
        Value references of what it depends on in the motion, and how.

    Examples
    --------
    >>> import symbody as sb
    >>> height = sb.FmuVariable("z", "output", "continuous", unit="m")
    >>> height.name, height.unit, height.start
    ('z', 'm', None)
    """

    name: str
    causality: str
    variability: str
    initial: str = ""
    start: float | None = None
    unit: str = ""
    description: str = ""
    nominal: float | None = None
    derivative: int | None = None
    dependencies: tuple[tuple[int, str], ...] | None = None


def fmu_variables(program: FmuProgram) -> tuple[FmuVariable, ...]:
    """Return time, states, their derivatives, inputs, held values, parameters, outputs, event indicators."""
    made = [
        FmuVariable("time", "independent", "continuous", unit="s", description="time"),
        *_states(program), *_rates(program), *_inputs(program), *_held_values(program),
        *_parameters(program), *_outputs(program), *_indicators(program),
    ]  # fmt: skip
    names = unique_names(variable.name for variable in made)
    return tuple(replace(variable, name=name) for variable, name in zip(made, names, strict=True))


def independent_states(program: FmuProgram) -> tuple[bool, ...]:
    """Return which states (u, q, s) can be set: the others follow from the constraints."""
    eqs = program.eqs
    n_u = len(eqs.speed_names)
    if not program.modal.eqs.multiplier_names:
        return (True,) * len(eqs.state_names)
    by_q, jacobian = _constraint_slopes(program)
    free = with_closed_gaps(program.motion.eqs, ())  # nothing is held at first
    chosen = free.mobility.independent_speeds if free.multiplier_names else range(n_u)
    preferred = {eqs.speed_names[k] for k in chosen}
    free_u = _free_columns(jacobian, np.array([name in preferred for name in eqs.speed_names]))
    count = len(program.modal.eqs.formed.holonomic)
    wanted = np.array([f"{name}_dot" in preferred for name in eqs.coordinate_names])
    free_q = _free_columns(by_q[:count], wanted)
    return (*free_u, *free_q, *(True for _ in eqs.signal_state_names))


def held_states(eqs: EquationSet, are_free: Iterable[bool]) -> tuple[bool, ...]:
    """Return which states keep the values that were set: not quaternions, which are normalized."""
    loose = {name for group in eqs.quaternions for name in group}
    return tuple(free and name not in loose for name, free in zip(eqs.state_names, are_free, strict=True))


def _constraint_slopes(program: FmuProgram) -> list[Floats]:
    """Return the derivatives of constraints by coordinates and by speeds at the first state."""
    eqs, given, modes = program.modal.eqs, program.parameters, program.modal.modes
    outputs = ("position_jacobian", "jacobian")
    sequence = written_out(form_sequence(eqs, outputs, given.fixed_formulas, given.arguments)[0])
    n_u, x = len(eqs.speed_names), program.x0.tolist()
    point = {
        "t": [0.0], "q": x[n_u:], "u": x[:n_u], "p": given.values.tolist(),
        "r": [*[0.0] * len(program.eqs.input_names), *[float(LOOSE)] * len(modes)],
    }  # fmt: skip
    values = evaluate_sequence(sequence, point)
    shapes = [output.shape for output in sequence.outputs]
    return [np.reshape(np.asarray(v, dtype=np.float64), s) for v, s in zip(values, shapes, strict=True)]


def _free_columns(matrix: Floats, is_preferred: Flags) -> list[bool]:
    """Return which variables of linear constraints can be chosen, those preferred as far as possible."""
    A = matrix / np.maximum(np.abs(matrix).max(axis=1, initial=0.0, keepdims=True), 1e-300)
    free = np.ones(A.shape[1], dtype=bool)
    for candidates in (~is_preferred, is_preferred):
        columns = np.flatnonzero(candidates)
        while columns.size and A.shape[0]:
            row, place = np.unravel_index(np.abs(A[:, columns]).argmax(), (A.shape[0], columns.size))
            if abs(A[row, columns[place]]) < 1e-9:
                break
            column = columns[place]
            rest = np.delete(A, row, axis=0)
            A = rest - np.outer(rest[:, column] / A[row, column], A[row])
            free[column] = False
            columns = np.delete(columns, place)
    return [bool(each) for each in free]


def _states(program: FmuProgram) -> Iterator[FmuVariable]:
    eqs = program.eqs
    for name, x, free, size in zip(
        eqs.state_names, program.x0, independent_states(program), program.nominal, strict=True
    ):
        words = f"{name}: {'state' if free else 'state that follows from the others'}"
        yield FmuVariable(
            variable_name(name), "local", "continuous", "exact" if free else "calculated",
            float(x) if free else None, eqs.units.get(name, ""), words, float(size),
        )  # fmt: skip


def _rates(program: FmuProgram) -> Iterator[FmuVariable]:
    eqs = program.eqs
    depends = _dependencies(program, program.functions["slope"])
    for k, name in enumerate(eqs.state_names):
        unit = eqs.units.get(f"{name}_dot") or _rate_unit(eqs.units.get(name, ""))
        yield FmuVariable(
            rate_name(name), "local", "continuous", "calculated", None, unit, f"time derivative of {name}",
            derivative=1 + k, dependencies=depends[k],
        )  # fmt: skip


def _rate_unit(unit: str) -> str:
    return {"m": "m/s", "rad": "rad/s", "m/s": "m/s^2", "rad/s": "rad/s^2"}.get(unit, "")


def _inputs(program: FmuProgram) -> Iterator[FmuVariable]:
    for name in program.input_names:
        unit = program.eqs.units.get(name, "")
        yield FmuVariable(
            variable_name(name), "input", "continuous", start=0.0, unit=unit, description=f"input {name}"
        )


def _held_values(program: FmuProgram) -> Iterator[FmuVariable]:
    for value in program.samples.values:
        unit, words = program.eqs.units.get(value.name, ""), f"{value.name}: held constant between samples"
        yield FmuVariable(variable_name(value.name), "local", "discrete", "exact", value.initial, unit, words)


def _parameters(program: FmuProgram) -> Iterator[FmuVariable]:
    given, units = program.parameters, program.eqs.units
    for name, value in zip(given.arguments, given.values, strict=True):
        variability = "fixed" if name in given.fixed else "tunable"
        yield FmuVariable(
            variable_name(name), "parameter", variability, "exact", float(value), units.get(name, ""),
            f"parameter {name}",
        )  # fmt: skip
    if not given.calculated:
        return
    fixed = [k for k, name in enumerate(given.arguments) if name in given.fixed]
    for name, read in zip(
        given.calculated, dependencies(program.functions["parameters"].sequence), strict=True
    ):
        tunable = any(("p", k) in read for k in range(len(given.arguments)) if k not in fixed)
        yield FmuVariable(
            variable_name(name), "calculatedParameter", "tunable" if tunable else "fixed", "calculated",
            unit=units.get(name, ""), description=f"parameter {name}",
        )  # fmt: skip


def _outputs(program: FmuProgram) -> Iterator[FmuVariable]:
    function, units = program.functions["output"], program.eqs.units
    depends = _dependencies(program, function)
    count = function.sizes[0]
    merged = sorted({entry[0] for entries in depends[:count] for entry in entries})
    violation = tuple((reference, "dependent") for reference in merged)
    yield FmuVariable(
        "constraint_violation", "output", "continuous", "calculated", unit="", description=VIOLATION,
        dependencies=violation,
    )  # fmt: skip
    place = count
    for output in function.sequence.outputs[1:]:
        for k in range(len(output.values)):
            yield FmuVariable(
                entry_name(output.name, output.shape, k), "output", "continuous", "calculated",
                unit=units.get(output.name, ""), description=output.name, dependencies=depends[place],
            )  # fmt: skip
            place += 1


def _indicators(program: FmuProgram) -> Iterator[FmuVariable]:
    if program.events:
        depends = _dependencies(program, program.functions["indicators"])[: len(program.events)]
        for event, read in zip(program.events, depends, strict=True):
            yield _indicator(
                f"event.{variable_name(event.label)}", f"passes zero at event {event.label}", read
            )
    if program.conditions:
        depends = _dependencies(program, program.functions["sides"])
        for k, (condition, read) in enumerate(zip(program.conditions, depends, strict=True), start=1):
            words = f"passes zero where a condition in {', '.join(condition.reads)} changes"
            yield _indicator(f"condition[{k}]", words, read)
    ends = [(f"joint {name} sticks or slips", name) for name in program.modal.joints]
    for name in program.modal.ropes:
        is_rope = unilateral_row(program.modal.eqs.formed, name).sense < 0
        ends.append((f"rope {name} goes slack or taut" if is_rope else f"stop {name} closes or opens", name))
    for words, name in ends:
        yield FmuVariable(
            f"mode_end.{variable_name(name)}", "local", "continuous", description=f"passes zero where {words}"
        )


def _indicator(name: str, words: str, read: tuple[tuple[int, str], ...]) -> FmuVariable:
    return FmuVariable(name, "local", "continuous", description=words, dependencies=read)


def _dependencies(program: FmuProgram, function: ModelFunction) -> list[tuple[tuple[int, str], ...]]:
    """Return what each result depends on in continuous time: value references, and how."""
    plain = are_symbols(function.sequence)
    return [
        _references(program, read, "constant" if plain[k] else "dependent")
        for k, read in enumerate(dependencies(function.sequence))
    ]


def _references(program: FmuProgram, read: Symbols, kind: str) -> tuple[tuple[int, str], ...]:
    n_u, n = len(program.eqs.speed_names), len(program.eqs.state_names)
    firsts = {"t": 0, "u": 1, "q": 1 + n_u, "r": 1 + 2 * n}
    held = {
        ("r", value.slot) for value in program.samples.values
    }  # constant in continuous time, as are modes
    held |= {("r", len(program.eqs.input_names) + k) for k in range(len(program.modal.modes))}
    return tuple(sorted((firsts[group] + place, kind) for group, place in read - held if group in firsts))
