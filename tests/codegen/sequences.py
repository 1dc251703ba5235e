"""Random sequences that stay in a sane range, with the inputs at which they do."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence as Items
from fractions import Fraction
from typing import Any

from symbody.expr import opcodes as op
from symbody.expr.graph import Constant
from symbody.expr.sequences.evaluate import FLOATS, integer_power
from symbody.expr.sequences.saddle import solve_saddle
from symbody.expr.sequences.sequence import Input, KernelNode, Operation, Output, Sequence

GROUPS = {"t": 1, "q": 7, "u": 6, "r": 2, "p": 9, "c": 3}

ARITHMETIC = (op.ADD, op.SUB, op.MUL, op.DIV, op.NEG, op.SQRT, op.POW, op.ADD, op.SUB, op.MUL, op.MUL)
EXACT = (*ARITHMETIC, op.ABS, op.SIGN, op.FLOOR, op.MIN, op.MAX, op.SELECT, op.FMA, op.SADDLE)
LIBRARY = (
    op.TAN, op.ASIN, op.ACOS, op.ATAN, op.SINH, op.COSH, op.TANH, op.EXP, op.LOG, op.ATAN2,
)  # fmt: skip
TRIGONOMETRIC = (op.SIN, op.COS)
MECHANICAL = (*(op.MUL,) * 12, *(op.ADD,) * 9, *(op.SUB,) * 5, op.NEG, op.DIV, op.FMA)

Inputs = dict[str, list[float]]


class Maker:
    """Grows a sequence, keeping every value at the inputs between 1e-3 and 1e3 in size, or 0."""

    def __init__(self, seed: int, window: int = 60) -> None:
        self.random = random.Random(seed)
        self.window = window
        self.inputs: Inputs = {
            group: [self.random.uniform(-2.0, 2.0) for _ in range(size)] for group, size in GROUPS.items()
        }
        self.sources = [Input(f"{group}{k}", group, k) for group, size in GROUPS.items() for k in range(size)]
        self.constants: list[Constant] = []
        self.kernels: list[KernelNode] = []
        self.operations: list[Operation] = []
        self.values: list[Any] = []  # numbers, truth values, results of kernels
        self.reals: list[int] = []
        self.conditions: list[int] = []
        for k, source in enumerate(self.sources):
            self.add(Operation(op.SYMBOL, (), k), self.inputs[source.group][source.position])
        self.add(Operation(op.PI, ()), math.pi)

    def add(self, operation: Operation, value: Any, *, hidden: bool = False) -> int:
        """Append an operation; a hidden value becomes no operand of others."""
        self.operations.append(operation)
        self.values.append(value)
        number = len(self.operations) - 1
        if operation.op in op.CONDITIONS:
            self.conditions.append(number)
        elif operation.op != op.SADDLE and not hidden:
            self.reals.append(number)
        return number

    def real(self) -> int:
        """Pick an operand: mostly a recent one."""
        if self.random.random() < 0.12:
            return self.random.choice(self.reals)
        return self.random.choice(self.reals[-self.window :])

    def constant(self, value: Constant) -> int:
        self.constants.append(value)
        code = op.FLOAT if isinstance(value, float) else op.RATIONAL
        return self.add(Operation(code, (), len(self.constants) - 1), float(value))

    def some_constant(self) -> int:
        sign = self.random.choice((1, -1))
        whole = self.random.randint(1, 9)
        choices = (
            sign * whole,
            sign * Fraction(whole, self.random.randint(2, 30)),
            sign * self.random.random(),
        )
        return self.constant(self.random.choice(choices))

    def grow(self, code: int) -> None:
        if code == op.SADDLE:
            self.kernel(self.random.randint(1, 4), self.random.randint(0, 3))
        elif code == op.POW:
            self.power()
        elif code == op.SELECT:
            self.choice()
        else:
            self.plain(code)

    def plain(self, code: int) -> None:
        count = {op.FMA: 3}.get(code, op.ARITY[code])
        operands = tuple(self.real() for _ in range(count))
        value = FLOATS.functions[code](*(self.values[k] for k in operands))
        if value == 0 or 1e-3 < abs(value) < 1e3:
            self.add(Operation(code, operands), value)

    def power(self) -> None:
        base = self.real()
        if self.random.random() < 0.7:
            exponent: int = self.random.randint(1, 11)
            value = integer_power(self.values[base], exponent)
            number = self.constant(exponent)
        else:
            number = self.constant(self.random.uniform(-3.0, 3.0))
            value = FLOATS.functions[op.POW](self.values[base], self.values[number])
        if 1e-3 < abs(value) < 1e3:
            self.add(Operation(op.POW, (base, number)), value)

    def choice(self) -> None:
        code = self.random.choice((op.LT, op.LE, op.EQ))
        condition = self.condition(code, self.real(), self.real())
        if len(self.conditions) > 2:
            code = self.random.choice((op.AND, op.OR))
            condition = self.condition(code, condition, self.random.choice(self.conditions))
            condition = self.condition(op.NOT, condition)
        operands = (condition, self.real(), self.real())
        self.add(
            Operation(op.SELECT, operands), FLOATS.functions[op.SELECT](*(self.values[k] for k in operands))
        )

    def condition(self, code: int, *operands: int) -> int:
        return self.add(
            Operation(code, operands), FLOATS.functions[code](*(self.values[k] for k in operands))
        )

    def kernel(self, n: int, m: int) -> None:
        """Add a solvable system: M = diag(1 + x**2) and random rows."""
        one, zero = self.constant(1), self.constant(0)
        mass = [zero] * (n * n)
        for k in range(n):
            x = self.real()
            square = self.add(Operation(op.MUL, (x, x)), self.values[x] * self.values[x], hidden=True)
            mass[k * n + k] = self.add(
                Operation(op.ADD, (one, square)), 1.0 + self.values[square], hidden=True
            )
        rest = [self.real() for _ in range(m * n + n + m)]
        operands = [*mass, *rest]
        numbers = [self.values[k] for k in operands]
        ends = (n * n, n * n + m * n, n * n + m * n + n)
        solution = solve_saddle(
            numbers[: ends[0]], numbers[ends[0] : ends[1]], numbers[ends[1] : ends[2]], numbers[ends[2] :]
        )
        result = [*solution.udot, *solution.multipliers, float(solution.rank)]
        self.kernels.append(KernelNode(n, m))
        node = self.add(Operation(op.SADDLE, tuple(operands), len(self.kernels) - 1), result)
        for k, value in enumerate(result):
            if value == 0 or 1e-3 < abs(value) < 1e3:
                self.add(Operation(op.PICK, (node,), k), value)

    def finish(self) -> Sequence:
        """Return the sequence: its outputs are all values nothing else reads, and three others."""
        read = {k for operation in self.operations for k in operation.operands}
        ends = [k for k in self.reals if k not in read]
        some = self.random.choices(self.reals, k=6)
        return Sequence(
            tuple(self.sources), tuple(self.constants), tuple(self.kernels), (), tuple(self.operations),
            (Output("some", (2, 3), tuple(some)), Output("ends", (len(ends),), tuple(ends))),
        )  # fmt: skip


def random_sequence(seed: int, count: int, codes: Items[int], window: int = 60) -> tuple[Sequence, Inputs]:
    """Return a sequence of at least `count` operations drawn from `codes`, and its inputs."""
    maker = Maker(seed, window)
    while len(maker.operations) < count:
        if maker.random.random() < 0.03:
            maker.some_constant()
        maker.grow(maker.random.choice(codes))
    return maker.finish(), maker.inputs


def single(code: int, count: int, *constants: Constant) -> Sequence:
    """Return the sequence of one operation whose operands are q[0], q[1], ... and then `constants`."""
    operations = [Operation(op.SYMBOL, (), k) for k in range(count)]
    for k, value in enumerate(constants):
        operations.append(Operation(op.FLOAT if isinstance(value, float) else op.RATIONAL, (), k))
    operations.append(Operation(code, tuple(range(len(operations)))))
    inputs = tuple(Input(f"x{k}", "q", k) for k in range(count))
    output = Output("y", (), (len(operations) - 1,))
    return Sequence(inputs, constants, (), (), tuple(operations), (output,))


def same_bits(ours: Items[float], theirs: Items[float]) -> bool:
    """Tell whether all numbers are the same, nan being nan of any kind."""
    return len(ours) == len(theirs) and all(
        (a != a and b != b) or (a == b and math.copysign(1.0, a) == math.copysign(1.0, b))
        for a, b in zip(ours, theirs, strict=True)
    )
