"""Fingerprints: every identity of sums, products and angles is found, and none is invented."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction
from itertools import combinations

import mpmath
import pytest
import sympy as sp
from hypothesis import assume, given

from symbody.expr import opcodes as op
from symbody.expr.canonical import ONE, TWO, ZERO, add, apply, div, mul, neg, power, select, sub
from symbody.expr.fingerprints.circle import root_in_field
from symbody.expr.fingerprints.fingerprint import PRIME, drop_sign, fingerprints, hash_words
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.sequences.evaluate import evaluate_sequence
from tests.expr.intervals import Undecided, interval, interval_arithmetic
from tests.expr.strategies import DIGITS, Sample, both_tiers, built, samples, sequence_of

Node = int


class Pen:
    def __init__(self) -> None:
        self.g = Graph()
        self.a, self.b, self.c = (self.g.symbol(Symbol(name)) for name in "abc")

    def n(self, value: int | Fraction | float) -> Node:
        return self.g.constant(value)

    def sin(self, angle: Node) -> Node:
        return apply(self.g, op.SIN, angle)

    def cos(self, angle: Node) -> Node:
        return apply(self.g, op.COS, angle)

    def tan(self, angle: Node) -> Node:
        return apply(self.g, op.TAN, angle)

    def sum(self, *terms: Node) -> Node:
        total = ZERO
        for term in terms:
            total = add(self.g, total, term)
        return total

    def product(self, *factors: Node) -> Node:
        total = ONE
        for factor in factors:
            total = mul(self.g, total, factor)
        return total

    def root(self, square: int | Fraction | float) -> Node:
        return apply(self.g, op.SQRT, self.n(square))

    def times_pi(self, factor: Fraction) -> Node:
        return mul(self.g, self.n(factor), self.g.pi())

    def equal(self, left: Node, right: Node) -> bool:
        values = fingerprints(self.g, self.g.reachable([left, right]))
        return values[left] == values[right]


IDENTITIES: dict[str, Callable[[Pen], tuple[Node, Node]]] = {
    "a(b+c) = ab+ac": lambda p: (
        mul(p.g, p.a, add(p.g, p.b, p.c)),
        p.sum(mul(p.g, p.a, p.b), mul(p.g, p.a, p.c)),
    ),
    "(a+b)^2": lambda p: (
        power(p.g, add(p.g, p.a, p.b), TWO),
        p.sum(power(p.g, p.a, TWO), p.product(TWO, p.a, p.b), power(p.g, p.b, TWO)),
    ),
    "a+(b+c) = (a+b)+c": lambda p: (add(p.g, p.a, add(p.g, p.b, p.c)), add(p.g, add(p.g, p.a, p.b), p.c)),
    "(a^2-b^2)/(a-b) = a+b": lambda p: (
        div(p.g, sub(p.g, power(p.g, p.a, TWO), power(p.g, p.b, TWO)), sub(p.g, p.a, p.b)),
        add(p.g, p.a, p.b),
    ),
    "a/a = 1": lambda p: (div(p.g, p.a, p.a), ONE),
    "a/b/c = a/(bc)": lambda p: (div(p.g, div(p.g, p.a, p.b), p.c), div(p.g, p.a, mul(p.g, p.b, p.c))),
    "a^-2 a^2 = 1": lambda p: (mul(p.g, power(p.g, p.a, p.n(-2)), power(p.g, p.a, TWO)), ONE),
    "0.5 + 0.25 = 3/4": lambda p: (add(p.g, add(p.g, p.a, p.n(0.5)), p.n(0.25)), add(p.g, p.a, p.n(Fraction(3, 4)))),
    "fma(a,b,c) = ab+c": lambda p: (p.g.many(op.FMA, (p.a, p.b, p.c)), add(p.g, mul(p.g, p.a, p.b), p.c)),
    "sin^2+cos^2 = 1": lambda p: (add(p.g, power(p.g, p.sin(p.a), TWO), power(p.g, p.cos(p.a), TWO)), ONE),
    "sin(a+b)": lambda p: (
        p.sin(add(p.g, p.a, p.b)),
        p.sum(mul(p.g, p.sin(p.a), p.cos(p.b)), mul(p.g, p.cos(p.a), p.sin(p.b))),
    ),
    "cos(a-b)": lambda p: (
        p.cos(sub(p.g, p.a, p.b)),
        p.sum(mul(p.g, p.cos(p.a), p.cos(p.b)), mul(p.g, p.sin(p.a), p.sin(p.b))),
    ),
    "cos(2a) = 1-2sin^2": lambda p: (
        p.cos(mul(p.g, TWO, p.a)),
        sub(p.g, ONE, mul(p.g, TWO, power(p.g, p.sin(p.a), TWO))),
    ),
    "sin(3a) = 3s-4s^3": lambda p: (
        p.sin(mul(p.g, p.n(3), p.a)),
        sub(p.g, mul(p.g, p.n(3), p.sin(p.a)), mul(p.g, p.n(4), power(p.g, p.sin(p.a), p.n(3)))),
    ),
    "sin(a) = 2 sin(a/2) cos(a/2)": lambda p: (
        p.sin(p.a),
        p.product(TWO, p.sin(div(p.g, p.a, TWO)), p.cos(div(p.g, p.a, TWO))),
    ),
    "sin(a+pi/2) = cos(a)": lambda p: (p.sin(add(p.g, p.a, p.times_pi(Fraction(1, 2)))), p.cos(p.a)),
    "cos(a-pi) = -cos(a)": lambda p: (p.cos(sub(p.g, p.a, p.g.pi())), neg(p.g, p.cos(p.a))),
    "sin(a+b-b) = sin(a)": lambda p: (p.sin(sub(p.g, add(p.g, p.a, p.b), p.b)), p.sin(p.a)),
    "sin(pi/5)^2+cos(pi/5)^2 = 1": lambda p: (
        add(
            p.g,
            power(p.g, p.sin(p.times_pi(Fraction(1, 5))), TWO),
            power(p.g, p.cos(p.times_pi(Fraction(1, 5))), TWO),
        ),
        ONE,
    ),
    "tan = sin/cos": lambda p: (p.tan(p.a), div(p.g, p.sin(p.a), p.cos(p.a))),
    "1+tan^2 = 1/cos^2": lambda p: (
        add(p.g, ONE, power(p.g, p.tan(p.a), TWO)),
        div(p.g, ONE, power(p.g, p.cos(p.a), TWO)),
    ),
    "cos of a product": lambda p: (
        p.cos(mul(p.g, p.a, mul(p.g, p.b, p.c))),
        p.cos(mul(p.g, mul(p.g, p.a, p.b), p.c)),
    ),
    "exp of equal sums": lambda p: (
        apply(p.g, op.EXP, add(p.g, p.a, add(p.g, p.b, p.c))),
        apply(p.g, op.EXP, add(p.g, add(p.g, p.a, p.b), p.c)),
    ),
    "atan is odd": lambda p: (
        apply(p.g, op.ATAN, mul(p.g, p.a, sub(p.g, p.b, p.c))),
        neg(p.g, apply(p.g, op.ATAN, sub(p.g, mul(p.g, p.a, p.c), mul(p.g, p.a, p.b)))),
    ),
    "abs is even": lambda p: (
        apply(p.g, op.ABS, mul(p.g, p.a, sub(p.g, p.b, p.c))),
        apply(p.g, op.ABS, sub(p.g, mul(p.g, p.a, p.c), mul(p.g, p.a, p.b))),
    ),
    "min has no order": lambda p: (
        apply(p.g, op.MIN, add(p.g, p.a, add(p.g, p.b, p.c)), p.a),
        apply(p.g, op.MIN, p.a, add(p.g, add(p.g, p.a, p.b), p.c)),
    ),
    "select of equals": lambda p: (
        select(p.g, apply(p.g, op.LT, p.a, p.b), power(p.g, add(p.g, p.a, p.b), TWO), p.c),
        select(
            p.g,
            apply(p.g, op.LT, p.a, p.b),
            mul(p.g, add(p.g, p.a, p.b), add(p.g, p.b, p.a)),
            p.c,
        ),
    ),
    "sin(pi/12)": lambda p: (p.sin(p.times_pi(Fraction(1, 12))), p.product(p.n(Fraction(1, 4)), sub(p.g, p.root(6), p.root(2)))),
    "cos(5 pi/12) = sin(pi/12)": lambda p: (p.cos(p.times_pi(Fraction(5, 12))), p.sin(p.times_pi(Fraction(1, 12)))),
    "tan(pi/12) = 2 - sqrt 3": lambda p: (p.tan(p.times_pi(Fraction(1, 12))), sub(p.g, TWO, p.root(3))),
    "sqrt 2 sqrt 3 = sqrt 6": lambda p: (p.product(p.root(2), p.root(3)), p.root(6)),
    "sqrt 8 = 2 sqrt 2": lambda p: (p.root(8), p.product(TWO, p.root(2))),
    "sqrt(3/4) = sqrt 3/2": lambda p: (p.root(Fraction(3, 4)), p.product(p.n(Fraction(1, 2)), p.root(3))),
    "sqrt(9/4) = 3/2": lambda p: (p.root(Fraction(9, 4)), p.n(Fraction(3, 2))),
    "sqrt 2 sqrt 5 = sqrt 10": lambda p: (p.product(p.root(2), p.root(5)), p.root(10)),
    "sqrt(1 + sin^2 + cos^2) = sqrt 2": lambda p: (
        apply(p.g, op.SQRT, p.sum(ONE, power(p.g, p.sin(p.a), TWO), power(p.g, p.cos(p.a), TWO))),
        p.root(2),
    ),
    "1/sqrt 2 = sqrt 2/2": lambda p: (div(p.g, ONE, p.root(2)), p.product(p.n(Fraction(1, 2)), p.root(2))),
    "sin(a+pi/3)": lambda p: (
        p.sin(add(p.g, p.a, p.times_pi(Fraction(1, 3)))),
        p.product(p.n(Fraction(1, 2)), add(p.g, p.sin(p.a), p.product(p.root(3), p.cos(p.a)))),
    ),
    "cos(2a-pi/4)": lambda p: (
        p.cos(sub(p.g, mul(p.g, TWO, p.a), p.times_pi(Fraction(1, 4)))),
        p.product(p.root(2), p.sum(p.product(p.sin(p.a), p.cos(p.a)), sub(p.g, power(p.g, p.cos(p.a), TWO), p.n(Fraction(1, 2))))),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", IDENTITIES)
def test_identities_are_found_without_being_known(name: str) -> None:
    pen = Pen()
    assert pen.equal(*IDENTITIES[name](pen))


DIFFERENT: dict[str, Callable[[Pen], tuple[Node, Node]]] = {
    "a, b": lambda p: (p.a, p.b),
    "a, -a": lambda p: (p.a, neg(p.g, p.a)),
    "a and its rate": lambda p: (
        p.g.symbol(Symbol("q", SymbolKind.COORDINATE)),
        p.g.symbol(Symbol("q", SymbolKind.COORDINATE, 1)),
    ),
    "sin, cos": lambda p: (p.sin(p.a), p.cos(p.a)),
    "sqrt(a^2), a": lambda p: (apply(p.g, op.SQRT, power(p.g, p.a, TWO)), p.a),
    "sqrt(a^2), abs(a)": lambda p: (apply(p.g, op.SQRT, power(p.g, p.a, TWO)), apply(p.g, op.ABS, p.a)),
    "exp, cosh": lambda p: (apply(p.g, op.EXP, p.a), apply(p.g, op.COSH, p.a)),
    "atan2(a,b), atan2(b,a)": lambda p: (apply(p.g, op.ATAN2, p.a, p.b), apply(p.g, op.ATAN2, p.b, p.a)),
    "min, max": lambda p: (apply(p.g, op.MIN, p.a, p.b), apply(p.g, op.MAX, p.a, p.b)),
    "a^(1/3), a^(2/3)": lambda p: (
        power(p.g, p.a, p.n(Fraction(1, 3))), power(p.g, p.a, p.n(Fraction(2, 3)))
    ),
    "0.1, 1/10": lambda p: (p.n(0.1), p.n(Fraction(1, 10))),
    "pi, 355/113": lambda p: (p.g.pi(), p.n(Fraction(355, 113))),
    "sqrt 2, -sqrt 2": lambda p: (p.root(2), neg(p.g, p.root(2))),
    "sqrt 2 + sqrt 3, sqrt 5": lambda p: (add(p.g, p.root(2), p.root(3)), p.root(5)),
    "sqrt 2, its float": lambda p: (p.root(2), p.n(2.0**0.5)),
    "sqrt -2, sqrt 2": lambda p: (p.root(-2), p.root(2)),
    "sin(pi/12), sin(5 pi/12)": lambda p: (
        p.sin(p.times_pi(Fraction(1, 12))), p.sin(p.times_pi(Fraction(5, 12)))
    ),
    "sin(pi/12), sin(-11 pi/12)": lambda p: (
        p.sin(p.times_pi(Fraction(1, 12))), p.sin(p.times_pi(Fraction(-11, 12)))
    ),
    "sin(pi/8), sin(pi/12)": lambda p: (
        p.sin(p.times_pi(Fraction(1, 8))), p.sin(p.times_pi(Fraction(1, 12)))
    ),
    "sin(1), sin(2)": lambda p: (p.sin(ONE), p.sin(TWO)),
    "two different quotients by 0": lambda p: (
        div(p.g, p.a, sub(p.g, add(p.g, p.a, p.b), add(p.g, p.b, p.a)) or _zero(p)),
        div(p.g, p.b, _zero(p)),
    ),
}  # fmt: skip


def _zero(pen: Pen) -> Node:
    """Return an expression that vanishes identically without being the constant 0."""
    return sub(pen.g, add(pen.g, power(pen.g, pen.sin(pen.a), TWO), power(pen.g, pen.cos(pen.a), TWO)), ONE)


@pytest.mark.parametrize("name", DIFFERENT)
def test_what_differs_has_different_fingerprints(name: str) -> None:
    pen = Pen()
    assert not pen.equal(*DIFFERENT[name](pen))


def test_vanishing_expressions_have_fingerprint_zero() -> None:
    pen = Pen()
    zero = _zero(pen)
    values = fingerprints(pen.g, pen.g.reachable([zero]))
    assert values[zero] == (0, 0)


def test_an_orthogonal_matrix_leaves_a_spherical_tensor_alone() -> None:
    """R D R^T = D for D = A 1, entry by entry, without a rule for it."""
    pen = Pen()
    g, s, c = pen.g, pen.sin, pen.cos
    about_z = [[c(pen.a), neg(g, s(pen.a)), ZERO], [s(pen.a), c(pen.a), ZERO], [ZERO, ZERO, ONE]]
    about_x = [[ONE, ZERO, ZERO], [ZERO, c(pen.b), neg(g, s(pen.b))], [ZERO, s(pen.b), c(pen.b)]]
    R = [
        [pen.sum(*(mul(g, about_z[i][k], about_x[k][j]) for k in range(3))) for j in range(3)]
        for i in range(3)
    ]
    for i in range(3):
        for j in range(3):
            entry = pen.sum(*(pen.product(R[i][k], pen.c, R[j][k]) for k in range(3)))
            assert pen.equal(entry, pen.c if i == j else ZERO)


Matrix = list[list[Node]]


def _turn(pen: Pen, axis: int, angle: Node) -> Matrix:
    g, c, s = pen.g, pen.cos(angle), pen.sin(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turn = [[ONE if i == n else ZERO for n in range(3)] for i in range(3)]
    turn[j][j], turn[j][k], turn[k][j], turn[k][k] = c, neg(g, s), s, c
    return turn


def _matrix_product(pen: Pen, left: Matrix, right: Matrix) -> Matrix:
    product, three = pen.product, range(3)
    return [[pen.sum(*(product(left[i][k], right[k][j]) for k in three)) for j in three] for i in three]


def _check_turns(seed: int) -> None:
    """Turns about one axis by multiples of pi/12 and of a, in any order, with conjugate turns between them."""
    pen, rng = Pen(), random.Random(seed)
    axis, twelfths = rng.randrange(3), [rng.randrange(-40, 41) for _ in range(4)]
    twelfths.append(-sum(twelfths) % 24)
    moving = [rng.randrange(-2, 3) for _ in range(2)]
    angles = [pen.times_pi(Fraction(k, 12)) for k in twelfths] + [
        mul(pen.g, pen.n(k), pen.a) for k in (*moving, -sum(moving))
    ]
    if rng.random() < 0.5:  # both in one angle
        angles[-1] = add(pen.g, angles[-1], angles.pop(0))
    rng.shuffle(angles)
    other, around = (axis + 1) % 3, pen.times_pi(Fraction(rng.choice((1, 3, 4, 5, 8)), 12))
    total = _turn(pen, other, around)
    for angle in angles:
        total = _matrix_product(pen, total, _turn(pen, axis, angle))
    total = _matrix_product(pen, total, _turn(pen, other, neg(pen.g, around)))
    for i in range(3):
        for j in range(3):
            assert pen.equal(total[i][j], ONE if i == j else ZERO), (seed, i, j)


def test_turns_by_twelfths_of_pi_add_up() -> None:
    for seed in range(100):
        _check_turns(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(100, 2000, 380))
def test_turns_by_twelfths_of_pi_add_up_often(first: int) -> None:
    for seed in range(first, first + 380):
        _check_turns(seed)


@both_tiers
@given(samples())
def test_no_equality_is_invented(sample: Sample) -> None:
    """Nodes of one fingerprint have one value, of opposite fingerprints opposite values."""
    graph = Graph()
    nodes = sorted(set(built(sample.program, graph)))
    values = fingerprints(graph, graph.reachable(nodes))
    unit = Fraction(1, 10**50)
    with mpmath.workdps(DIGITS):
        inputs = {"q": [interval(x, unit) for x in sample.point]}
        sequence = sequence_of(graph, nodes, merge=False, contract=False)
        try:
            found = evaluate_sequence(sequence, inputs, interval_arithmetic(unit))[0]
        except Undecided:
            assume(False)
        allowed = dict(zip(nodes, found, strict=True))
        for a, b in combinations(nodes, 2):
            (key_a, flipped_a), (key_b, flipped_b) = drop_sign(values[a]), drop_sign(values[b])
            if key_a == key_b:
                other = allowed[b] if flipped_a == flipped_b else -allowed[b]
                assert allowed[a].low <= other.high
                assert other.low <= allowed[a].high


@both_tiers
@given(samples())
def test_fingerprints_do_not_depend_on_the_graph(sample: Sample) -> None:
    one, two = Graph(), Graph()
    for k in range(5):
        two.symbol(Symbol(f"other{k}"))
    left, right = built(sample.program, one), built(sample.program, two)
    first = fingerprints(one, one.reachable(left))
    second = fingerprints(two, two.reachable(right))
    assert [first[k] for k in left] == [second[k] for k in right]


def test_opposite_fingerprints_share_one_key() -> None:
    assert drop_sign((0, 0)) == ((0, 0), False)
    assert drop_sign((PRIME - 1, 5)) == ((1, PRIME - 5), True)
    assert drop_sign((1, PRIME - 5)) == ((1, PRIME - 5), False)


def test_powers_of_two_are_distinct() -> None:
    graph = Graph()
    nodes = [graph.constant(sign * 2.0**k) for k in range(-1074, 1024) for sign in (1, -1)]
    values = fingerprints(graph, graph.reachable(nodes))
    assert len({values[node] for node in nodes}) == len(nodes)


def test_the_prime_has_what_the_field_needs() -> None:
    assert sp.isprime(PRIME) and sp.isprime((PRIME - 1) // 2) and PRIME % 24 == 23
    assert all(pow(root_in_field(n, PRIME), 2, PRIME) == n for n in (2, 3))


def test_entries_of_one_solution_have_no_sums_in_common() -> None:
    # Hashes of tuples are nearly sums of their entries: of one draw in some hundred, four fulfilled this.
    rng = random.Random(1)
    for _ in range(1000):
        whole = hash_words(rng.randrange(PRIME))
        entries = [hash_words(op.PICK, k, *whole) for k in range(8)]
        sums = [(a + b) % PRIME for (a, _), (b, _) in combinations(entries, 2)]
        assert len(set(sums)) == len(sums)
