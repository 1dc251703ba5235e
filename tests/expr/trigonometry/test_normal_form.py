"""The trigonometric normal form: textbook formulas out of products of rotation matrices, and its laws."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from symbody.expr import opcodes as op
from symbody.expr.calculus import gradient, time_derivative
from symbody.expr.expression import Expr, cos, number, sin, sqrt, symbol
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import symbols_of, tree_size
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.trigonometry.normal_form import trigonometric_form
from tests.effort import limited
from tests.expr.intervals import Interval, Undecided, interval, interval_arithmetic
from tests.expr.strategies import (
    DIGITS,
    Sample,
    both_tiers,
    built,
    samples,
    sequence_of,
)
from tests.tiers import cases

Matrix = list[list[Expr]]


class Pen:
    """Names of a robot and of a top, and the vector algebra that forms their equations without a thought."""

    def __init__(self) -> None:
        self.graph = Graph()
        self.zero, self.one = number(self.graph, 0), number(self.graph, 1)

    def parameters(self, names: str) -> list[Expr]:
        return [symbol(self.graph, Symbol(name)) for name in names.split()]

    def angles(self, names: str) -> list[Expr]:
        return [symbol(self.graph, Symbol(name, SymbolKind.COORDINATE)) for name in names.split()]

    def about_z(self, a: Expr) -> Matrix:
        zero, one = self.zero, self.one
        return [[cos(a), -sin(a), zero], [sin(a), cos(a), zero], [zero, zero, one]]

    def about_x(self, a: Expr) -> Matrix:
        zero, one = self.zero, self.one
        return [[one, zero, zero], [zero, cos(a), -sin(a)], [zero, sin(a), cos(a)]]

    def slopes(self, vector: list[Expr], by: list[Expr]) -> Matrix:
        nodes = [entry.index for entry in by]
        return [[Expr(self.graph, k) for k in gradient(self.graph, entry.index, nodes)] for entry in vector]

    def form(self, expression: Expr) -> Expr:
        """Return the normal form, whose function is checked to be the same."""
        (node,) = trigonometric_form(self.graph, [expression.index])
        values = fingerprints(self.graph, self.graph.reachable([node, expression.index]))
        assert values[node] == values[expression.index]
        assert tree_size(self.graph, node) <= tree_size(self.graph, expression.index)
        return Expr(self.graph, node)

    def size(self, expression: Expr) -> int:
        return tree_size(self.graph, expression.index)

    def functions(self, expression: Expr) -> set[Expr]:
        """Return the sines and cosines that an expression is made of."""
        nodes = self.graph.reachable([expression.index])
        return {Expr(self.graph, k) for k in nodes if self.graph.ops[k] in (op.SIN, op.COS)}

    def same(self, expression: Expr, target: Expr) -> None:
        """Check that `expression` is what a textbook prints, up to the order of terms and factors."""
        values = fingerprints(self.graph, self.graph.reachable([expression.index, target.index]))
        assert values[expression.index] == values[target.index]
        assert self.size(expression) == self.size(target)
        assert self.functions(expression) == self.functions(target)


def times(P: Matrix, Q: Matrix) -> Matrix:
    columns = list(zip(*Q, strict=True))
    return [[dot(row, column) for column in columns] for row in P]


def dot(a: Any, b: Any) -> Expr:
    products = [x * y for x, y in zip(a, b, strict=True)]
    return sum(products[1:], start=products[0])


def apply(P: Matrix, vector: list[Expr]) -> list[Expr]:
    return [dot(row, vector) for row in P]


# The mechanisms of the notes


class Robot(Pen):
    """Two links in the plane: lengths L3 + L4 and L5 + L6, centres of mass at L3 and L5 from the joints."""

    def __init__(self, joined: bool) -> None:
        super().__init__()
        self.L3, self.L4, self.L5, self.L6 = self.parameters("L3 L4 L5 L6")
        self.m1, self.m2, self.I1, self.I2 = self.parameters("m1 m2 I1 I2")
        self.b1, self.b2 = self.angles("b1 b2")
        first = self.about_z(self.b1)
        second = times(first, self.about_z(self.b2))
        along = [[length, self.zero, self.zero] for length in (self.L3, self.L4, self.L5, self.L5 + self.L6)]
        if joined:
            elbow = apply(first, [self.L3 + self.L4, self.zero, self.zero])
        else:
            elbow = [x + y for x, y in zip(apply(first, along[0]), apply(first, along[1]), strict=True)]
        self.tip = [x + y for x, y in zip(elbow, apply(second, along[3]), strict=True)]
        centres = [
            apply(first, along[0]),
            [x + y for x, y in zip(elbow, apply(second, along[2]), strict=True)],
        ]
        J1, J2 = (self.slopes(centre, [self.b1, self.b2]) for centre in centres)
        self.M = [
            [
                self.m1 * dot([row[i] for row in J1], [row[j] for row in J1])
                + self.m2 * dot([row[i] for row in J2], [row[j] for row in J2])
                + (self.I1 + self.I2 if i == j == 0 else self.I2)
                for j in range(2)
            ]
            for i in range(2)
        ]


@pytest.mark.parametrize("joined", [True, False], ids=["one vector a link", "two vectors a link"])
def test_mass_matrix_of_the_robot(joined: bool) -> None:
    """I1 + m1 L3^2 + I2 + m2 ((L3+L4)^2 + L5^2 + 2 (L3+L4) L5 cos b2)."""
    r = Robot(joined)
    reach = r.L3 + r.L4
    inner = reach**2 + r.L5**2 + 2 * reach * r.L5 * cos(r.b2)
    assert r.size(r.M[0][0]) > 30
    r.same(r.form(r.M[0][0]), r.I1 + r.m1 * r.L3**2 + r.I2 + r.m2 * inner)
    r.same(r.form(r.M[0][1]), r.I2 + r.m2 * r.L5 * (r.L5 + reach * cos(r.b2)))
    assert r.form(r.M[1][0]) == r.form(r.M[0][1])
    r.same(r.form(r.M[1][1]), r.I2 + r.m2 * r.L5**2)


@pytest.mark.parametrize("joined", [True, False], ids=["one vector a link", "two vectors a link"])
def test_tip_of_the_robot(joined: bool) -> None:
    r = Robot(joined)
    for entry, function in zip(r.tip[:2], (cos, sin), strict=True):
        r.same(r.form(entry), (r.L3 + r.L4) * function(r.b1) + (r.L5 + r.L6) * function(r.b1 + r.b2))
    assert r.form(r.tip[2]).is_zero


def test_mass_matrix_of_the_spinning_top() -> None:
    """[[A sin^2 eta + C cos^2 eta, 0, C cos eta], [0, A, 0], [C cos eta, 0, C]]."""
    p = Pen()
    zeta, eta, xi = p.angles("zeta eta xi")
    A, C = p.parameters("A C")
    R = times(times(p.about_z(zeta), p.about_x(eta)), p.about_z(xi))
    rates = time_derivative(p.graph, [entry.index for row in R for entry in row])
    change = [[Expr(p.graph, rates[3 * i + j]) for j in range(3)] for i in range(3)]
    spin = times([list(row) for row in zip(*R, strict=True)], change)  # R^T R', in body axes
    omega = [spin[2][1], spin[0][2], spin[1][0]]
    speeds = [symbol(p.graph, Symbol(name, SymbolKind.COORDINATE, 1)) for name in ("zeta", "eta", "xi")]
    J = p.slopes(omega, speeds)
    M = [
        [A * J[0][i] * J[0][j] + A * J[1][i] * J[1][j] + C * J[2][i] * J[2][j] for j in range(3)]
        for i in range(3)
    ]
    expected = [
        [A * sin(eta) ** 2 + C * cos(eta) ** 2, p.zero, C * cos(eta)],
        [p.zero, A, p.zero],
        [C * cos(eta), p.zero, C],
    ]
    for i in range(3):
        for j in range(3):
            assert p.form(M[i][j]) == expected[i][j]
    p.same(p.form(omega[0]), speeds[0] * sin(eta) * sin(xi) + speeds[1] * cos(xi))


def test_chains_of_parallel_axes_lose_every_angle_but_the_relative_ones() -> None:
    """M12 of three links: m l0 l1 cos q1 and sums of relative angles, no q0."""
    p = Pen()
    q, lengths = p.angles("q0 q1 q2"), p.parameters("l0 l1 l2")
    R, tip = p.about_z(q[0]), [p.zero] * 3
    for k in range(3):
        R = times(R, p.about_z(q[k])) if k else R
        tip = [x + y for x, y in zip(tip, apply(R, [lengths[k], p.zero, p.zero]), strict=True)]
    J = p.slopes(tip, q)
    for i in range(3):
        for j in range(3):
            form = p.form(dot([row[i] for row in J], [row[j] for row in J]))
            assert q[0].index not in symbols_of(p.graph, [form.index])
            assert p.functions(form) <= {cos(q[1]), cos(q[2]), cos(q[1] + q[2])}
    top = p.form(dot([row[0] for row in J], [row[0] for row in J]))
    assert p.functions(top) == {cos(q[1]), cos(q[2]), cos(q[1] + q[2])}
    assert p.size(top) <= 20  # 3 squares, 3 products of two lengths, a factor 2 and a cosine, 5 sums, 1 angle


def test_angles_from_the_vertical_are_subtracted() -> None:
    p = Pen()
    (a, b), (l, k) = p.angles("a b"), p.parameters("l k")
    speed = (l * cos(a) + k * cos(b)) ** 2 + (l * sin(a) + k * sin(b)) ** 2
    p.same(p.form(speed), l**2 + k**2 + 2 * l * k * cos(a - b))


# Single rules

RULES: dict[str, tuple[Callable[[Pen], Expr], Callable[[Pen], Expr]]] = {
    "difference of angles": (
        lambda p: cos(a(p)) * cos(a(p) + b(p)) + sin(a(p)) * sin(a(p) + b(p)),
        lambda p: cos(b(p)),
    ),
    "sum of angles": (lambda p: sin(a(p)) * cos(b(p)) + cos(a(p)) * sin(b(p)), lambda p: sin(a(p) + b(p))),
    "double angle": (lambda p: cos(a(p)) ** 2 - sin(a(p)) ** 2, lambda p: cos(2 * a(p))),
    "twice sine cosine": (lambda p: 2 * sin(a(p)) * cos(a(p)), lambda p: sin(2 * a(p))),
    "triple angle": (lambda p: 4 * cos(a(p)) ** 3 - 3 * cos(a(p)), lambda p: cos(3 * a(p))),
    "one": (lambda p: sin(a(p)) ** 2 + cos(a(p)) ** 2, lambda p: p.one),
    "fourth powers": (
        lambda p: sin(a(p)) ** 4 + 2 * sin(a(p)) ** 2 * cos(a(p)) ** 2 + cos(a(p)) ** 4,
        lambda p: p.one,
    ),
    "one minus a square": (lambda p: m(p) - m(p) * cos(a(p)) ** 2, lambda p: m(p) * sin(a(p)) ** 2),
    "quarter turn": (lambda p: sin(a(p) + pi(p) / 2) - cos(a(p)) + m(p), lambda p: m(p)),
    "half turn": (lambda p: cos(a(p) - pi(p)) * m(p) + cos(a(p)) * m(p) + k(p), lambda p: k(p)),
    "half angles": (lambda p: 2 * cos(a(p) / 2) * sin(a(p) / 2) * m(p), lambda p: sin(a(p)) * m(p)),
    "sixth of a turn": (
        lambda p: cos(a(p) + pi(p) / 6) ** 2 + sin(a(p) + pi(p) / 6) ** 2,
        lambda p: p.one,
    ),
    "angle of a number": (
        lambda p: sin(a(p) + 1) * cos(p.one) - cos(a(p) + 1) * sin(p.one),
        lambda p: sin(a(p)),
    ),
    "angle of a product": (
        lambda p: sin(m(p) * k(p)) ** 2 * x(p) + cos(m(p) * k(p)) ** 2 * x(p),
        lambda p: x(p),
    ),
    "common factor": (lambda p: m(p) * k(p) * x(p) + m(p) * y(p) * x(p), lambda p: m(p) * (k(p) + y(p)) * x(p)),
    "square of a sum": (
        lambda p: k(p) ** 2 + 2 * k(p) * m(p) + m(p) ** 2 + (k(p) + m(p)) * x(p),
        lambda p: (k(p) + m(p)) * (k(p) + m(p) + x(p)),
    ),
    "square that was there": (
        lambda p: (k(p) + m(p)) ** 2 + x(p) * sin(a(p)) ** 2 + x(p) * cos(a(p)) ** 2,
        lambda p: (k(p) + m(p)) ** 2 + x(p),
    ),
    "numerator and divisor": (
        lambda p: (m(p) - m(p) * cos(a(p)) ** 2) / (k(p) * sin(a(p)) ** 2 + k(p) * cos(a(p)) ** 2),
        lambda p: m(p) * sin(a(p)) ** 2 / k(p),
    ),
    "under a root": (
        lambda p: sqrt(m(p) ** 2 * sin(a(p)) ** 2 + m(p) ** 2 * cos(a(p)) ** 2 + k(p)),
        lambda p: sqrt(m(p) ** 2 + k(p)),
    ),
}  # fmt: skip


def a(p: Pen) -> Expr:
    return p.angles("a")[0]


def b(p: Pen) -> Expr:
    return p.angles("b")[0]


def m(p: Pen) -> Expr:
    return p.parameters("m")[0]


def k(p: Pen) -> Expr:
    return p.parameters("k")[0]


def x(p: Pen) -> Expr:
    return p.angles("x")[0]


def y(p: Pen) -> Expr:
    return p.angles("y")[0]


def pi(p: Pen) -> Expr:
    return Expr(p.graph, p.graph.pi())


@pytest.mark.parametrize("name", RULES)
def test_is_written_shorter(name: str) -> None:
    p = Pen()
    given_, target = RULES[name]
    p.same(p.form(given_(p)), target(p))


KEPT: dict[str, Callable[[Pen], Expr]] = {
    "a linear equation of motion": lambda p: (
        m(p) * symbol(p.graph, Symbol("x", SymbolKind.COORDINATE, 2))
        + symbol(p.graph, Symbol("d")) * symbol(p.graph, Symbol("x", SymbolKind.COORDINATE, 1))
        + k(p) * x(p)
    ),
    "squares of sine and cosine": lambda p: m(p) * sin(a(p)) ** 2 + k(p) * cos(a(p)) ** 2,
    "one square, two moments": lambda p: m(p) + (k(p) - m(p)) * cos(a(p)) ** 2,
    "sine cosine": lambda p: sin(a(p)) * cos(a(p)),
    "product of two axes": lambda p: sin(a(p)) * cos(b(p)) * m(p),
    "sum of angles": lambda p: m(p) * sin(a(p) + b(p)) + k(p) * cos(a(p)),
    "square of a sum": lambda p: (m(p) + k(p) * cos(a(p))) ** 2,
    "a power of a sum": lambda p: (m(p) + k(p)) ** 40,
    "a quotient": lambda p: m(p) / (k(p) + x(p)),
    "a symbol": a,
    "a number": lambda p: number(p.graph, Fraction(1, 3)),
    "a function of a function": lambda p: sin(cos(a(p)) + m(p)),
    "tangents": lambda p: Expr(p.graph, p.graph.node(op.TAN, a(p).index)) * m(p),
    "rounded constants": lambda p: 0.5 * sin(a(p)) ** 2 + 0.5 * cos(a(p)) ** 2,
    "a rounded angle": lambda p: sin(a(p) + 0.5) ** 2 + cos(a(p) + 0.5) ** 2,
    "a hundredth of an angle": lambda p: m(p) * sin(a(p)) + k(p) * sin(a(p) / 100),
}  # fmt: skip


@pytest.mark.parametrize("name", KEPT)
def test_stays_as_it_is(name: str) -> None:
    p = Pen()
    expression = KEPT[name](p)
    assert p.form(expression) == expression


def test_a_divisor_that_vanishes_identically_is_left_alone() -> None:
    """1/(sin^2 + cos^2 - 1) has no value, and no better form."""
    p = Pen()
    vanishing = sin(a(p)) ** 2 + cos(a(p)) ** 2 - 1
    (node,) = trigonometric_form(p.graph, [(1 / vanishing).index])
    assert op.DIV in {p.graph.ops[j] for j in p.graph.reachable([node])}


def test_roots_are_written_each_by_itself() -> None:
    p = Pen()
    roots = [(sin(a(p)) ** 2 + cos(a(p)) ** 2).index, a(p).index, (m(p) - m(p) * cos(a(p)) ** 2).index]
    together = trigonometric_form(p.graph, roots)
    assert together == [trigonometric_form(p.graph, [root])[0] for root in roots]
    assert trigonometric_form(p.graph, []) == []


def test_forms_are_final() -> None:
    """The form of the form is the form, for all that mechanics makes of the robot."""
    r = Robot(joined=False)
    for expression in (*r.tip, *r.M[0], *r.M[1]):
        form = r.form(expression)
        assert r.form(form) == form


# Laws

EXPANDED = (op.ADD, op.SUB, op.MUL, op.NEG, op.POW, op.SIN, op.COS)


def enclosed(graph: Graph, node: int, point: tuple[Fraction, ...]) -> Interval:
    """Return a narrow interval that holds the exact value of a node; two of equal nodes meet."""
    unit = Fraction(1, 10**50)
    with mpmath.workdps(DIGITS):  # far more digits than the intervals are widened by
        inputs = {"q": [interval(value, unit) for value in point]}
        sequence = sequence_of(graph, [node], merge=False, contract=False)
        try:
            value: Interval = evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0][0]
        except Undecided:
            assume(False)
        assume(value.width < 1e-30)
        return value


@both_tiers
@given(samples(ops=EXPANDED), st.booleans())
def test_values_stay_and_sizes_shrink(sample: Sample, last: bool) -> None:
    graph = Graph()
    nodes = built(sample.program, graph)[-1 if last else 0 :]
    forms = trigonometric_form(graph, nodes)
    values = fingerprints(graph, graph.reachable([*nodes, *forms]))
    for node, form in zip(nodes, forms, strict=True):
        assert tree_size(graph, form) <= tree_size(graph, node)
        # fingerprints do not see every equality: those of squares of roots, and of angles with brackets
        if values[form] != values[node]:
            assert enclosed(graph, form, sample.point).meets(enclosed(graph, node, sample.point))


@both_tiers
@given(samples())
def test_values_stay_with_every_function(sample: Sample) -> None:
    graph = Graph()
    root = built(sample.program, graph)[-1]
    (form,) = trigonometric_form(graph, [root])
    assert enclosed(graph, form, sample.point).meets(enclosed(graph, root, sample.point))


Term = tuple[int, int, list[tuple[int, tuple[int, ...]]]]

# Factor, mass, and sines (0) and cosines (1) of sums of three angles.
TERMS = st.lists(
    st.tuples(
        st.integers(-3, 3),
        st.integers(0, 2),
        st.lists(st.tuples(st.integers(0, 1), st.tuples(*[st.integers(-2, 2)] * 3)), max_size=2),
    ),
    min_size=1,
    max_size=4,
)


def angular_sum(p: Pen, terms: list[Term]) -> Expr:
    total, axes, masses = p.zero, p.angles("a b c"), p.parameters("l m n")
    for factor, mass, functions in terms:
        product = factor * masses[mass]
        for kind, multiples in functions:
            product = product * (sin, cos)[kind](dot(axes, multiples))
        total = total + product
    return total


@both_tiers
@given(TERMS)
@example([(1, 0, [(0, (0, 0, 1)), (0, (1, 1, 0))]), (1, 0, [(0, (-2, 0, 2)), (0, (-2, 1, 2))])])
@example([(1, 0, [(0, (0, 1, 0))]), (2, 0, [(0, (-1, 2, 2)), (0, (2, -2, -1))])])
def test_equal_sums_of_harmonics_vanish_when_subtracted(terms: list[Term]) -> None:
    """The form is normal: the difference of an expression and its own form is written as 0.

    In sums of products of two, angles are at most 4 times each axis, which is within the limits.
    """
    p = Pen()
    expression = angular_sum(p, terms)
    form = p.form(expression)
    assert p.form(expression * 3 - form * 3).is_zero


@both_tiers
@given(TERMS, st.integers(1, 12))
@example(
    [
        (1, 0, [(0, (1, -1, -1)), (0, (-1, 1, 1))]),
        (2, 0, [(0, (-2, -2, 1)), (0, (0, 0, 1))]),
        (1, 0, [(0, (-2, -1, -1)), (0, (-2, -1, 1))]),
    ],
    1,
)
def test_an_angle_that_makes_no_difference_disappears(terms: list[Term], twelfths: int) -> None:
    p = Pen()
    expression = angular_sum(p, terms)
    angle = p.angles("other")[0] + Expr(p.graph, p.graph.pi()) * Fraction(twelfths, 12)
    spread = expression * sin(angle) ** 2 + expression * cos(angle) ** 2
    for roundabout in (spread, expression * (sin(angle) ** 2 + cos(angle) ** 2)):
        form = p.form(roundabout)
        assert p.angles("other")[0].index not in symbols_of(p.graph, [form.index])


# Bounded work


def wide(p: Pen) -> Expr:
    names = p.parameters(" ".join(f"v{k}" for k in range(700)))
    return sum((v * w for v, w in zip(names, names[1:], strict=False)), start=p.zero)


def powers_of_sums(p: Pen) -> Expr:
    names = p.parameters(" ".join(f"v{k}" for k in range(30)))
    return dot([v + w for v, w in zip(names, names[1:], strict=False)], names[1:]) ** 8 * sin(a(p)) ** 2


def nested(p: Pen) -> Expr:
    node = a(p)
    for _ in range(400):
        node = sin(node) + b(p)
    return node


def squares_of_squares(p: Pen) -> Expr:
    node = m(p)
    for _ in range(500):
        node = node * (node + k(p))
    return node


def many_angles(p: Pen) -> Expr:
    axes = p.angles(" ".join(f"q{k}" for k in range(300)))
    return sum((v * cos(v + w) for v, w in zip(axes, axes[1:], strict=False)), start=p.zero)


def dense(p: Pen) -> Expr:
    axes, masses = p.angles(" ".join(f"q{k}" for k in range(12))), p.parameters(" ".join("abcdefghijkl"))
    return sum(
        (masses[i] * masses[j] * cos(axes[i]) * cos(axes[j]) for i in range(12) for j in range(12)),
        start=p.zero,
    )


@pytest.mark.parametrize(
    "make",
    cases(
        [wide, powers_of_sums, nested, squares_of_squares, many_angles, dense],
        fast=lambda make: make is not nested,
    ),
)
def test_work_is_bounded(make: Callable[[Pen], Expr]) -> None:
    """None takes longer than a second or two: work that grows without bound is caught."""
    p = Pen()
    expression = make(p)
    with limited(3):
        p.form(expression)


def test_large_roots_stay_as_they_are() -> None:
    p = Pen()
    names = p.parameters(" ".join(f"v{k}" for k in range(1001)))
    large = sum((v * sin(a(p)) for v in names), start=p.zero)
    assert p.size(large) > 2000
    assert p.form(large) == large


def test_printed_and_computed_agree() -> None:
    """The form is a root of the same graph, so code can be made of it as well."""
    r = Robot(joined=False)
    roots = [r.M[0][0].index, r.form(r.M[0][0]).index]
    inputs = {node: Input(f"i{k}", "p", k) for k, node in enumerate(symbols_of(r.graph, roots))}
    sequence = build_sequence(r.graph, [Roots("M11", (2,), tuple(roots))], inputs)
    assert sequence.outputs[0].values[0] == sequence.outputs[0].values[1]
