"""The statements of a text: one for every operation, in the order of the sequence.

A `Dialect` holds how a language writes things; the walk is the same for all.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import Piece, argument_places
from symbody.codegen.texts.layout import TextLayout
from symbody.codegen.texts.text_dialect import Dialect, number_text
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation


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
        entry = self._dialect.entry_text
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            self._names[k] = number_text(self._plan.constants[k], self._dialect.number)
        elif code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            if source.group == "t" and not self._dialect.has_time_array:
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
        self._lines.append(self._dialect.define(self._names[k], expression, is_condition=is_condition))

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            self._define(k, f"{names[first]} * {names[second]}", f"z{k}_{len(names)}")
            names.append(self._names[k])
        self._names[k] = names[-1]

    def _kernel(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        plan, kernel, dialect = self._plan, self._sequence.kernels[datum], self._dialect
        texts: Iterable[str] = (self.operand(j) for j in operands)
        if not dialect.is_interleaved:
            texts = [*texts]
        if dialect.kernel is not None:
            self._lines += dialect.kernel(f"z{k}", kernel.n, kernel.m, [*texts])
            return
        for place, text in enumerate(texts, plan.arguments):
            self._store(place, text)
        places = (*argument_places(kernel, plan.arguments), plan.results[k])
        words = ("M", "J", "F", "gamma", "solution")
        numbers = {word: place + dialect.first for word, place in zip(words, places, strict=True)}
        numbers |= {"n": kernel.n, "m": kernel.m, "arguments": plan.arguments, "results": plan.results[k]}
        self._lines.append(dialect.kernel_call.format(**numbers, scratch=plan.scratch, count=datum + 1))

    def _store(self, place: int, text: str) -> None:
        self._assign(self._dialect.entry_text("work", place), text)

    def _assign(self, name: str, value: str) -> None:
        self._lines.append(self._dialect.assignment.format(name=name, value=value))
