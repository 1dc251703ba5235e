"""Python text of a sequence: a module that needs NumPy and nothing else, for points and for batches.

Every operation is one statement, in the order of the sequence. Text like this is for other people's tools:
symbody writes it and never runs it.
"""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Final

from symbody.codegen.identifiers import assign_identifiers, quote_name
from symbody.codegen.kernels.python_kernels import PYTHON, SADDLE_CALL
from symbody.codegen.kernels.text_writer import saddle_text
from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import Plan, plan_pieces
from symbody.codegen.texts.python_words import numpy_formats
from symbody.codegen.texts.text_dialect import number_text
from symbody.errors import CompileError, Problem
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Sequence

WIDTH: Final = 100

_WORDS: Final = {
    "t": "time", "q": "coordinates", "u": "speeds", "r": "inputs", "p": "parameters", "c": "constants",
    "s": "states of signals",
}  # fmt: skip

# y + 0: the angle of a point on the negative x axis is pi, also where y is -0.
_EXPRESSIONS: Final = numpy_formats("np.", "np.arctan2({0} + 0.0, {1})")

# What the text itself uses, and may come to use of Python; names that begin with an underscore are never
# given to inputs.
_BUILTINS: Final = """
    abs all any bool dict enumerate filter float int isinstance len list map max min object range reversed
    round set slice sorted str sum super tuple type zip ArithmeticError TypeError ValueError ZeroDivisionError
""".split()
_RESERVED: Final = frozenset(
    {*keyword.kwlist, *keyword.softkwlist, *_BUILTINS, *_WORDS}.difference("s")
    | {"np", "math", "namedtuple", "Outputs", "batch", "out"}
)
_RESERVED_FORM: Final = re.compile(r"z\d+(_\d+)?")


def generate(
    sequence: Sequence, name: str = "f", names: Mapping[str, str] | None = None, *, has_signals: bool = False
) -> str:
    """Return a Python module with one function ``name(t, q, u, r=(), p=())``, called as `compile`'s are.

    Products and sums that other languages contract are rounded one after the other.

    Parameters
    ----------
    name : str
        Name of the function.
    names : mapping of str to str, optional
        What inputs and outputs are to be called in the text instead of their own names.
    has_signals : bool
        Whether states s of signals are one more argument, the last.

    Raises
    ------
    CompileError
        If `name` is not a Python identifier, the sequence calls functions the user supplied, or a constant
        is beyond the doubles.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or _is_reserved(name):
        raise CompileError(
            Problem("compile.name", "", f"{quote_name(name)} cannot be the name of a Python function",
                    "not an identifier, longer than 41 letters, or taken", "choose another, such as 'f'")
        )  # fmt: skip
    plan = plan_pieces(sequence)
    module = _Module(sequence, plan, name, names or {}, has_signals=has_signals)
    kernel = ["", "", *saddle_text(PYTHON, SADDLE_CALL).rstrip("\n").split("\n")] if plan.results else []
    return "\n".join([*module.head(), *kernel, "", "", *module.function()]) + "\n"


def _is_reserved(word: str) -> bool:
    return word in _RESERVED or _RESERVED_FORM.fullmatch(word) is not None


class _Module:
    """Writes the parts of one module."""

    def __init__(
        self, sequence: Sequence, plan: Plan, name: str, names: Mapping[str, str], *, has_signals: bool
    ) -> None:
        self._sequence = sequence
        self._plan = plan
        self._name = name
        self._labels = [names.get(entry.name, entry.name) for entry in sequence.inputs]
        taken = {name, "s"} if has_signals else {name}
        words = assign_identifiers(self._labels, lambda word: _is_reserved(word) or word in taken)
        self._words = [
            "t" if entry.group == "t" else word for entry, word in zip(sequence.inputs, words, strict=True)
        ]
        self._results = [names.get(entry.name, entry.name) for entry in sequence.outputs]
        self._fields = assign_identifiers(self._results, keyword.iskeyword)
        optional = {"c": bool(sequence.group_size("c")), "s": has_signals}
        self._groups = [group for group in _WORDS if optional.get(group, True)]

    def head(self) -> Iterator[str]:
        """Yield the docstring and what is imported."""
        count = self._sequence.operation_count
        yield 'r"""' + textwrap.dedent(f"""\
            {self._call()}: {self._sequence.output_size} numbers

            {count} operations a call. Written by symbody; needs NumPy and nothing else.
            Arguments are numbers: t one, all others one-dimensional; or they have leading batch axes
            that broadcast against each other, so that q of shape (B, n) gives results of shape (B, ...).
            The result is one array, or a named tuple of arrays if several outputs were asked for.
            Nothing raises or warns on the way: as IEEE 754 has it, 1/0 is infinite, 0/0 is nan.""")
        if self._plan.results:
            yield "Where a linear system has no solution, what depends on it is nan.\n"
        else:
            yield ""
        yield "Arguments: place, identifier, name"
        rows = zip(self._sequence.inputs, self._words, self._labels, strict=True)
        for entry, word, label in sorted(
            rows, key=lambda row: ("tqurpcs".index(row[0].group), row[0].position)
        ):
            place = "t" if entry.group == "t" else f"{entry.group}[{entry.position}]"
            yield f"  {place}  {word}  {quote_name(label)}"
        yield "Results: identifier, shape, name"
        for output, field, label in zip(self._sequence.outputs, self._fields, self._results, strict=True):
            yield f"  {field}  {output.shape}  {quote_name(label)}"
        yield '"""'
        yield ""
        yield from ["import math"] if self._plan.results else []
        yield from ["from collections import namedtuple"] if self._is_tuple else []
        yield from [""] if self._plan.results or self._is_tuple else []
        yield "import numpy as np"
        if self._is_tuple:
            yield ""
            yield f"Outputs = namedtuple({self._name + '_outputs'!r}, {self._fields!r})"

    @property
    def _is_tuple(self) -> bool:
        return len(self._sequence.outputs) != 1

    def _call(self) -> str:
        arguments = [group if group in "tqu" else f"{group}=()" for group in self._groups]
        return f"{self._name}({', '.join(arguments)})"

    def function(self) -> Iterator[str]:
        """Yield the function, behind the one that checks its arguments."""
        yield "def _columns(word, values, size):"
        yield "    values = np.asarray(values, dtype=float)"
        yield "    if values.ndim == 0 or values.shape[-1] < size:"
        yield '        raise ValueError(f"{word} need {size} numbers on their last axis")'
        yield "    return np.moveaxis(values, -1, 0)"
        yield ""
        yield ""
        yield '@np.errstate(all="ignore")'
        yield f"def {self._call()}:"
        yield f'    """Return {", ".join(self._fields) or "nothing"}; see the module."""'
        yield "    t = np.asarray(t, dtype=float)"
        shapes = ["t.shape"]
        for group in self._groups[1:]:
            size = self._sequence.group_size(group)
            yield f'    {group} = _columns("{_WORDS[group]} {group}", {group}, {size})'
            shapes.append(f"{group}.shape[1:]")
        yield f"    batch = np.broadcast_shapes({', '.join(shapes)})"
        yield from _Statements(self._sequence, self._plan, self._words).lines()
        yield from self._return()

    def _return(self) -> Iterator[str]:
        parts, start = [], 0
        for output in self._sequence.outputs:
            stop = start + len(output.values)
            parts.append(f"out[..., {start}:{stop}].reshape(batch + {output.shape!r})")
            start = stop
        if not self._is_tuple:
            yield f"    return {parts[0]}"
            return
        yield "    return Outputs("
        yield from (f"        {part}," for part in parts)
        yield "    )"


class _Statements:
    """Writes the statements of the function."""

    def __init__(self, sequence: Sequence, plan: Plan, words: list[str]) -> None:
        self._sequence = sequence
        self._plan = plan
        self._words = words
        self._names: dict[int, str] = {}  # how a value is written as an operand
        self._lines: list[str] = []

    def lines(self) -> list[str]:
        for k, operation in enumerate(self._sequence.operations):
            if self._plan.needed[k]:
                self._operation(k, operation)
        self._lines.append(f"    out = np.empty(batch + ({self._sequence.output_size},))")
        for place, value in enumerate(k for output in self._sequence.outputs for k in output.values):
            self._lines.append(f"    out[..., {place}] = {self._names[value]}")
        return self._lines

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            self._names[k] = number_text(self._plan.constants[k])
        elif code == op.SYMBOL:
            self._input(k, datum)
        elif code == op.PICK:
            self._names[k] = f"{self._names[operands[0]]}[{datum}]"
        elif code == op.SADDLE:
            self._saddle(k, operands, datum)
        elif code == op.POW and (exponent := integer_exponent(self._sequence, operands[1])) is not None:
            self._power(k, self._operands(operands[:1])[0], exponent)
        else:
            self._define(k, _EXPRESSIONS[code].format(*self._operands(operands)))

    def _input(self, k: int, datum: int) -> None:
        entry = self._sequence.inputs[datum]
        if entry.group == "t":
            self._names[k] = "t"
        else:
            self._define(k, f"{entry.group}[{entry.position}]", self._words[datum])

    def _operands(self, operands: tuple[int, ...]) -> list[str]:
        """Return how the operands are written; NumPy's numbers divide by zero, Python's do not."""
        texts = [self._names[j] for j in operands]
        if all(j in self._plan.constants for j in operands):
            texts[-1] = f"np.float64({texts[-1]})"
        return texts

    def _define(self, k: int, expression: str, name: str = "") -> None:
        self._names[k] = name or f"z{k}"
        self._lines.append(f"    {self._names[k]} = {expression}")

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            self._define(k, f"{names[first]} * {names[second]}", f"z{k}_{len(names)}")
            names.append(self._names[k])
        self._names[k] = names[-1]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        kernel = self._sequence.kernels[datum]
        names = ", ".join(self._names[j] for j in operands)
        filled = textwrap.wrap(names, WIDTH - 8, break_long_words=False, break_on_hyphens=False)
        self._names[k] = f"z{k}"
        self._lines.append(f"    z{k} = symbody_saddle({kernel.n}, {kernel.m}, [")
        self._lines += [f"        {line}" for line in filled]
        self._lines.append("    ])")
