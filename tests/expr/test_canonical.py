"""The canonical form: one test for each fold, one for each thing that is never folded, and its laws."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, make, mul, neg, power, select, sub
from symbody.expr.graph import Graph, Symbol, copy_nodes
from tests.expr.strategies import Sample, both_tiers, built, built_shuffled, samples


class Pen:
    """Writes expressions in a graph of its own."""

    def __init__(self) -> None:
        self.g = Graph()
        self.x, self.y, self.z = (self.g.symbol(Symbol(name)) for name in "xyz")

    def c(self, value: int | Fraction | float) -> int:
        return self.g.constant(value)

    def __call__(self, code: int, *operands: int) -> int:
        return make(self.g, code, operands)


Rule = Callable[[Pen], int]

EQUAL: dict[str, tuple[Rule, Rule]] = {
    "0*x": (lambda p: mul(p.g, ZERO, p.x), lambda p: ZERO),
    "1*x": (lambda p: mul(p.g, ONE, p.x), lambda p: p.x),
    "x+0": (lambda p: add(p.g, p.x, ZERO), lambda p: p.x),
    "x-0": (lambda p: sub(p.g, p.x, ZERO), lambda p: p.x),
    "0-x": (lambda p: sub(p.g, ZERO, p.x), lambda p: neg(p.g, p.x)),
    "--x": (lambda p: neg(p.g, neg(p.g, p.x)), lambda p: p.x),
    "-0": (lambda p: neg(p.g, ZERO), lambda p: ZERO),
    "x+x": (lambda p: add(p.g, p.x, p.x), lambda p: mul(p.g, TWO, p.x)),
    "x-x": (lambda p: sub(p.g, p.x, p.x), lambda p: ZERO),
    "x+(-x)": (lambda p: add(p.g, p.x, neg(p.g, p.x)), lambda p: ZERO),
    "2x+3x": (
        lambda p: add(p.g, mul(p.g, TWO, p.x), mul(p.g, p.c(3), p.x)),
        lambda p: mul(p.g, p.c(5), p.x),
    ),
    "3x+3x": (
        lambda p: add(p.g, mul(p.g, p.c(3), p.x), mul(p.g, p.c(3), p.x)),
        lambda p: mul(p.g, p.c(6), p.x),
    ),
    "2x-2x": (lambda p: sub(p.g, mul(p.g, TWO, p.x), mul(p.g, TWO, p.x)), lambda p: ZERO),
    "2x-x": (lambda p: sub(p.g, mul(p.g, TWO, p.x), p.x), lambda p: p.x),
    "x+(-y)": (lambda p: add(p.g, p.x, neg(p.g, p.y)), lambda p: sub(p.g, p.x, p.y)),
    "x-(-y)": (lambda p: sub(p.g, p.x, neg(p.g, p.y)), lambda p: add(p.g, p.x, p.y)),
    "-(x-y)": (lambda p: neg(p.g, sub(p.g, p.x, p.y)), lambda p: sub(p.g, p.y, p.x)),
    "-x-y": (lambda p: sub(p.g, neg(p.g, p.x), p.y), lambda p: neg(p.g, add(p.g, p.x, p.y))),
    "x+y": (lambda p: add(p.g, p.x, p.y), lambda p: add(p.g, p.y, p.x)),
    "x*y": (lambda p: mul(p.g, p.x, p.y), lambda p: mul(p.g, p.y, p.x)),
    "(-x)*y": (lambda p: mul(p.g, neg(p.g, p.x), p.y), lambda p: neg(p.g, mul(p.g, p.x, p.y))),
    "(-x)*(-y)": (lambda p: mul(p.g, neg(p.g, p.x), neg(p.g, p.y)), lambda p: mul(p.g, p.x, p.y)),
    "2*(3*x)": (lambda p: mul(p.g, TWO, mul(p.g, p.c(3), p.x)), lambda p: mul(p.g, p.c(6), p.x)),
    "2+(3+x)": (lambda p: add(p.g, TWO, add(p.g, p.c(3), p.x)), lambda p: add(p.g, p.c(5), p.x)),
    "2-(3-x)": (lambda p: sub(p.g, TWO, sub(p.g, p.c(3), p.x)), lambda p: sub(p.g, p.x, ONE)),
    "x*x": (lambda p: mul(p.g, p.x, p.x), lambda p: power(p.g, p.x, TWO)),
    "x^2*x^3": (
        lambda p: mul(p.g, power(p.g, p.x, TWO), power(p.g, p.x, p.c(3))),
        lambda p: power(p.g, p.x, p.c(5)),
    ),
    "(x^2)^3": (lambda p: power(p.g, power(p.g, p.x, TWO), p.c(3)), lambda p: power(p.g, p.x, p.c(6))),
    "x^0": (lambda p: power(p.g, p.x, ZERO), lambda p: ONE),
    "x^1": (lambda p: power(p.g, p.x, ONE), lambda p: p.x),
    "x^2.0": (lambda p: power(p.g, p.x, p.c(2.0)), lambda p: power(p.g, p.x, TWO)),
    "x^-2": (lambda p: power(p.g, p.x, p.c(-2)), lambda p: div(p.g, ONE, power(p.g, p.x, TWO))),
    "(-x)^2": (lambda p: power(p.g, neg(p.g, p.x), TWO), lambda p: power(p.g, p.x, TWO)),
    "(-x)^3": (lambda p: power(p.g, neg(p.g, p.x), p.c(3)), lambda p: neg(p.g, power(p.g, p.x, p.c(3)))),
    "x^(1/2)": (lambda p: power(p.g, p.x, p.c(Fraction(1, 2))), lambda p: p(op.SQRT, p.x)),
    "x^(-1/2)": (lambda p: power(p.g, p.x, p.c(Fraction(-1, 2))), lambda p: div(p.g, ONE, p(op.SQRT, p.x))),
    "1^x": (lambda p: power(p.g, ONE, p.x), lambda p: ONE),
    "sqrt(x)^2": (lambda p: power(p.g, p(op.SQRT, p.x), TWO), lambda p: p.x),
    "sqrt(x)*sqrt(x)": (lambda p: mul(p.g, p(op.SQRT, p.x), p(op.SQRT, p.x)), lambda p: p.x),
    "sqrt(x)^3": (lambda p: power(p.g, p(op.SQRT, p.x), p.c(3)), lambda p: mul(p.g, p.x, p(op.SQRT, p.x))),
    "x/1": (lambda p: div(p.g, p.x, ONE), lambda p: p.x),
    "x/2": (lambda p: div(p.g, p.x, TWO), lambda p: mul(p.g, p.c(Fraction(1, 2)), p.x)),
    "0/x": (lambda p: div(p.g, ZERO, p.x), lambda p: ZERO),
    "(-x)/y": (lambda p: div(p.g, neg(p.g, p.x), p.y), lambda p: neg(p.g, div(p.g, p.x, p.y))),
    "x/(-y)": (lambda p: div(p.g, p.x, neg(p.g, p.y)), lambda p: neg(p.g, div(p.g, p.x, p.y))),
    "sin(-x)": (lambda p: p(op.SIN, neg(p.g, p.x)), lambda p: neg(p.g, p(op.SIN, p.x))),
    "sin(x-y)": (lambda p: p(op.SIN, sub(p.g, p.x, p.y)), lambda p: neg(p.g, p(op.SIN, sub(p.g, p.y, p.x)))),
    "cos(-x)": (lambda p: p(op.COS, neg(p.g, p.x)), lambda p: p(op.COS, p.x)),
    "cosh(-x)": (lambda p: p(op.COSH, neg(p.g, p.x)), lambda p: p(op.COSH, p.x)),
    "atan(-x)": (lambda p: p(op.ATAN, neg(p.g, p.x)), lambda p: neg(p.g, p(op.ATAN, p.x))),
    "sign(-x)": (lambda p: p(op.SIGN, neg(p.g, p.x)), lambda p: neg(p.g, p(op.SIGN, p.x))),
    "abs(-x)": (lambda p: p(op.ABS, neg(p.g, p.x)), lambda p: p(op.ABS, p.x)),
    "abs(abs(x))": (lambda p: p(op.ABS, p(op.ABS, p.x)), lambda p: p(op.ABS, p.x)),
    "abs(sqrt(x))": (lambda p: p(op.ABS, p(op.SQRT, p.x)), lambda p: p(op.SQRT, p.x)),
    "min(x,x)": (lambda p: p(op.MIN, p.x, p.x), lambda p: p.x),
    "max(x,y)": (lambda p: p(op.MAX, p.x, p.y), lambda p: p(op.MAX, p.y, p.x)),
    "min(2,3)": (lambda p: p(op.MIN, p.c(3), TWO), lambda p: TWO),
    "1<2": (lambda p: p(op.LT, ONE, TWO), lambda p: ONE),
    "2<=2": (lambda p: p(op.LE, TWO, TWO), lambda p: ONE),
    "1=2": (lambda p: p(op.EQ, ONE, TWO), lambda p: ZERO),
    "x<x": (lambda p: p(op.LT, p.x, p.x), lambda p: ZERO),
    "not not": (lambda p: p(op.NOT, p(op.NOT, p(op.LT, p.x, p.y))), lambda p: p(op.LT, p.x, p.y)),
    "false and": (lambda p: p(op.AND, p(op.LT, p.x, p.y), ZERO), lambda p: ZERO),
    "true and": (lambda p: p(op.AND, ONE, p(op.LT, p.x, p.y)), lambda p: p(op.LT, p.x, p.y)),
    "true or": (lambda p: p(op.OR, p(op.LT, p.x, p.y), ONE), lambda p: ONE),
    "c and c": (lambda p: p(op.AND, p(op.LT, p.x, p.y), p(op.LT, p.x, p.y)), lambda p: p(op.LT, p.x, p.y)),
    "if(true)": (lambda p: select(p.g, ONE, p.x, p.y), lambda p: p.x),
    "if(false)": (lambda p: select(p.g, ZERO, p.x, p.y), lambda p: p.y),
    "if(c,x,x)": (lambda p: select(p.g, p(op.LT, p.x, p.y), p.x, p.x), lambda p: p.x),
    "if(not c)": (
        lambda p: select(p.g, p(op.NOT, p(op.LT, p.x, p.y)), p.x, p.y),
        lambda p: select(p.g, p(op.LT, p.x, p.y), p.y, p.x),
    ),
}


@pytest.mark.parametrize("name", EQUAL)
def test_folds(name: str) -> None:
    pen = Pen()
    left, right = EQUAL[name]
    assert left(pen) == right(pen)


# Each is made of the operation named, on the operands given, however tempting a rule may be.
KEPT: dict[str, tuple[Rule, int]] = {
    "x/x, which 0 may undo": (lambda p: div(p.g, p.x, p.x), op.DIV),
    "sqrt(x^2), which is not x": (lambda p: p(op.SQRT, power(p.g, p.x, TWO)), op.SQRT),
    "x*(y+z) is not multiplied out": (lambda p: mul(p.g, p.x, add(p.g, p.y, p.z)), op.MUL),
    "x*y+x*z is not collected": (lambda p: add(p.g, mul(p.g, p.x, p.y), mul(p.g, p.x, p.z)), op.ADD),
    "2*(x+y) is not multiplied out": (lambda p: mul(p.g, TWO, add(p.g, p.x, p.y)), op.MUL),
    "(x+y)^2 is not multiplied out": (lambda p: power(p.g, add(p.g, p.x, p.y), TWO), op.POW),
    "(x*y)^2 is not distributed": (lambda p: power(p.g, mul(p.g, p.x, p.y), TWO), op.POW),
    "1.0*x keeps its rounding": (lambda p: mul(p.g, p.c(1.0), p.x), op.MUL),
    "0.0*x may be a NaN": (lambda p: mul(p.g, p.c(0.0), p.x), op.MUL),
    "x+0.0 keeps its rounding": (lambda p: add(p.g, p.x, p.c(0.0)), op.ADD),
    "0.1+(0.2+x)": (lambda p: add(p.g, p.c(0.1), add(p.g, p.c(0.2), p.x)), op.ADD),
    "0.1*(0.2*x)": (lambda p: mul(p.g, p.c(0.1), mul(p.g, p.c(0.2), p.x)), op.MUL),
    "0.1*x+0.2*x": (lambda p: add(p.g, mul(p.g, p.c(0.1), p.x), mul(p.g, p.c(0.2), p.x)), op.ADD),
    "2*(0.1*x)": (lambda p: mul(p.g, TWO, mul(p.g, p.c(0.1), p.x)), op.MUL),
    "x/0.1": (lambda p: div(p.g, p.x, p.c(0.1)), op.DIV),
    "exp(log(x))": (lambda p: p(op.EXP, p(op.LOG, p.x)), op.EXP),
    "log(exp(x))": (lambda p: p(op.LOG, p(op.EXP, p.x)), op.LOG),
    "exp(x)*exp(y)": (lambda p: mul(p.g, p(op.EXP, p.x), p(op.EXP, p.y)), op.MUL),
    "log(x)+log(y)": (lambda p: add(p.g, p(op.LOG, p.x), p(op.LOG, p.y)), op.ADD),
    "asin(sin(x))": (lambda p: p(op.ASIN, p(op.SIN, p.x)), op.ASIN),
    "sin(x)^2+cos(x)^2": (
        lambda p: add(p.g, power(p.g, p(op.SIN, p.x), TWO), power(p.g, p(op.COS, p.x), TWO)),
        op.ADD,
    ),
    "sin(3), which is not rational": (lambda p: p(op.SIN, p.c(3)), op.SIN),
    "atan2(x,y) has an order": (lambda p: p(op.ATAN2, p.x, p.y), op.ATAN2),
    "x<=x is false for a NaN": (lambda p: p(op.LE, p.x, p.x), op.LE),
    "(x^(1/3))^3": (lambda p: power(p.g, power(p.g, p.x, p.c(Fraction(1, 3))), p.c(3)), op.POW),
}


@pytest.mark.parametrize("name", KEPT)
def test_never_folds(name: str) -> None:
    pen = Pen()
    rule, code = KEPT[name]
    assert pen.g.ops[rule(pen)] == code


def test_x_minus_y_and_y_minus_x_share_one_node() -> None:
    pen = Pen()
    forth, back = sub(pen.g, pen.x, pen.y), sub(pen.g, pen.y, pen.x)
    assert {forth, back} == {min(forth, back), neg(pen.g, min(forth, back))}
    assert sum(code == op.SUB for code in pen.g.ops) == 1


@pytest.mark.parametrize("dividend", [0, 1, Fraction(1, 2), 0.5])
@pytest.mark.parametrize("divisor", [0, 0.0])
def test_division_by_the_constant_zero_is_refused(dividend: float, divisor: float) -> None:
    pen = Pen()
    with pytest.raises(ExpressionError) as caught:
        div(pen.g, pen.c(dividend), pen.c(divisor))
    assert caught.value.problems[0].code == "expression.division_by_zero"
    with pytest.raises(ExpressionError):
        power(pen.g, ZERO, pen.c(-1))


@both_tiers
@given(samples(), st.randoms(use_true_random=False))
def test_form_does_not_depend_on_the_order_of_building(sample: Sample, rng: random.Random) -> None:
    straight, shuffled = Graph(), Graph()
    expected = built(sample.program, straight)[-1]
    root = built_shuffled(sample.program, shuffled, rng)
    assert shuffled.hashes[root] == straight.hashes[expected]
    assert copy_nodes(shuffled, straight, [root], {}) == [expected]


@both_tiers
@given(samples())
def test_canonical_nodes_are_fixed_points(sample: Sample) -> None:
    """Making any node again from its own operands, folding included, gives the same node."""
    graph = Graph()
    built(sample.program, graph)
    for node in range(len(graph)):
        if graph.ops[node] not in op.LEAVES:
            assert make(graph, graph.ops[node], graph.operands(node), graph.datum(node)) == node


@both_tiers
@given(samples())
def test_signs_float_outwards_and_operands_are_ordered(sample: Sample) -> None:
    graph = Graph()
    built(sample.program, graph)
    for node in range(len(graph)):
        code, operands = graph.ops[node], graph.operands(node)
        if code in (op.ADD, op.SUB, op.MUL, op.DIV):
            assert all(graph.ops[k] != op.NEG for k in operands)
        if code in (op.ADD, op.SUB, op.MUL):
            constant = [graph.ops[k] <= op.FLOAT for k in operands]
            assert constant[0] or not constant[1]
            assert constant[0] or graph.hashes[operands[0]] <= graph.hashes[operands[1]]
        if code in op.ODD_FUNCTIONS | op.EVEN_FUNCTIONS:
            assert graph.ops[operands[0]] != op.NEG


def test_functions_take_the_door_of_apply() -> None:
    pen = Pen()
    assert apply(pen.g, op.FMA, pen.x, pen.y, pen.z) == pen.g.many(op.FMA, (pen.x, pen.y, pen.z))
