"""Plain evaluation of a sequence: the reference that every generated language is tested against.

Floats follow IEEE 754 as compiled code does: nothing raises, 1/0 is infinite, log(-1) is not a
number. With `precise_numbers.MPMATH` the same sequence is evaluated at the precision mpmath is set to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

from symbody.expr import opcodes as op
from symbody.expr.graph import Constant, Graph
from symbody.expr.sequences.saddle import solve_saddle
from symbody.expr.sequences.sequence import Operation, Roots, Sequence, build_sequence

Number = Any  # float or mpmath.mpf; mpmath has no types

# Operations that are more than a function of numbers; an arithmetic's functions do not decide about them.
_APART: Final = frozenset({op.RATIONAL, op.FLOAT, op.PI, op.POW, op.PICK, op.SADDLE, op.MAP, op.CALL})


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """How numbers are made and functions computed.

    Attributes
    ----------
    constant : callable
        Turns an exact or rounded constant into a number.
    functions : mapping of operation code to callable
        Every operation but those on leaves, whole powers and kernels.
    sqrt : callable
        The root used inside the kernel.
    """

    constant: Callable[[Constant], Number]
    pi: Callable[[], Number]
    functions: Mapping[int, Callable[..., Number]]
    sqrt: Callable[[Number], Number]


def value_of(graph: Graph, root: int) -> float:
    """Return the value of a node without symbols."""
    sequence = build_sequence(graph, [Roots("value", (), (root,))], {})
    return float(evaluate_sequence(sequence, {})[0][0])


def evaluate_sequence(
    sequence: Sequence, inputs: Mapping[str, Items[Number]], arithmetic: Arithmetic | None = None
) -> list[list[Number]]:
    """Return the values of each output, row-major.

    Parameters
    ----------
    inputs : mapping of group to numbers
        For instance ``{"t": [0.0], "q": [0.1, 0.2]}``.
    arithmetic : Arithmetic, optional
        `FLOATS` by default, or `precise_numbers.MPMATH`.
    """
    rules = FLOATS if arithmetic is None else arithmetic
    values: list[Number] = []
    functions, symbols = rules.functions, sequence.inputs
    for operation in sequence.operations:
        code, operands, datum = operation
        if code == op.SYMBOL:
            symbol = symbols[datum]
            values.append(inputs[symbol.group][symbol.position])
        elif code in _APART:
            values.append(_value(sequence, operation, values, rules))
        else:
            values.append(functions[code](*[values[k] for k in operands]))
    return [[values[k] for k in output.values] for output in sequence.outputs]


def _value(
    sequence: Sequence,
    operation: Operation,
    values: list[Number],
    rules: Arithmetic,
) -> Number:
    """Return the value of an operation of `_APART`."""
    code, operands, datum = operation
    if code in (op.RATIONAL, op.FLOAT):
        return rules.constant(sequence.constants[datum])
    if code == op.PI:
        return rules.pi()
    arguments = [values[k] for k in operands]
    if code == op.POW:
        exponent = sequence.constant_value(operands[1])
        if isinstance(exponent, int) and exponent > 0:
            return integer_power(arguments[0], exponent)
    if code == op.PICK:
        return arguments[0][datum]
    if code == op.SADDLE:
        return _saddle(sequence, datum, arguments, rules)
    if code == op.MAP:
        return _run_program(sequence, operation, arguments, rules)
    if code == op.CALL:
        return sequence.functions[datum](*arguments)
    return rules.functions[code](*arguments)


def integer_power(base: Number, exponent: int) -> Number:
    """Return ``base ** exponent`` for a whole exponent >= 1, squaring from the lowest bit up.

    Every language multiplies in this order, so all give the same bits.
    """
    result = None
    while True:
        if exponent & 1:
            result = base if result is None else result * base
        exponent >>= 1
        if not exponent:
            return result
        base = base * base


def _saddle(sequence: Sequence, datum: int, arguments: list[Number], rules: Arithmetic) -> list[Number]:
    n, m = sequence.kernels[datum].n, sequence.kernels[datum].m
    ends = (n * n, n * n + m * n, n * n + m * n + n)
    mass, jacobian = arguments[: ends[0]], arguments[ends[0] : ends[1]]
    force, gamma = arguments[ends[1] : ends[2]], arguments[ends[2] :]
    solution = solve_saddle(mass, jacobian, force, gamma)
    return [*solution.udot, *solution.multipliers, rules.constant(solution.rank)]


def _run_program(
    sequence: Sequence, operation: Operation, arguments: list[Number], rules: Arithmetic
) -> list[Number]:
    program, count = sequence.programs[operation.datum], sequence.item_count(operation)
    shared = program.group_size("p")
    items = (
        evaluate_sequence(program, {"p": arguments[:shared], "q": arguments[shared + k :: count]}, rules)[0]
        for k in range(count)
    )
    return [value for values in zip(*items, strict=True) for value in values]


def _fma(a: float, b: float, c: float) -> float:
    """Return ``a*b + c`` rounded once."""
    if not (math.isfinite(a) and math.isfinite(b) and math.isfinite(c)):
        return a * b + c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0:
        return a * b + c  # the sign of zero
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def _divide(a: float, b: float) -> float:
    if b:
        return a / b
    return math.nan if a == 0 or a != a else math.copysign(math.inf, a) * math.copysign(1.0, b)


def _quiet(function: Callable[..., float]) -> Callable[..., float]:
    """Return `function` with what it raises replaced by what IEEE 754 returns."""

    def call(*arguments: float) -> float:
        try:
            return function(*arguments)
        except ValueError:  # outside the domain
            return -math.inf if function is math.log and arguments[0] == 0 else math.nan
        except OverflowError:
            odd = function is math.sinh and arguments[0] < 0
            return -math.inf if odd else math.inf

    return call


def _power(base: float, exponent: float) -> float:
    odd = exponent % 2 == 1
    try:
        return math.pow(base, exponent)
    except ValueError:
        if base != 0:
            return math.nan
        return math.copysign(math.inf, base) if odd else math.inf
    except OverflowError:
        return -math.inf if base < 0 and odd else math.inf


def _floor(x: float) -> float:
    if not math.isfinite(x):
        return x
    whole = float(math.floor(x))
    return whole if whole else math.copysign(0.0, x)


def sign(x: Number) -> int:
    """Return 1, 0 or -1."""
    return int(x > 0) - int(x < 0)


LOGIC: Final[dict[int, Callable[..., Number]]] = {
    op.NEG: lambda a: -a,
    op.ADD: lambda a, b: a + b,
    op.SUB: lambda a, b: a - b,
    op.MUL: lambda a, b: a * b,
    op.ABS: abs,
    op.MIN: lambda a, b: a if a < b or a != a else b,  # nan where either is, as for max
    op.MAX: lambda a, b: a if b < a or a != a else b,
    op.LT: lambda a, b: a < b,
    op.LE: lambda a, b: a <= b,
    op.EQ: lambda a, b: a == b,
    op.AND: lambda a, b: a and b,
    op.OR: lambda a, b: a or b,
    op.NOT: lambda a: not a,
    op.SELECT: lambda c, a, b: a if c else b,
}

NAMED: Final = {
    op.SIN: "sin", op.COS: "cos", op.TAN: "tan", op.ASIN: "asin", op.ACOS: "acos", op.ATAN: "atan",
    op.SINH: "sinh", op.COSH: "cosh", op.TANH: "tanh", op.EXP: "exp", op.LOG: "log", op.SQRT: "sqrt",
}  # fmt: skip

FLOATS: Final = Arithmetic(
    constant=float,
    pi=lambda: math.pi,
    functions=LOGIC
    | {code: _quiet(getattr(math, name)) for code, name in NAMED.items()}
    | {
        op.DIV: _divide,
        op.POW: _power,
        op.SIGN: lambda a: a if a != a else float(sign(a)),
        # Adding zero makes -0 positive: the angle of a point on the negative x axis is pi.
        op.ATAN2: lambda y, x: math.atan2(y + 0.0, x),
        op.FLOOR: _floor,
        op.FMA: _fma,
    },
    sqrt=math.sqrt,
)
