"""The statements of a text: one for every operation, in the order of the sequence.

A `Dialect` holds how a language writes numbers, entries and operations; the walk is the same for all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass

from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import Piece, argument_places
from symbody.codegen.texts.layout import TextLayout
from symbody.expr import opcodes as op
from symbody.expr.sequence import Operation


@dataclass(frozen=True, slots=True)
class Dialect:
    """How one language writes things.

    Attributes
    ----------
    expressions : mapping of operation code to format
    assignment : str
        Format of a statement, with ``name`` and ``value``, indented.
    definition : str
        The same for a new variable, where that is written otherwise.
    number : callable
        Text of a double, in parentheses if negative.
    entry : callable
        Text of entry k of an array, counted from 0.
    held : str
        Format of a constant that is the operand of an operation without variables.
    is_held : bool
        Whether such a constant becomes a variable, because compilers refuse what they can compute.
    truth, is_true : str
        Formats that make a number of a condition, for the work array, and a condition of that number.
    kernel : callable, optional
        Lines that define a name as the list udot, lambda, rank: name, n, m, operands. Without it a kernel
        reads and writes the work array.
    kernel_call : str
        Format of that call, with ``n``, ``m``, entries of ``work`` where ``M``, ``J``, ``F``, ``gamma`` and
        ``solution`` begin, and how many numbers lie before the ``arguments``, ``results`` and ``scratch``.
    """

    expressions: Mapping[int, str]
    assignment: str
    number: Callable[[float], str]
    entry: Callable[[str, int], str]
    held: str = "{0}"
    is_held: bool = False
    truth: str = ""
    is_true: str = ""
    kernel: Callable[[str, int, int, Items[str]], Items[str]] | None = None
    kernel_call: str = ""
    definition: str = ""


class Statements:
    """Writes the statements of one piece.

    Parameters
    ----------
    targets : mapping of output place to text
        What each number of the output is assigned to; places that are missing are left to the caller.

    Attributes
    ----------
    reals, conditions : list of str
        Names of the variables that the statements define.
    """

    def __init__(
        self, layout: TextLayout, piece: Piece, dialect: Dialect, targets: Mapping[int, str]
    ) -> None:
        self.reals: list[str] = []
        self.conditions: list[str] = []
        self._sequence = layout.sequence
        self._plan = layout.plan
        self._words = layout.words
        self._piece = piece
        self._dialect = dialect
        self._targets = targets
        self._names: dict[int, str] = {}  # how a value is written as an operand
        self._lines: list[str] = []

    def lines(self) -> list[str]:
        """Return the statements."""
        piece = self._piece
        for k in (k for k in range(piece.start, piece.stop) if self._plan.needed[k]):
            operation = self._sequence.operations[k]
            if operation.op not in op.LEAVES and operation.op != op.PICK:
                self._operation(k, operation)
            for place in self._plan.outputs.get(k, ()):
                value = self.operand(k)
                if place in self._targets:
                    self._assign(self._targets[place], value)
            if k in piece.stores:
                value = self.operand(k)
                is_truth = operation.op in op.CONDITIONS
                self._store(piece.stores[k], self._dialect.truth.format(value) if is_truth else value)
        return self._lines

    def operand(self, k: int) -> str:
        """Return how value k is written, reading it first if this piece has not yet."""
        if k not in self._names:
            self._read_value(k)
        return self._names[k]

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code == op.SADDLE:
            self._kernel(k, operands, datum)
        elif code == op.POW and (exponent := integer_exponent(self._sequence, operands[1])) is not None:
            self._power(k, self.operand(operands[0]), exponent)
        else:
            expression = self._dialect.expressions[code].format(*self._operands(k, operands))
            self._define(k, expression, is_condition=code in op.CONDITIONS)

    def _operands(self, k: int, operands: tuple[int, ...]) -> list[str]:
        texts = [self.operand(j) for j in operands]
        if all(j in self._plan.constants for j in operands):
            texts[0] = self._dialect.held.format(texts[0])
            if self._dialect.is_held:
                self._assign(f"z{k}_0", texts[0])
                self.reals.append(f"z{k}_0")
                texts[0] = f"z{k}_0"
        return texts

    def _read_value(self, k: int) -> None:
        code, operands, datum = self._sequence.operations[k]
        entry = self._dialect.entry
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            self._names[k] = self._dialect.number(self._plan.constants[k])
        elif code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            if source.group == "t":
                self._names[k] = "t"
            else:
                self._define(k, entry(source.group, source.position), self._words[datum])
        elif code == op.PICK and self._dialect.kernel is not None:
            self._names[k] = entry(f"z{operands[0]}", datum)
        elif code == op.PICK:
            self._define(k, entry("work", self._plan.results[operands[0]] + datum))
        elif code in op.CONDITIONS:
            place = entry("work", self._piece.loads[k])
            self._define(k, self._dialect.is_true.format(place), is_condition=True)
        else:
            self._define(k, entry("work", self._piece.loads[k]))

    def _define(self, k: int, expression: str, name: str = "", *, is_condition: bool = False) -> None:
        self._names[k] = name or f"z{k}"
        (self.conditions if is_condition else self.reals).append(self._names[k])
        form = self._dialect.definition or self._dialect.assignment
        self._lines.append(form.format(name=self._names[k], value=expression))

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            self._define(k, f"{names[first]} * {names[second]}", f"z{k}_{len(names)}")
            names.append(self._names[k])
        self._names[k] = names[-1]

    def _kernel(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        plan, kernel = self._plan, self._sequence.kernels[datum]
        texts = [self.operand(j) for j in operands]
        if self._dialect.kernel is not None:
            self._lines += self._dialect.kernel(f"z{k}", kernel.n, kernel.m, texts)
            return
        for place, text in enumerate(texts, plan.arguments):
            self._store(place, text)
        places = (*argument_places(kernel, plan.arguments), plan.results[k])
        words = ("M", "J", "F", "gamma", "solution")
        begins = {word: self._dialect.entry("work", place) for word, place in zip(words, places, strict=True)}
        call = self._dialect.kernel_call
        numbers = {"n": kernel.n, "m": kernel.m, "arguments": plan.arguments, "results": plan.results[k]}
        self._lines.append(call.format(**numbers, scratch=plan.scratch, **begins))

    def _store(self, place: int, text: str) -> None:
        self._assign(self._dialect.entry("work", place), text)

    def _assign(self, name: str, value: str) -> None:
        self._lines.append(self._dialect.assignment.format(name=name, value=value))
