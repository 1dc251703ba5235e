"""Derivatives: the same as SymPy's and the complex step's, forward, reverse, by time; linear parts."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import mpmath
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from symbody.errors import FormulationError
from symbody.expr import opcodes as op
from symbody.expr.calculus import (
    derivative,
    forward,
    gradient,
    jacobian,
    linear_coefficients,
    time_derivative,
)
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, neg, power, select, sub
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind, UserFunction
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import Arithmetic, evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from symbody.expr.sequences.sequence import Sequence
from tests.expr.intervals import Interval, Undecided, interval, interval_arithmetic
from tests.expr.strategies import (
    DIGITS,
    SMOOTH,
    SYMBOLS,
    SYMPY_SYMBOLS,
    Sample,
    both_tiers,
    built,
    samples,
    sequence_of,
    sympy_expression,
    sympy_value,
)
from tests.tiers import cases

PRECISION = 50
UNIT = Fraction(1, 10 ** (PRECISION - 1))
ANALYTIC = samples(ops=SMOOTH, steps=8)
RATES = st.tuples(*[st.integers(-8, 8).map(lambda k: Fraction(k, 4))] * 3)


def check(
    sequence: Sequence, point: tuple[Fraction, ...], expected: list[Any], rates: tuple[Fraction, ...] = ()
) -> None:
    """The exact values and those computed with 50 digits lie in intervals that rounding alone explains."""
    with mpmath.workdps(DIGITS):
        groups = {"q": point, "u": rates}
        inputs = {group: [interval(x, UNIT) for x in numbers] for group, numbers in groups.items()}
        try:
            allowed: list[Interval] = evaluate_sequence(sequence, inputs, interval_arithmetic(UNIT))[0]
        except Undecided:
            assume(False)
        assume(all(entry.width < 1e-30 for entry in allowed))
        exact = {
            group: [mpmath.mpf(x.numerator) / x.denominator for x in numbers]
            for group, numbers in groups.items()
        }
        with mpmath.workdps(PRECISION):
            found = evaluate_sequence(sequence, exact, MPMATH)[0]
        for entry, value, target in zip(allowed, found, expected, strict=True):
            assert value in entry
            assert target in entry


@both_tiers
@given(ANALYTIC)
def test_forward_and_reverse_agree_with_sympy(sample: Sample) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    symbols = [graph.symbol(symbol) for symbol in SYMBOLS]
    expression = sympy_expression(sample.program)
    expected = [sympy_value(sp.diff(expression, symbol), sample.point) for symbol in SYMPY_SYMBOLS]
    ahead = [derivative(graph, [root], symbol)[0] for symbol in symbols]
    back = gradient(graph, root, symbols)
    check(sequence_of(graph, [*ahead, *back], merge=False), sample.point, expected * 2)


# Choices are made by the real part, so that every function is analytic on either side of its kinks.
_COMPLEX: Mapping[int, Callable[..., Any]] = {
    **{code: MPMATH.functions[code] for code in (*SMOOTH, op.FMA, op.SELECT)},
    op.ATAN2: lambda y, x: -1j * mpmath.log((x + 1j * y) / mpmath.sqrt(x * x + y * y)),
    op.LT: lambda a, b: mpmath.re(a) < mpmath.re(b),
    op.LE: lambda a, b: mpmath.re(a) <= mpmath.re(b),
    op.MIN: lambda a, b: a if mpmath.re(a) < mpmath.re(b) else b,
    op.MAX: lambda a, b: a if mpmath.re(a) > mpmath.re(b) else b,
    op.ABS: lambda a: a if mpmath.re(a) > 0 else -a,
    op.SIGN: lambda a: mpmath.sign(mpmath.re(a)),
    op.FLOOR: lambda a: mpmath.floor(mpmath.re(a)),
}
COMPLEX = Arithmetic(MPMATH.constant, MPMATH.pi, _COMPLEX, mpmath.sqrt)


@both_tiers
@given(samples())
def test_derivatives_agree_with_the_complex_step(sample: Sample) -> None:
    """Im f(x + ih)/h = f'(x) - h^2 f'''/6 + ...: steps h and h/2 differ by three times what h/2 is off.

    Rounding adds what it does to f, divided by h; the imaginary part is rounded no worse than the real one.
    """
    graph = Graph()
    root = built(sample.program, graph)[-1]
    sequence = sequence_of(graph, [root])
    symbols = [graph.symbol(symbol) for symbol in SYMBOLS]
    ahead = [derivative(graph, [root], symbol)[0] for symbol in symbols]
    slopes = sequence_of(graph, [*gradient(graph, root, symbols), *ahead])
    unit, step = Fraction(1, 10 ** (DIGITS - 1)), mpmath.mpf(10) ** -20
    with mpmath.workdps(DIGITS):
        point = [mpmath.mpf(x.numerator) / x.denominator for x in sample.point]
        inputs = {"q": [interval(x, unit) for x in sample.point]}
        try:
            blur = evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0][0].width
            allowed = evaluate_sequence(slopes, inputs, interval_arithmetic(unit))[0]
        except Undecided:
            assume(False)
        for k, slope in enumerate(allowed):
            coarse, fine = (imaginary(sequence, point, k % 3, h) for h in (step, step / 2))
            slack = abs(coarse - fine) + 2 * blur / step
            assume(slack < 1e-25)
            assert slope.low - slack <= fine <= slope.high + slack


def imaginary(sequence: Sequence, point: list[Any], k: int, step: Any) -> Any:
    moved = [x + (step * 1j if j == k else 0) for j, x in enumerate(point)]
    return mpmath.im(evaluate_sequence(sequence, {"q": moved}, COMPLEX)[0][0]) / step


@both_tiers
@given(ANALYTIC, RATES)
def test_time_derivative_is_the_chain_rule(sample: Sample, rates: tuple[Fraction, ...]) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    expression = sympy_expression(sample.program)
    slopes = [sympy_value(sp.diff(expression, symbol), sample.point) for symbol in SYMPY_SYMBOLS]
    with mpmath.workdps(DIGITS):
        expected = sum(
            (slope * rate.numerator / rate.denominator for slope, rate in zip(slopes, rates, strict=True)),
            start=mpmath.mpf(0),
        )
    check(sequence_of(graph, time_derivative(graph, [root])), sample.point, [expected], rates)


@both_tiers
@given(ANALYTIC, ANALYTIC)
def test_jacobians_do_not_depend_on_the_direction_taken(one: Sample, two: Sample) -> None:
    """More columns than rows are swept in reverse, more rows than columns forward."""
    graph = Graph()
    roots = [built(sample.program, graph)[-1] for sample in (one, two)]
    symbols = [graph.symbol(symbol) for symbol in SYMBOLS]
    wide = jacobian(graph, roots, symbols)
    tall = jacobian(graph, [*roots, *symbols], symbols)
    expression = sympy_expression(one.program)
    expected = [sympy_value(sp.diff(expression, symbol), one.point) for symbol in SYMPY_SYMBOLS]
    assert [len(row) for row in wide] == [3, 3]
    assert tall[2:] == [[int(i == k) for k in range(3)] for i in range(3)]
    check(sequence_of(graph, [*wide[0], *tall[0]]), one.point, expected * 2)
    assert jacobian(graph, roots, []) == [[], []]


class Pen:
    def __init__(self) -> None:
        self.g = Graph()
        self.x, self.y, self.z = (self.g.symbol(symbol) for symbol in SYMBOLS)


def test_directions_are_any_seeds() -> None:
    pen = Pen()
    product = mul(pen.g, pen.x, pen.y)
    assert forward(pen.g, [product], {pen.x: pen.y, pen.y: TWO}) == [
        add(pen.g, power(pen.g, pen.y, TWO), mul(pen.g, TWO, pen.x))
    ]
    assert forward(pen.g, [product, pen.z], {product: pen.z}) == [pen.z, ZERO]
    assert derivative(pen.g, [apply(pen.g, op.SIN, product)], product) == [apply(pen.g, op.COS, product)]


def test_rates_replace_those_of_symbols() -> None:
    graph = Graph()
    q, u = Symbol("q", SymbolKind.COORDINATE), graph.symbol(Symbol("u", SymbolKind.SPEED))
    node, t, k = graph.symbol(q), graph.symbol(TIME), graph.symbol(Symbol("k"))
    root = add(graph, mul(graph, k, mul(graph, node, node)), t)
    slope = mul(graph, k, mul(graph, TWO, node))
    own = graph.symbol(q.derivative)
    assert time_derivative(graph, [k, t, node]) == [ZERO, ONE, own]
    assert time_derivative(graph, [own]) == [graph.symbol(q.derivative.derivative)]
    with_own = time_derivative(graph, [root])[0]
    with_speed = time_derivative(graph, [root], {node: u})[0]
    assert {graph.symbols[graph.left[s]].label for s in symbols_of(graph, [with_own])} == {"k", "q", "q_dot"}
    assert {graph.symbols[graph.left[s]].label for s in symbols_of(graph, [with_speed])} == {"k", "q", "u"}
    assert derivative(graph, [with_speed], u) == derivative(graph, [with_own], own) == [slope]


# Where a derivative has branches


def test_branches_differentiate_to_branches() -> None:
    pen = Pen()
    g, x, y = pen.g, pen.x, pen.y
    below = apply(g, op.LT, x, y)
    choice = select(g, below, mul(g, x, x), apply(g, op.SIN, y))
    assert derivative(g, [choice], x) == [select(g, below, mul(g, TWO, x), ZERO)]
    assert gradient(g, choice, [x, y]) == [
        select(g, below, mul(g, TWO, x), ZERO),
        select(g, below, ZERO, apply(g, op.COS, y)),
    ]
    assert derivative(g, [apply(g, op.ABS, x)], x) == [apply(g, op.SIGN, x)]
    assert derivative(g, [apply(g, op.SIGN, x), apply(g, op.FLOOR, x), below], x) == [ZERO] * 3
    assert gradient(g, apply(g, op.MAX, x, y), [x]) != gradient(g, apply(g, op.MIN, x, y), [x])


@pytest.mark.parametrize("sweep", ["forward", "reverse"])
def test_a_branch_not_taken_cannot_spoil_the_derivative(sweep: str) -> None:
    """d/dx of 3 sqrt(x) where x > 0, else x: at x = 0 the root's slope is infinite, and must not be met."""
    pen = Pen()
    g, x = pen.g, pen.x
    root = mul(g, g.constant(3), select(g, apply(g, op.LT, ZERO, x), apply(g, op.SQRT, x), x))
    slope = derivative(g, [root], x)[0] if sweep == "forward" else gradient(g, root, [x])[0]
    sequence = sequence_of(g, [slope])
    assert evaluate_sequence(sequence, {"q": [0.0]}) == [[3.0]]
    assert evaluate_sequence(sequence, {"q": [-1.0]}) == [[3.0]]
    assert evaluate_sequence(sequence, {"q": [2.25]}) == [[1.0]]


def test_a_value_used_twice_in_a_branch_not_taken_cannot_spoil_the_derivative() -> None:
    """d/dx of s + sin(s) where x > 0, else x, with s = sqrt(x): at x = 0 the slope of s is infinite."""
    pen = Pen()
    g, root = pen.g, apply(pen.g, op.SQRT, pen.x)
    inside = add(g, root, apply(g, op.SIN, root))
    choice = select(g, apply(g, op.LT, ZERO, pen.x), inside, pen.x)
    slopes = [*gradient(g, choice, [pen.x]), *derivative(g, [choice], pen.x)]
    assert evaluate_sequence(sequence_of(g, slopes), {"q": [0.0]}) == [[1.0, 1.0]]


def test_branches_that_meet_again_are_joined() -> None:
    """One choice after another: the work grows with their number, not with that of the paths."""
    pen = Pen()
    g, node, sizes = pen.g, pen.x, []
    for k in range(40):
        below = apply(g, op.LT, node, g.constant(k))
        node = select(g, below, apply(g, op.SIN, node), mul(g, pen.y, node))
        size = len(g)
        gradient(g, node, [pen.x])
        sizes.append(len(g) - size)
    assert sizes[-1] <= 4 * len(sizes)  # of each choice a slope, a product or two, a select
    assert evaluate_sequence(sequence_of(g, gradient(g, node, [pen.x])), {"q": [-1.0, 2.0]})[0][0] != 0


@pytest.mark.parametrize("seeds", cases([range(10), range(10, 60)], fast=[range(10)]), ids=["some", "more"])
def test_branches_in_branches_lose_nothing_on_their_way_back(seeds: range) -> None:
    """Smaller, larger and selected values of each other, with conditions in common: reverse as forward."""
    for seed in seeds:
        chance, pen = random.Random(seed), Pen()
        g, leaves = pen.g, [pen.x, pen.y, pen.z]
        nodes = [*leaves, *(mul(g, a, b) for a, b in itertools.combinations_with_replacement(leaves, 2))]
        for _ in range(8):
            a, b, c = chance.choices(nodes[-7:], k=3)
            nodes += [
                apply(g, op.MIN, a, b),
                select(g, apply(g, op.LT, pen.x, pen.y), apply(g, op.MAX, b, c), c),
                add(g, apply(g, op.MAX, a, c), sub(g, b, apply(g, op.MIN, a, b))),
            ]
        there = [derivative(g, [nodes[-1]], leaf)[0] for leaf in leaves]
        back = gradient(g, nodes[-1], leaves)
        for _ in range(5):
            point = [chance.uniform(-2, 2) for _ in leaves]
            values = evaluate_sequence(sequence_of(g, [*there, *back]), {"q": point})[0]
            assert values[:3] == pytest.approx(values[3:], rel=1e-12, abs=1e-12)


def test_many_branches_that_do_not_meet_are_added_up() -> None:
    """x stands in one branch of each choice: 2^20 combinations of conditions, one of which holds."""
    pen = Pen()
    g, node = pen.g, pen.x
    for k in range(20):
        below = apply(g, op.LT, pen.y, g.constant(k))
        node = add(g, select(g, below, mul(g, TWO, node), pen.z), node)
    assert evaluate_sequence(sequence_of(g, gradient(g, node, [pen.x])), {"q": [1.0, 17.5, 1.0]}) == [[9.0]]


def test_nodes_are_varied_with_the_others_held_fixed() -> None:
    """Of x * s with s = sin(x), by x and s: slopes s and x, whichever way is taken."""
    pen = Pen()
    g, sine = pen.g, apply(pen.g, op.SIN, pen.x)
    root = mul(g, pen.x, sine)
    assert gradient(g, root, [pen.x, sine]) == [sine, pen.x]
    assert jacobian(g, [root, root, root], [pen.x, sine]) == [[sine, pen.x]] * 3
    assert derivative(g, [root], pen.x) != [sine]


@pytest.mark.parametrize(("x", "y", "expected"), [(1.0, 2.0, [1, 0, 0, 1]), (2.0, 1.0, [0, 1, 1, 0])])
def test_smaller_and_larger_pass_on_the_slope_of_the_one_taken(
    x: float, y: float, expected: list[int]
) -> None:
    pen = Pen()
    both = [*gradient(pen.g, apply(pen.g, op.MIN, pen.x, pen.y), [pen.x, pen.y])]
    both += gradient(pen.g, apply(pen.g, op.MAX, pen.x, pen.y), [pen.x, pen.y])
    assert evaluate_sequence(sequence_of(pen.g, both), {"q": [x, y]}) == [expected]


class Cubic:
    """x^3 y, or one of its derivatives."""

    def __init__(self, name: str = "cubic", orders: tuple[int, int] = (0, 0)) -> None:
        self.name, self.orders = name, orders

    def __call__(self, *arguments: float) -> float:
        x, y = arguments
        return {(0, 0): x**3 * y, (1, 0): 3 * x**2 * y, (0, 1): x**3, (1, 1): 3 * x**2}[self.orders]

    def derivative(self, position: int) -> UserFunction:
        orders = (self.orders[0] + (position == 0), self.orders[1] + (position == 1))
        return Cubic(f"{self.name}_{position}", orders)


def test_user_functions_bring_their_own_derivatives() -> None:
    pen = Pen()
    g = pen.g
    call = g.many(op.CALL, (mul(g, TWO, pen.x), pen.y), g.function(Cubic()))
    by_x, by_y = gradient(g, call, [pen.x, pen.y])
    mixed = derivative(g, [by_x], pen.y)[0]
    values = evaluate_sequence(sequence_of(g, [call, by_x, by_y, mixed]), {"q": [1.0, 3.0]})[0]
    assert values == [24.0, 72.0, 8.0, 24.0]


@pytest.mark.parametrize("sweep", ["forward", "reverse"])
def test_the_kernel_differentiates_by_solving_again(sweep: str) -> None:
    """Masses x and y tied by a1 = a2 under the force z on the first: a = z/(x+y), lambda = y z/(x+y)."""
    pen = Pen()
    g, symbols = pen.g, [pen.x, pen.y, pen.z]
    operands = (pen.x, ZERO, ZERO, pen.y, neg(g, ONE), ONE, pen.z, ZERO, ZERO)
    saddle = g.many(op.SADDLE, operands, g.kernel(KernelNode(2, 1)))
    picks = [g.node(op.PICK, saddle, k) for k in range(3)]
    total = add(g, pen.x, pen.y)
    a = div(g, pen.z, total)
    closed = [a, a, mul(g, pen.y, a)]
    if sweep == "forward":
        found = [derivative(g, [root], symbol)[0] for root in picks for symbol in symbols]
    else:
        found = [slope for root in picks for slope in gradient(g, mul(g, ONE, root), symbols)]
    expected = [slope for root in closed for slope in gradient(g, root, symbols)]
    with mpmath.workdps(PRECISION):
        inputs = {"q": [mpmath.mpf(2), mpmath.mpf(3), mpmath.mpf(5)]}
        left = evaluate_sequence(sequence_of(g, found), inputs, MPMATH)[0]
        right = evaluate_sequence(sequence_of(g, expected), inputs, MPMATH)[0]
    # A condition of at most 5 and fewer than 100 roundings; the kernel's cut of rows is far away.
    assert max(abs(p - q) for p, q in zip(left, right, strict=True)) < 500 * mpmath.mpf(10) ** (1 - PRECISION)


# Linear parts


@both_tiers
@given(samples(steps=5), samples(steps=5), samples(steps=5), st.randoms(use_true_random=False))
def test_linear_coefficients_are_what_was_put_in(one: Sample, two: Sample, three: Sample, rng: Any) -> None:
    """(w + b) a + v c is split into [a, c] and a b, however it is written."""
    graph = Graph()
    a, b, c = (built(sample.program, graph)[-1] for sample in (one, two, three))
    w, v = graph.symbol(Symbol("w", SymbolKind.SPEED)), graph.symbol(Symbol("v", SymbolKind.SPEED))
    forms = [
        add(graph, mul(graph, add(graph, w, b), a), mul(graph, v, c)),
        sub(graph, mul(graph, c, v), neg(graph, add(graph, mul(graph, a, b), mul(graph, w, a)))),
    ]
    rng.shuffle(forms)
    matrix, rest = linear_coefficients(graph, forms, [w, v])
    assert matrix == [[a, c], [a, c]]
    assert rest == [mul(graph, a, b)] * 2


@pytest.mark.parametrize(
    ("rule", "name"),
    [
        (lambda p: mul(p.g, p.x, p.x), "x"),
        (lambda p: apply(p.g, op.SIN, p.y), "y"),
        (lambda p: div(p.g, ONE, p.x), "x"),
        (lambda p: apply(p.g, op.ABS, p.y), "y"),
        (lambda p: select(p.g, apply(p.g, op.LT, p.x, p.z), p.x, p.z), "x"),
    ],
    ids=["square", "sine", "reciprocal", "absolute value", "choice"],
)
def test_what_is_not_linear_is_named(rule: Callable[[Pen], int], name: str) -> None:
    pen = Pen()
    with pytest.raises(FormulationError) as caught:
        linear_coefficients(pen.g, [pen.x, rule(pen)], [pen.x, pen.y])
    (problem,) = caught.value.problems
    assert problem.code == "expression.not_linear"
    assert problem.where == "row 1"
    assert f"not linear in {name}" in problem.what


def test_all_that_is_not_linear_is_named_at_once() -> None:
    pen = Pen()
    with pytest.raises(FormulationError) as caught:
        linear_coefficients(pen.g, [mul(pen.g, pen.x, pen.y)] * 2, [pen.x, pen.y])
    assert [problem.where for problem in caught.value.problems] == ["row 0", "row 0", "row 1", "row 1"]


# Size


@pytest.mark.parametrize("count", cases([20_000, 100_000, 1_000_000], fast=[20_000]))
def test_depth_has_no_limit(count: int) -> None:
    """x becomes sin(x) + y again and again: forward and reverse give one product of the same cosines."""
    pen = Pen()
    g, node = pen.g, pen.x
    for _ in range(count // 2):
        node = add(g, apply(g, op.SIN, node), pen.y)
    size = len(g)
    ahead = derivative(g, [node], pen.x)[0]
    back = gradient(g, node, [pen.x, pen.y])
    assert time_derivative(g, [node])[0] != ZERO
    assert ahead not in (ZERO, ONE)
    assert back[0] not in (ZERO, ONE)
    assert len(g) < 12 * size
