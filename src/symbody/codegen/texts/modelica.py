"""Modelica text of a sequence: one flat model, whose equations are those of the sequence.

Values that are read once stand where they are read, all others are variables. Linear systems are written out
as equations, which the tool solves. What only one branch of a choice reads, and what is not defined
everywhere, is computed in that branch alone: a Modelica tool stops at a division by zero, wherever it stands.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass
from typing import Final

from symbody.codegen.identifiers import assign_identifiers, quote_name
from symbody.codegen.lowering import constant_values, integer_exponent, refuse_user_functions
from symbody.codegen.texts.choices import Path, find_choices
from symbody.codegen.texts.modelica_names import RESERVED, quoted_names
from symbody.codegen.texts.text_dialect import operation_formats
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Output, Sequence

_WIDTH: Final = 110
_LONGEST: Final = 72  # letters of a value that stands where it is read
_ATOM: Final = 9
# How tightly a text binds: sums 1, products 2, powers 3, all else like a name.
_BINDING: Final = {op.NEG: 1, op.ADD: 1, op.SUB: 1, op.FMA: 1, op.MUL: 2, op.DIV: 2, op.POW: 3}
_OPERANDS: Final = {
    op.NEG: (2,), op.ADD: (1, 2), op.SUB: (1, 2), op.FMA: (2, 3, 2), op.MUL: (2, 3), op.DIV: (2, 3),
    op.POW: (4, 4), op.LT: (1, 1), op.LE: (1, 1), op.EQ: (1, 1),
}  # fmt: skip
_FORMATS: Final = operation_formats(
    "",
    {
        op.POW: "{0} ^ {1}",
        op.ATAN2: "atan2({0}, {1})",
        # The standard's sign is 0 within an event, and no event itself.
        op.SIGN: "(if {0} > 0.0 then 1.0 elseif {0} < 0.0 then -1.0 else 0.0)",
        op.MIN: "min({0}, {1})",
        op.MAX: "max({0}, {1})",
        op.EQ: "noEvent({0} <= {1} and {0} >= {1})",  # Modelica compares reals by == in functions alone
        op.AND: "({0} and {1})",
        op.OR: "({0} or {1})",
        op.NOT: "not ({0})",
        op.SELECT: "(if {0} then {1} else {2})",
    },
)
# Read several times in their format.
_REPEATED: Final = frozenset({op.SIGN, op.EQ})
# Not defined, or not finite, for some numbers.
_PARTIAL: Final = frozenset(
    {op.DIV, op.POW, op.SQRT, op.LOG, op.ASIN, op.ACOS, op.TAN, op.EXP, op.SINH, op.COSH}
)
_TOKEN: Final = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"|\S")


@dataclass(frozen=True, slots=True)
class Declaration:
    """A variable of a model.

    Attributes
    ----------
    name : str
        In the model.
    unit : str
        In Modelica's way of writing; empty where it is not known.
    value : float or None
        Of a parameter; the first value of a state.
    is_free : bool
        Whether a state's first value is a choice, and does not follow from the constraints.
    """

    name: str
    unit: str = ""
    value: float | None = None
    is_free: bool = True


@dataclass(frozen=True, slots=True)
class ModelDeclarations:
    """Names, units and first values of all that a model declares; states in the order (u, q, s).

    Attributes
    ----------
    remarks : tuple of str
        Lines at the head.
    closed : tuple of str
        Outputs of the sequence that are 0 at the start.
    units : mapping of output to unit
        Of outputs.
    """

    name: str
    parameters: Items[Declaration]
    inputs: Items[Declaration]
    states: Items[Declaration]
    units: Mapping[str, str]
    closed: Items[str] = ()
    remarks: Items[str] = ()


def model_text(sequence: Sequence, declared: ModelDeclarations) -> str:
    """Return a Modelica model.

    Parameters
    ----------
    sequence : Sequence
        Its first output is the derivative of the states; those that follow become outputs of the model.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    refuse_user_functions(sequence)
    return "\n".join(_ModelWriter(sequence, declared).lines()) + "\n"


def model_name(name: str) -> str:
    """Return the name of a model as Modelica's users write it.

    >>> model_name("slider crank"), model_name("3d"), model_name("real")
    ('SliderCrank', 'X3d', 'RealModel')
    """
    (word,) = assign_identifiers([name], lambda word: False)
    written = "".join(part[:1].upper() + part[1:] for part in word.split("_"))
    return f"{written}Model" if written in RESERVED else written


class _ModelWriter:
    """Writes one model; value k of the sequence is a variable ``z<k>`` where it is read more than once."""

    def __init__(self, sequence: Sequence, declared: ModelDeclarations) -> None:
        self._sequence = sequence
        self._declared = declared
        self._constants = constant_values(sequence)
        shown = [output.name for output in sequence.outputs[1:]]
        own = [entry.name for entry in (*declared.parameters, *declared.inputs, *declared.states)]
        words = quoted_names([*own, *(name for name in shown if name not in own)])
        self._words = dict(zip([*own, *(name for name in shown if name not in own)], words, strict=True))
        self._first = "z"
        while any(re.fullmatch(rf"'?{self._first}\d+(_\d+)?'?", word) for word in words):
            self._first += "z"
        self._paths, self._reads = find_choices(sequence)
        self._texts: dict[int, tuple[str, int]] = {}  # each value as an operand, and how tightly it binds
        self._variables: list[str] = []
        self._equations: list[str] = []

    def lines(self) -> Iterator[str]:
        """Yield the lines of the model."""
        declared = self._declared
        name = model_name(declared.name)
        states = self._state_equations()
        shown = [line for output in self._sequence.outputs[1:] for line in self._output_equations(output)]
        yield f"model {name} {_string(declared.name)}"
        yield from (f"  // {line}" for line in declared.remarks)
        yield from self._declarations()
        if self._variables:
            yield "protected"
            yield from _fill("Real", self._variables)
        if declared.closed:
            yield "initial equation"
            yield from (f"  {line}" for line in self._initial_equations())
        yield "equation"
        for line in (*self._equations, *states, *shown):
            yield from _break_line(f"  {line};")
        yield f"end {name};"

    # Declarations

    def _declarations(self) -> Iterator[str]:
        declared, words = self._declared, self._words
        outputs = {output.name: output for output in self._sequence.outputs[1:]}
        for entry in declared.parameters:
            value = _number(entry.value or 0.0)
            yield f"  parameter Real {words[entry.name]}{_attributes(entry.unit)} = {value};"
        for entry in declared.inputs:
            yield f"  input Real {words[entry.name]}{_attributes(entry.unit, 'start=0.0')};"
        for entry in declared.states:
            begin = f"start={_number(entry.value or 0.0)}", f"fixed={str(entry.is_free).lower()}"
            kind = "output Real" if entry.name in outputs else "Real"
            yield f"  {kind} {words[entry.name]}{_attributes(entry.unit, *begin)};"
        for output in outputs.values():
            if not self._is_declared(output):
                size = f"[{', '.join(map(str, output.shape))}]" if output.shape else ""
                unit = _attributes(declared.units.get(output.name, ""))
                yield f"  output Real {words[output.name]}{size}{unit};"

    def _is_declared(self, output: Output) -> bool:
        declared = self._declared
        own = (*declared.parameters, *declared.inputs, *declared.states)
        return any(entry.name == output.name for entry in own)

    # Equations

    def _state_equations(self) -> list[str]:
        values = self._sequence.outputs[0].values
        return [
            f"der({self._words[state.name]}) = {self._text(value)}"
            for state, value in zip(self._declared.states, values, strict=True)
        ]

    def _output_equations(self, output: Output) -> Iterator[str]:
        if self._is_declared(output):
            return
        word, size = self._words[output.name], output.shape
        for place, value in enumerate(output.values):
            yield f"{word}{_indices(size, place)} = {self._text(value)}"

    def _initial_equations(self) -> Iterator[str]:
        for output in self._sequence.outputs:
            if output.name in self._declared.closed:
                word = self._words[output.name]
                yield from (f"{word}{_indices(output.shape, k)} = 0.0;" for k in range(len(output.values)))

    # Values

    def _text(self, value: int, binding: int = 0) -> str:
        """Return a value as an operand, in brackets if it binds less tightly."""
        if value not in self._texts:
            for k in self._new_values(value):
                self._texts[k] = self._write(k, self._sequence.operations[k])
        text, strength = self._texts[value]
        return f"({text})" if strength < binding else text

    def _new_values(self, value: int) -> list[int]:
        """Return what has to be written before and with a value, in order."""
        found: set[int] = set()
        ahead = [value]
        while ahead:
            k = ahead.pop()
            if k not in found and k not in self._texts:
                found.add(k)
                ahead += self._sequence.operations[k].operands
        return sorted(found)

    def _write(self, k: int, operation: Operation) -> tuple[str, int]:
        code, operands, datum = operation
        if k in self._constants:
            text = _number(self._constants[k])
            return text, _ATOM if not text.startswith("-") else 1
        if code == op.SYMBOL:
            return self._symbol(datum), _ATOM
        if code == op.PICK:
            kernel = self._sequence.kernels[self._sequence.operations[operands[0]].datum]
            if datum == kernel.n + kernel.m:  # the rank: no row depends on others
                return _number(kernel.m), _ATOM
            return f"{self._first}{operands[0]}_{datum + 1}", _ATOM
        if code == op.SADDLE:
            self._linear_system(k, operation)
            return "", _ATOM
        if code == op.ADD and self._positive(operands[1])[1]:  # a + (-b) is a - b, to the bit
            code, operands = op.SUB, (operands[0], self._positive(operands[1])[0])
        strengths = _OPERANDS.get(code, (0, 0, 0))
        if code in _REPEATED:
            self._name_operands(operands)
        texts = [self._text(j, strength) for j, strength in zip(operands, strengths, strict=False)]
        text, binding = _FORMATS[code].format(*texts), _BINDING.get(code, _ATOM)
        if code == op.POW and (exponent := integer_exponent(self._sequence, operands[1])) is not None:
            text = f"{texts[0]} ^ {exponent}"
        return self._keep(k, code, text, binding)

    def _keep(self, k: int, code: int, text: str, binding: int) -> tuple[str, int]:
        """Return how a value is read: as it is written, or as a variable with an equation."""
        if code in op.CONDITIONS:
            return text, _ATOM
        path = self._paths[k]
        if code in _PARTIAL and path:
            return self._define(k, f"if {self._condition(path)} then {text} else 0.0"), _ATOM
        if self._reads[k] > 1 or len(text) > _LONGEST:
            return self._define(k, text), _ATOM
        return text, binding

    def _name_operands(self, operands: tuple[int, ...]) -> None:
        for k in operands:
            text, binding = self._texts[k]
            if len(text) > 12 and " " in text:
                self._texts[k] = self._define(k, text), _ATOM

    def _define(self, k: int, text: str) -> str:
        name = f"{self._first}{k}"
        self._variables.append(name)
        self._equations.append(f"{name} = {text}")
        return name

    def _symbol(self, place: int) -> str:
        entry = self._sequence.inputs[place]
        if entry.group == "t":
            return "time"
        return self._words[entry.name]

    def _condition(self, path: Path) -> str:
        """Return that the choices on the way to a value were made, without events of its own."""
        words = []
        for choice, holds in path:
            text = self._text(self._sequence.operations[choice].operands[0])
            words.append(text if holds else f"not ({text})")
        return f"noEvent({' and '.join(words)})"

    def _linear_system(self, k: int, operation: Operation) -> None:
        """Write M u' - J^T lambda = F, J u' = gamma; unknowns are ``z<k>_1`` and further."""
        kernel = self._sequence.kernels[operation.datum]
        n, m = kernel.n, kernel.m
        unknown = [f"{self._first}{k}_{i + 1}" for i in range(n + m)]
        self._variables += unknown
        mass, rows = operation.operands[: n * n], operation.operands[n * n : n * n + m * n]
        force, gamma = operation.operands[n * n + m * n :][:n], operation.operands[n * n + m * n + n :]
        for i in range(n):
            pairs = [(mass[i * n + j], unknown[j], False) for j in range(n)]
            pairs += [(rows[c * n + i], unknown[n + c], True) for c in range(m)]
            self._equations.append(f"{self._sum(pairs)} = {self._text(force[i])}")
        for c in range(m):
            pairs = [(rows[c * n + j], unknown[j], False) for j in range(n)]
            self._equations.append(f"{self._sum(pairs)} = {self._text(gamma[c])}")

    def _sum(self, pairs: Items[tuple[int, str, bool]]) -> str:
        """Return the sum of coefficients with unknowns, some of them subtracted; zeros are left out."""
        text = ""
        for value, unknown, is_subtracted in pairs:
            if self._constants.get(value) == 0.0:
                continue
            value, is_negated = self._positive(value)
            is_subtracted ^= is_negated
            is_one = self._constants.get(value) == 1.0
            term = unknown if is_one else f"{self._text(value, 2)} * {unknown}"
            sign = "-" if is_subtracted else "+"
            text = f"{text} {sign} {term}" if text else f"-{term}" if is_subtracted else term
        return text or "0.0"

    def _positive(self, value: int) -> tuple[int, bool]:
        """Return a value without the signs in front of it, and whether they change its sign."""
        is_negated = False
        while self._sequence.operations[value].op == op.NEG:
            (value,) = self._sequence.operations[value].operands
            is_negated = not is_negated
        return value, is_negated


def _indices(shape: tuple[int, ...], place: int) -> str:
    """Return the indices of an entry of an array, counted by rows from 1."""
    indices = []
    for size in reversed(shape):
        place, k = divmod(place, size)
        indices.append(str(k + 1))
    return f"[{', '.join(reversed(indices))}]" if shape else ""


def _attributes(unit: str, *others: str) -> str:
    words = [*([f'unit="{unit}"'] if unit else []), *others]
    return f"({', '.join(words)})" if words else ""


def _number(value: float) -> str:
    return repr(float(value))


def _string(text: str) -> str:
    """Return a string of Modelica in ASCII."""
    return '"' + quote_name(text)[1:-1].replace('\\"', "'").replace("\\", "\\\\") + '"'


def _fill(kind: str, names: Items[str]) -> Iterator[str]:
    """Yield declarations of many variables."""
    line = f"  {kind} "
    for k, name in enumerate(names):
        end = ";" if k + 1 == len(names) else ","
        if len(line) + len(name) >= _WIDTH:
            yield line.rstrip()
            line = "    "
        line += f"{name}{end} "
    yield line.rstrip()


def _break_line(line: str) -> Iterator[str]:
    """Break a line that is too long behind one of its blanks outside quotes."""
    while len(line) > _WIDTH:
        places = [match.end() for match in re.finditer(r"(?:'(?:[^'\\]|\\.)*'|[^' ])+ ", line)]
        indent = len(line) - len(line.lstrip())
        fitting = [place for place in places if indent + 4 < place <= _WIDTH]
        if not fitting:
            break
        yield line[: fitting[-1]].rstrip()
        line = "      " + line[fitting[-1] :]
    yield line
