"""The variables of an FMU, in the order of their value references, and their structured names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.analysis.configurations.closed_gaps import with_closed_gaps
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import element_words
from symbody.expr import opcodes as op
from symbody.expr.sequences.dependencies import Symbols, dependencies
from symbody.fmu.program import FmuProgram
from symbody.kernels.modes.mode_problem import LOOSE
from symbody.simulation.programs.free_states import free_states
from symbody.simulation.programs.program_function import ProgramFunction

_RATE_UNITS: Final = {"m": "m/s", "rad": "rad/s", "m/s": "m/s^2", "rad/s": "rad/s^2"}
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
    eqs, modal = program.eqs, program.modal
    if not modal.eqs.multiplier_names:
        return (True,) * len(eqs.state_names)
    closed = with_closed_gaps(program.motion.eqs, ())  # nothing is held at first
    chosen = closed.mobility.independent_speeds if closed.multiplier_names else range(len(eqs.speed_names))
    r = np.array([*[0.0] * len(eqs.input_names), *[float(LOOSE)] * len(modal.modes)])
    return free_states(modal.eqs, program.parameters.given, program.x0, r, chosen)


def held_states(eqs: EquationSet, are_free: Iterable[bool]) -> tuple[bool, ...]:
    """Return which states keep the values that were set: not quaternions, which are normalized."""
    loose = {name for group in eqs.quaternions for name in group}
    return tuple(free and name not in loose for name, free in zip(eqs.state_names, are_free, strict=True))


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
        unit = eqs.units.get(f"{name}_dot") or _RATE_UNITS.get(eqs.units.get(name, ""), "")
        yield FmuVariable(
            rate_name(name), "local", "continuous", "calculated", None, unit, f"time derivative of {name}",
            derivative=1 + k, dependencies=depends[k],
        )  # fmt: skip


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
            words = f"passes zero at event {event.label}"
            name = f"event.{variable_name(event.label)}"
            yield FmuVariable(name, "local", "continuous", description=words, dependencies=read)
    if program.conditions:
        depends = _dependencies(program, program.functions["sides"])
        for k, (condition, read) in enumerate(zip(program.conditions, depends, strict=True), start=1):
            words = f"passes zero where a condition in {', '.join(condition.reads)} changes"
            name = f"condition[{k}]"
            yield FmuVariable(name, "local", "continuous", description=words, dependencies=read)
    for name in program.modal.names:
        kind, shown = element_words(program.modal.eqs.formed, name)
        happens = "goes slack or taut" if kind == "rope" else "closes or opens"
        if name in program.modal.joints:
            happens = "sticks or slips"
        words = f"passes zero where {kind} {shown} {happens}"
        yield FmuVariable(f"mode_end.{variable_name(name)}", "local", "continuous", description=words)


def _dependencies(program: FmuProgram, function: ProgramFunction) -> list[tuple[tuple[int, str], ...]]:
    """Return what each result depends on in continuous time: value references, and how."""
    sequence = function.sequence
    results = [sequence.operations[k] for output in sequence.outputs for k in output.values]
    return [
        _references(program, read, "constant" if result.op == op.SYMBOL else "dependent")
        for result, read in zip(results, dependencies(sequence), strict=True)
    ]


def _references(program: FmuProgram, read: Symbols, kind: str) -> tuple[tuple[int, str], ...]:
    n_u, n = len(program.eqs.speed_names), len(program.eqs.state_names)
    firsts = {"t": 0, "u": 1, "q": 1 + n_u, "r": 1 + 2 * n}
    held = {
        ("r", value.slot) for value in program.samples.values
    }  # constant in continuous time, as are modes
    held |= {("r", len(program.eqs.input_names) + k) for k in range(len(program.modal.modes))}
    return tuple(sorted((firsts[group] + place, kind) for group, place in read - held if group in firsts))


_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_QUOTABLE: Final = re.compile(r"[A-Za-z_0-9!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]")


def variable_name(name: str) -> str:
    """Return a name of the model, or of an output, as a structured name.

    >>> variable_name("theta"), variable_name("reaction B Fx"), variable_name("2*theta + phi")
    ('theta', 'reaction.B.Fx', "'2*theta + phi'")
    """
    words = name.split()
    is_path = len(words) > 1 and _PLAIN.fullmatch(words[0]) is not None and not re.search(r"[-+*/^<>=]", name)
    return ".".join(_part(word) for word in words) if is_path else _part(name)


def rate_name(name: str) -> str:
    """Return the name of the derivative of a state.

    >>> rate_name("theta")
    'der(theta)'
    """
    return f"der({variable_name(name)})"


def entry_name(name: str, shape: tuple[int, ...], place: int) -> str:
    """Return the name of one entry of an output, counted by rows; indices count from 1.

    >>> entry_name("reaction B", (6,), 0), entry_name("energy", (), 0), entry_name("M", (2, 2), 2)
    ('reaction.B[1]', 'energy', 'M[2,1]')
    """
    indices = []
    for size in reversed(shape):
        place, k = divmod(place, size)
        indices.append(str(k + 1))
    return variable_name(name) + (f"[{','.join(reversed(indices))}]" if shape else "")


def unique_names(names: Iterable[str]) -> list[str]:
    """Return names of which no two are the same: later ones get a number."""
    taken: set[str] = set()
    result = []
    for name in names:
        unique, number = name, 2
        while unique in taken:
            stem = name[:-1] if name.endswith("'") else name
            unique = f"{stem}_{number}'" if name.endswith("'") else f"{stem}_{number}"
            number += 1
        taken.add(unique)
        result.append(unique)
    return result


def identifier(name: str) -> str:
    """Return the name of a model as an identifier of C.

    >>> identifier("slider crank-2"), identifier("3d")
    ('slider_crank_2', 'm_3d')
    """
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if _PLAIN.fullmatch(plain) else f"m_{plain}"


def _part(word: str) -> str:
    if _PLAIN.fullmatch(word):
        return word
    letters = (letter if _QUOTABLE.fullmatch(letter) else _escape(letter) for letter in word)
    return f"'{''.join(letters)}'"


def _escape(letter: str) -> str:
    if letter in "'\"\\":
        return f"\\{letter}"
    return " " if letter.isspace() else f"#{ord(letter):x}#"
