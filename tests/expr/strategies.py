"""Random expressions as programs that any engine can run: the graph, SymPy, mpmath.

A program is a list of steps over earlier steps, so subexpressions are shared. Each is drawn together with a
point at which every value is tame: far from poles, edges of domains and overflow. A step that would not be
becomes the sine of its operand, so nothing has to be thrown away.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from collections.abc import Sequence as Items
from fractions import Fraction
from typing import Any, NamedTuple

import mpmath
import pytest
import sympy as sp
from hypothesis import strategies as st

from symbody.expr import opcodes as op
from symbody.expr.canonical import make
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence

both_tiers = pytest.mark.usefixtures("tier")

NAMES = ("x", "y", "z")
SYMBOLS = tuple(Symbol(name, SymbolKind.COORDINATE) for name in NAMES)
SYMPY_SYMBOLS = sp.symbols(NAMES, real=True)
DIGITS = 80  # of the oracles

ARITHMETIC = (op.NEG, op.ADD, op.SUB, op.MUL, op.DIV, op.POW)
SMOOTH = (
    *ARITHMETIC, op.SIN, op.COS, op.TAN, op.ASIN, op.ACOS, op.ATAN, op.SINH, op.COSH, op.TANH, op.EXP, op.LOG,
    op.SQRT, op.ATAN2,
)  # fmt: skip
KINKED = (op.ABS, op.MIN, op.MAX, op.SIGN, op.FLOOR, op.SELECT)
EVERY = SMOOTH + KINKED


class Step(NamedTuple):
    """One value: a symbol, a number, or an operation on earlier steps.

    A power has a number for exponent, and a choice compares its first two operands by "less than".
    """

    op: int
    operands: tuple[int, ...] = ()
    number: Fraction = Fraction(0)


Program = tuple[Step, ...]


class Sample(NamedTuple):
    """A program whose last step is the result, and a point at which all its values are tame."""

    program: Program
    point: tuple[Fraction, ...]


@st.composite
def samples(draw: st.DrawFn, ops: Items[int] = EVERY, steps: int = 12) -> Sample:
    point = tuple(Fraction(draw(st.integers(-128, 128)), 64) for _ in NAMES)  # floats hold these
    return Sample(draw(_programs(ops, steps, [exact(x) for x in point])), point)


@st.composite
def compositions(draw: st.DrawFn) -> tuple[Sample, Program]:
    """Return an inner sample, and a program that is tame with its result in the place of x."""
    inner = draw(samples(steps=6))
    with mpmath.workdps(DIGITS):
        result = mpmath_values(inner.program, [exact(x) for x in inner.point])[-1]
        return inner, draw(_programs(EVERY, 6, [result, *(exact(x) for x in inner.point[1:])]))


@st.composite
def _programs(draw: st.DrawFn, ops: Items[int], steps: int, point: Items[Any]) -> Program:
    program = [Step(op.SYMBOL, (), Fraction(k)) for k in range(len(NAMES))]
    with mpmath.workdps(DIGITS):
        values = list(point)
        for _ in range(draw(st.integers(1, steps))):
            step = draw(_steps(ops, len(values)))
            if not is_tame(step, values):
                step = Step(op.SIN, step.operands[:1])
            program.append(step)
            values.append(mpmath_value(step, values))
    return tuple(program)


@st.composite
def _steps(draw: st.DrawFn, ops: Items[int], count: int) -> Step:
    place = st.integers(0, count - 1)
    if draw(st.integers(0, 5)) == 0:
        return Step(op.RATIONAL, (), draw(st.fractions(-5, 5, max_denominator=6)))
    code = draw(st.sampled_from(ops))
    if code == op.POW:
        exponents = st.one_of(
            st.integers(2, 4), st.sampled_from([Fraction(1, 2), Fraction(1, 3), Fraction(-3, 2), -1])
        )
        return Step(code, (draw(place),), Fraction(draw(exponents)))
    arity = 4 if code == op.SELECT else op.ARITY[code]
    return Step(code, tuple(draw(place) for _ in range(arity)))


def is_tame(step: Step, values: Items[Any]) -> bool:
    """Tell whether the step has a moderate value, away from where it or its derivative is undefined."""
    a = [values[k] for k in step.operands]
    edges: dict[int, Callable[[], bool]] = {
        op.DIV: lambda: abs(a[1]) > 0.02,
        op.POW: lambda: a[0] > 0.02 or (step.number > 0 and step.number.denominator == 1),
        op.TAN: lambda: abs(mpmath.cos(a[0])) > 0.05,
        op.ASIN: lambda: abs(a[0]) < 0.98,
        op.ACOS: lambda: abs(a[0]) < 0.98,
        op.SINH: lambda: abs(a[0]) < 5,
        op.COSH: lambda: abs(a[0]) < 5,
        op.EXP: lambda: abs(a[0]) < 5,
        op.LOG: lambda: a[0] > 0.02,
        op.SQRT: lambda: a[0] > 0.02,
        # away from the negative x axis, where the angle jumps
        op.ATAN2: lambda: abs(a[0]) + abs(a[1]) > 0.02 and (a[1] > 0 or abs(a[0]) > 0.02),
        op.ABS: lambda: abs(a[0]) > 0.02,
        op.SIGN: lambda: abs(a[0]) > 0.02,
        op.FLOOR: lambda: abs(a[0] - mpmath.nint(a[0])) > 0.02,
        op.MIN: lambda: abs(a[0] - a[1]) > 0.02,
        op.MAX: lambda: abs(a[0] - a[1]) > 0.02,
        op.SELECT: lambda: abs(a[0] - a[1]) > 0.02,
    }
    inside = edges.get(step.op)
    return (inside is None or inside()) and abs(mpmath_value(step, values)) < 200


def exact(value: Fraction) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


_MPMATH: Mapping[int, Callable[..., Any]] = {
    op.NEG: lambda a: -a, op.ADD: lambda a, b: a + b, op.SUB: lambda a, b: a - b, op.MUL: lambda a, b: a * b,
    op.DIV: lambda a, b: a / b, op.SIN: mpmath.sin, op.COS: mpmath.cos, op.TAN: mpmath.tan, op.ASIN: mpmath.asin,
    op.ACOS: mpmath.acos, op.ATAN: mpmath.atan, op.SINH: mpmath.sinh, op.COSH: mpmath.cosh, op.TANH: mpmath.tanh,
    op.EXP: mpmath.exp, op.LOG: mpmath.log, op.SQRT: mpmath.sqrt, op.ATAN2: mpmath.atan2, op.ABS: abs, op.MIN: min,
    op.MAX: max, op.SIGN: mpmath.sign, op.FLOOR: mpmath.floor, op.SELECT: lambda a, b, c, d: c if a < b else d,
}  # fmt: skip

_SYMPY: Mapping[int, Callable[..., Any]] = {
    **{code: _MPMATH[code] for code in (op.NEG, op.ADD, op.SUB, op.MUL, op.DIV)},
    op.SIN: sp.sin, op.COS: sp.cos, op.TAN: sp.tan, op.ASIN: sp.asin, op.ACOS: sp.acos, op.ATAN: sp.atan,
    op.SINH: sp.sinh, op.COSH: sp.cosh, op.TANH: sp.tanh, op.EXP: sp.exp, op.LOG: sp.log, op.SQRT: sp.sqrt,
    op.ATAN2: sp.atan2, op.ABS: sp.Abs, op.MIN: sp.Min, op.MAX: sp.Max, op.SIGN: sp.sign, op.FLOOR: sp.floor,
    op.SELECT: lambda a, b, c, d: sp.Piecewise((c, a < b), (d, True)),
}  # fmt: skip


def mpmath_value(step: Step, values: Items[Any]) -> Any:
    """Return the value of one step, by mpmath alone."""
    if step.op == op.RATIONAL:
        return exact(step.number)
    a = [values[k] for k in step.operands]
    return mpmath.power(a[0], exact(step.number)) if step.op == op.POW else _MPMATH[step.op](*a)


def mpmath_values(program: Program, point: Items[Any]) -> list[Any]:
    """Return the value of every step at the precision of mpmath."""
    values: list[Any] = []
    for step in program:
        values.append(point[int(step.number)] if step.op == op.SYMBOL else mpmath_value(step, values))
    return values


def sympy_expression(program: Program) -> sp.Expr:
    """Return the result as a SymPy expression of `SYMPY_SYMBOLS`, by SymPy alone."""
    values: list[sp.Expr] = []
    for step in program:
        number = sp.Rational(step.number.numerator, step.number.denominator)
        a = [values[k] for k in step.operands]
        if step.op == op.SYMBOL:
            values.append(SYMPY_SYMBOLS[int(step.number)])
        elif step.op == op.RATIONAL:
            values.append(number)
        else:
            values.append(a[0] ** number if step.op == op.POW else _SYMPY[step.op](*a))
    return values[-1]


def sympy_value(expression: sp.Expr, point: Items[Fraction]) -> Any:
    """Return the value of an expression of `SYMPY_SYMBOLS` to `DIGITS` digits."""
    numbers = [sp.Rational(x.numerator, x.denominator) for x in point]
    value = expression.subs(dict(zip(SYMPY_SYMBOLS, numbers, strict=True))).evalf(DIGITS)
    with mpmath.workdps(DIGITS):
        return mpmath.mpf(sp.Float(value, DIGITS)._mpf_)


def built(program: Program, graph: Graph) -> list[int]:
    """Return the node of every step, made in the order of the steps."""
    nodes: list[int] = []
    for step in program:
        nodes.append(_node(step, [nodes[k] for k in step.operands], graph))
    return nodes


def built_shuffled(program: Program, graph: Graph, rng: random.Random) -> int:
    """Return the node of the last step, made in a random order among others, sums and products turned round."""
    nodes: dict[int, int] = {}
    waiting = list(range(len(program)))
    while waiting:
        ready = [k for k in waiting if all(j in nodes for j in program[k].operands)]
        k = rng.choice(ready)
        operands = [nodes[j] for j in program[k].operands]
        if program[k].op in (op.ADD, op.MUL, op.MIN, op.MAX) and rng.random() < 0.5:
            operands.reverse()
        nodes[k] = _node(program[k], operands, graph)
        waiting.remove(k)
        graph.symbol(Symbol(f"other {rng.random()}"))
    return nodes[len(program) - 1]


def _node(step: Step, operands: list[int], graph: Graph) -> int:
    if step.op == op.SYMBOL:
        return graph.symbol(SYMBOLS[int(step.number)])
    if step.op == op.RATIONAL:
        return graph.constant(step.number)
    if step.op == op.POW:
        operands = [*operands, graph.constant(step.number)]
    if step.op == op.SELECT:
        condition = make(graph, op.LT, (operands[0], operands[1]))
        operands = [condition, operands[2], operands[3]]
    return make(graph, step.op, tuple(operands))


def sequence_of(graph: Graph, nodes: Items[int], *, merge: bool = True, contract: bool = True) -> Sequence:
    """Return the sequence of `nodes`, reading `SYMBOLS` and their rates from the groups q and u."""
    inputs = {}
    for k, symbol in enumerate(SYMBOLS):
        inputs[graph.symbol(symbol)] = Input(symbol.label, "q", k)
        inputs[graph.symbol(symbol.derivative)] = Input(symbol.derivative.label, "u", k)
    return build_sequence(
        graph, [Roots("f", (len(nodes),), tuple(nodes))], inputs, merge=merge, contract=contract
    )
