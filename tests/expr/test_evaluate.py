"""Evaluation: the same numbers as SymPy and mpmath, and the edges of IEEE 754."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from symbody.expr import opcodes as op
from symbody.expr.graph import Graph, KernelNode
from symbody.expr.rewrite import multiplications
from symbody.expr.sequences.evaluate import FLOATS, evaluate_sequence, integer_power
from symbody.expr.sequences.precise_numbers import MPMATH
from tests.expr.intervals import FLOAT_UNIT, Interval, Undecided, interval, interval_arithmetic
from tests.expr.strategies import (
    DIGITS,
    Sample,
    both_tiers,
    built,
    mpmath_values,
    samples,
    sequence_of,
    sympy_expression,
    sympy_value,
)

CHOICES = [(merge, contract) for merge in (True, False) for contract in (True, False)]


def bounds(sequence: Any, point: tuple[Fraction, ...], unit: Fraction) -> list[Interval]:
    """What the sequence can return at `point` in an arithmetic of roundoff `unit`, and its exact value."""
    inputs = {"q": [interval(x, unit) for x in point]}
    try:
        return list(evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0])
    except Undecided:
        assume(False)
        raise AssertionError from None


@both_tiers
@given(samples())
def test_floats_and_mpmath_agree_with_mpmath_alone(sample: Sample) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    with mpmath.workdps(DIGITS):
        exact = mpmath_values(
            sample.program, [mpmath.mpf(x.numerator) / x.denominator for x in sample.point]
        )[-1]
        for merge, contract in CHOICES:
            sequence = sequence_of(graph, [root], merge=merge, contract=contract)
            allowed = bounds(sequence, sample.point, FLOAT_UNIT)[0]
            assume(allowed.width < 1e-6)  # or the comparison would say nothing
            assert exact in allowed
            assert evaluate_sequence(sequence, {"q": [float(x) for x in sample.point]})[0][0] in allowed


@both_tiers
@given(samples())
def test_mpmath_agrees_with_sympy(sample: Sample) -> None:
    graph = Graph()
    sequence = sequence_of(graph, [built(sample.program, graph)[-1]])
    unit = Fraction(1, 10**49)
    with mpmath.workdps(DIGITS):
        allowed = bounds(sequence, sample.point, unit)[0]
        assume(allowed.width < 1e-40)
        point = [mpmath.mpf(x.numerator) / x.denominator for x in sample.point]
        with mpmath.workdps(50):
            value = evaluate_sequence(sequence, {"q": point}, MPMATH)[0][0]
        assert value in allowed
        assert sympy_value(sympy_expression(sample.program), sample.point) in allowed


def value(code: int, *operands: float) -> float:
    return float(FLOATS.functions[code](*operands))


@pytest.mark.parametrize(
    ("code", "operands", "expected"),
    [
        (op.DIV, (1.0, 0.0), math.inf),
        (op.DIV, (1.0, -0.0), -math.inf),
        (op.DIV, (-1.0, 0.0), -math.inf),
        (op.DIV, (0.0, 0.0), math.nan),
        (op.DIV, (math.nan, 0.0), math.nan),
        (op.LOG, (0.0,), -math.inf),
        (op.LOG, (-1.0,), math.nan),
        (op.SQRT, (-1.0,), math.nan),
        (op.ASIN, (1.5,), math.nan),
        (op.EXP, (1e3,), math.inf),
        (op.EXP, (-1e3,), 0.0),
        (op.SINH, (-1e3,), -math.inf),
        (op.COSH, (-1e3,), math.inf),
        (op.SIN, (math.inf,), math.nan),
        (op.POW, (-2.0, 0.5), math.nan),
        (op.POW, (0.0, -1.5), math.inf),
        (op.POW, (-0.0, -3.0), -math.inf),
        (op.POW, (-1e200, 3.0), -math.inf),
        (op.ATAN2, (0.0, -1.0), math.pi),
        (op.ATAN2, (-0.0, -1.0), math.pi),
        (op.SIGN, (-2.0,), -1.0),
        (op.SIGN, (0.0,), 0.0),
        (op.SIGN, (math.nan,), math.nan),
        (op.FLOOR, (-0.5,), -1.0),
        (op.FLOOR, (math.inf,), math.inf),
        (op.FMA, (0.1, 10.0, -1.0), 2.0**-54),  # 0.1 is above one tenth by 2**-54 / 10
        (op.FMA, (1e200, 1e200, -1.0), math.inf),
        (op.FMA, (math.inf, 1.0, -math.inf), math.nan),
    ],
)
def test_floats_follow_ieee_754(code: int, operands: tuple[float, ...], expected: float) -> None:
    result = value(code, *operands)
    assert math.isnan(result) if math.isnan(expected) else result == expected


@given(st.tuples(*[st.floats(-1e100, 1e100)] * 3))
def test_fma_rounds_once(operands: tuple[float, float, float]) -> None:
    a, b, c = map(Fraction, operands)
    assert value(op.FMA, *operands) == float(a * b + c)


class Power:
    """A power of x that notes every multiplication."""

    def __init__(self, exponent: int, made: list[tuple[int, int]]) -> None:
        self.exponent, self.made = exponent, made

    def __mul__(self, other: Power) -> Power:
        self.made.append((self.exponent, other.exponent))
        return Power(self.exponent + other.exponent, self.made)


@given(st.integers(1, 64))
def test_whole_powers_are_made_by_squaring(exponent: int) -> None:
    made: list[tuple[int, int]] = []
    assert integer_power(Power(1, made), exponent).exponent == exponent
    assert len(made) == multiplications(exponent)


def test_whole_powers_square_from_the_lowest_bit() -> None:
    made: list[tuple[int, int]] = []
    integer_power(Power(1, made), 11)
    assert made == [(1, 1), (1, 2), (2, 2), (4, 4), (3, 8)]


def test_values_of_a_kernel_are_picked() -> None:
    """M a = F + J^T lambda, J a = 0 for two unit masses tied together: a = 1/2 each, lambda = -1/2."""
    graph = Graph()
    numbers = [graph.constant(k) for k in (1, 0, 0, 1, 1, -1, 1, 0, 0)]
    kernel = graph.kernel(KernelNode(2, 1))
    saddle = graph.many(op.SADDLE, tuple(numbers), kernel)
    sequence = sequence_of(graph, [graph.node(op.PICK, saddle, k) for k in range(4)])
    # 10 roundings of numbers of size 1 or less
    assert evaluate_sequence(sequence, {})[0] == pytest.approx([0.5, 0.5, -0.5, 1.0], abs=10 * 2.0**-53)
