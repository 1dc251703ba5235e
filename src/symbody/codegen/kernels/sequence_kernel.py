"""A sequence as a kernel: one text for all languages of kernels, the same bits in each.

It takes what all generated code takes and returns 0, or k + 1 if the linear system of kernel k has no
solution. No operation is fused; sine and cosine are kernels, too. What the C library computes elsewhere
(``exp``, ``atan2``, ...) each language takes from its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from symbody.codegen.kernels.reader import read_kernels
from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Assign,
    Call,
    Choose,
    Expression,
    KernelTree,
    Literal,
    Parameter,
    Part,
    Perform,
    Return,
    Statement,
    StoreEntry,
    Type,
    Variable,
)
from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import argument_places, plan_pieces
from symbody.codegen.texts.layout import WHOLE
from symbody.expr import opcodes as op
from symbody.expr.sequence import Operation, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c", "out", "work")
_OPERATORS: Final = {
    op.NEG: "neg", op.ADD: "+", op.SUB: "-", op.MUL: "*", op.DIV: "/", op.SQRT: "sqrt", op.ABS: "abs",
    op.LT: "<", op.LE: "<=", op.EQ: "==", op.AND: "and", op.OR: "or", op.NOT: "not",
    op.TAN: "tan", op.ASIN: "asin", op.ACOS: "acos", op.ATAN: "atan", op.SINH: "sinh", op.COSH: "cosh",
    op.TANH: "tanh", op.EXP: "exp", op.LOG: "log", op.POW: "pow",
}  # fmt: skip


def sequence_kernels(sequence: Sequence, name: str) -> tuple[Mapping[str, KernelTree], int]:
    """Return a sequence as the kernel `name`, behind those that it calls, and its doubles of scratch.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    writer = _TreeWriter(sequence)
    body = writer.body()
    kernels: dict[str, KernelTree] = {}
    if "solve_saddle" in writer.called:
        kernels |= read_kernels("solve_saddle")
    if roots := sorted(writer.called - {"solve_saddle"}):
        kernels |= read_kernels("circular", *roots)
    parameters = [Parameter(group, Type.ARRAY, group in {"out", "work"}) for group in GROUPS]
    summary = f"Compute {sequence.output_size} numbers in {sequence.operation_count} operations."
    kernels[name] = KernelTree(name, parameters, Type.INTEGER, writer.variables, body, summary)
    return kernels, writer.work_size


class _TreeWriter:
    """Writes one sequence."""

    def __init__(self, sequence: Sequence) -> None:
        self.variables: dict[str, Type] = {}
        self.called: set[str] = set()
        self._sequence = sequence
        self._plan = plan_pieces(sequence, WHOLE)
        self._pair = self._plan.work_size  # where a sine and cosine go
        self.work_size = self._plan.work_size + 2
        self._values: dict[int, Expression] = {}
        self._circles: dict[int, tuple[Expression, Expression]] = {}  # of an argument
        self._body: list[Statement] = []

    def body(self) -> tuple[Statement, ...]:
        """Return the statements."""
        if self._plan.results:
            self.variables["fault"] = self.variables["status"] = Type.INTEGER
            self._body.append(Assign("fault", _whole(0)))
        for k, operation in enumerate(self._sequence.operations):
            if not self._plan.needed[k]:
                continue
            self._operation(k, operation)
            for place in self._plan.outputs.get(k, ()):
                self._body.append(StoreEntry(_array("out"), _whole(place), self._values[k]))
        fault = Variable("fault", Type.INTEGER) if self._plan.results else _whole(0)
        return (*self._body, Return(fault))

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            self._values[k] = Literal(self._plan.constants[k], Type.REAL)
        elif code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            self._values[k] = ArrayEntry(_array(source.group), _whole(source.position))
        elif code == op.PICK:
            self._values[k] = ArrayEntry(_array("work"), _whole(self._plan.results[operands[0]] + datum))
        elif code == op.SADDLE:
            self._saddle(k, operands, datum)
        elif code in (op.SIN, op.COS):
            self._values[k] = self._circle(operands[0])[code == op.COS]
        else:
            self._function(k, code, [self._values[j] for j in operands])

    def _function(self, k: int, code: int, values: list[Expression]) -> None:
        exponent = None
        if code == op.POW:
            exponent = integer_exponent(self._sequence, self._sequence.operations[k].operands[1])
        if code in op.CONDITIONS:  # read by choices alone, which write them out
            self._values[k] = Apply(_OPERATORS[code], tuple(values), Type.TRUTH)
        elif exponent is not None:
            names = values[:1]
            for first, second in power_products(exponent):
                product = _apply("*", names[first], names[second])
                names.append(self._define(f"z{k}_{len(names)}", product))
            self._values[k] = names[-1]
        elif code == op.SELECT:
            self._choose(k, values[0], values[1], values[2])
        elif code == op.SIGN:
            self._sign(k, values[0])
        else:
            self._values[k] = self._define(f"z{k}", self._formula(code, values))

    def _formula(self, code: int, values: list[Expression]) -> Expression:
        match code:
            case op.FMA:
                return _apply("+", _apply("*", values[0], values[1]), values[2])
            case op.MIN | op.MAX:  # the second where either is nan
                return _apply("min" if code == op.MIN else "max", values[1], values[0])
            case op.ATAN2:
                return _apply("atan2", _apply("+", values[0], Literal(0.0, Type.REAL)), values[1])
            case op.FLOOR:
                self.called.add("round_down")
                return Call("round_down", tuple(values), Type.REAL)
        return _apply(_OPERATORS[code], *values)

    def _define(self, name: str, value: Expression) -> Expression:
        self.variables[name] = Type.REAL
        self._body.append(Assign(name, value))
        return Variable(name, Type.REAL)

    def _choose(self, k: int, condition: Expression, then: Expression, otherwise: Expression) -> None:
        name = f"z{k}"
        self.variables[name] = Type.REAL
        self._body.append(Choose(condition, (Assign(name, then),), (Assign(name, otherwise),)))
        self._values[k] = Variable(name, Type.REAL)

    def _sign(self, k: int, value: Expression) -> None:
        zero = Literal(0.0, Type.REAL)
        self._values[k] = self._define(f"z{k}", _apply("+", value, zero))
        for test, sign in ((">", 1.0), ("<", -1.0)):
            condition = Apply(test, (value, zero), Type.TRUTH)
            self._body.append(Choose(condition, (Assign(f"z{k}", Literal(sign, Type.REAL)),), ()))

    def _circle(self, j: int) -> tuple[Expression, Expression]:
        if j not in self._circles:
            self.called.add("sine_cosine")
            pair = Part(_array("work"), _whole(self._pair), _whole(2))
            self._body.append(Perform(Call("sine_cosine", (self._values[j], pair), None)))
            sine, cosine = (
                self._define(f"{letter}{j}", ArrayEntry(_array("work"), _whole(self._pair + k)))
                for k, letter in enumerate("sc")
            )
            self._circles[j] = sine, cosine
        return self._circles[j]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        self.called.add("solve_saddle")
        plan, kernel = self._plan, self._sequence.kernels[datum]
        for place, operand in enumerate(operands, plan.arguments):
            self._body.append(StoreEntry(_array("work"), _whole(place), self._values[operand]))
        n, m = kernel.n, kernel.m
        places = (*argument_places(kernel, plan.arguments), plan.results[k], plan.scratch)
        sizes = (n * n, m * n, n, m, n + m + 1, plan.work_size - plan.scratch)
        parts = (
            Part(_array("work"), _whole(place), _whole(size))
            for place, size in zip(places, sizes, strict=True)
        )
        call = Call("solve_saddle", (_whole(n), _whole(m), *parts), Type.INTEGER)
        status, fault = Variable("status", Type.INTEGER), Variable("fault", Type.INTEGER)
        failed = Apply("!=", (status, _whole(0)), Type.TRUTH)
        is_first = Apply("==", (fault, _whole(0)), Type.TRUTH)
        self._body.append(Assign("status", call))
        self._body.append(
            Choose(Apply("and", (failed, is_first), Type.TRUTH), (Assign("fault", _whole(datum + 1)),), ())
        )


def _whole(value: int) -> Literal:
    return Literal(value, Type.INTEGER)


def _array(name: str) -> Variable:
    return Variable(name, Type.ARRAY)


def _apply(operator: str, *operands: Expression) -> Apply:
    return Apply(operator, operands, Type.REAL)
