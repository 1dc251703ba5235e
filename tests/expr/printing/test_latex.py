"""Formulas for people: the order of a textbook, plain text and LaTeX."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import add, apply, make, mul, neg, power, select
from symbody.expr.expression import Expr, atan2, cos, maximum, sin, sqrt, symbol
from symbody.expr.graph import TIME, Graph, KernelNode, Symbol, SymbolKind
from symbody.expr.printing.latex import (
    latex_name,
    to_display,
    to_display_with_definitions,
    to_latex,
    to_latex_with_definitions,
)
from symbody.expr.printing.textbook import name_key
from tests.expr.strategies import Sample, both_tiers, built, built_shuffled, samples

HALF = Fraction(1, 2)


class Names:
    """Expressions of one graph by name: coordinates with `_dot` and `_ddot`, an input F, a speed omega."""

    COORDINATES = ("x", "y", "theta", "beta_1")

    def __init__(self) -> None:
        self.graph = Graph()

    def __getattr__(self, name: str) -> Expr:
        base, _, dots = name.rpartition("_d")
        if base in self.COORDINATES and dots.endswith("ot"):
            return symbol(self.graph, Symbol(base, SymbolKind.COORDINATE, len(dots) - 1))
        kinds = {"F": SymbolKind.INPUT, "omega": SymbolKind.SPEED, "lambda_1": SymbolKind.MULTIPLIER}
        kind = SymbolKind.COORDINATE if name in self.COORDINATES else kinds.get(name, SymbolKind.PARAMETER)
        return symbol(self.graph, Symbol(name, kind))

    @property
    def t(self) -> Expr:
        return symbol(self.graph, TIME)

    @property
    def pi(self) -> Expr:
        return Expr(self.graph, self.graph.pi())

    def stop(self, x: Expr, k: Expr) -> Expr:
        """A stop at 0 with stiffness k, and a soft one before."""
        deep = make(self.graph, op.LT, (x.index, 0))
        near = make(self.graph, op.LT, (x.index, self.l.index))
        soft = select(self.graph, near, (HALF * k * x).index, 0)
        return Expr(self.graph, select(self.graph, deep, (k * x).index, soft))


CASES: list[tuple[Callable[[Names], Expr], str, str]] = [
    (lambda n: n.k * n.x + n.d * n.x_dot + n.m * n.x_ddot, "m x'' + d x' + k x",
     r"m \, \ddot{x} + d \, \dot{x} + k \, x"),
    (lambda n: n.F - n.k * n.x - n.d * n.x_dot, "F - d x' - k x", r"F - d \, \dot{x} - k \, x"),
    (lambda n: n.m * n.l**2 * n.theta_ddot + n.m * n.g * n.l * sin(n.theta) + n.d * n.theta_dot,
     "m l^2 theta'' + d theta' + m g l sin(theta)",
     r"m \, l^{2} \, \ddot{\theta} + d \, \dot{\theta} + m \, g \, l \, \sin\left(\theta\right)"),
    (lambda n: n.m1 * n.l1**2 + n.I1 + n.m2 * (n.l1**2 + n.l2**2 + 2 * n.l1 * n.l2 * cos(n.beta_1)),
     "I1 + m1 l1^2 + m2 (l1^2 + l2^2 + 2 l1 l2 cos(beta_1))",
     r"I_{1} + m_{1} \, l_{1}^{2} + m_{2} \, \left(l_{1}^{2} + l_{2}^{2} + 2 \, l_{1} \, l_{2} \, "
     r"\cos\left(\beta_{1}\right)\right)"),
    (lambda n: HALF * n.m * n.x_dot**2, "m x'^2/2", r"\frac{1}{2} \, m \, \dot{x}^{2}"),
    (lambda n: n.k * n.x / (2 * n.m), "k x/(2 m)", r"\frac{k \, x}{2 \, m}"),
    (lambda n: n.k * (n.x - n.l), "k (x - l)", r"k \, \left(x - l\right)"),
    (lambda n: -n.k * n.x, "-k x", r"-k \, x"),
    (lambda n: -(n.x - n.y), "y - x", "y - x"),
    (lambda n: 1 - cos(n.theta), "1 - cos(theta)", r"1 - \cos\left(\theta\right)"),
    (lambda n: n.l * cos(n.theta) + n.x, "x + l cos(theta)", r"x + l \, \cos\left(\theta\right)"),
    (lambda n: cos(n.theta) * sin(n.theta) ** 2 * (n.l + n.a),
     "(a + l) sin(theta)^2 cos(theta)",
     r"\left(a + l\right) \, \sin^{2}\left(\theta\right) \, \cos\left(\theta\right)"),
    (lambda n: sqrt(n.x**2 + n.l**2), "sqrt(x^2 + l^2)", r"\sqrt{x^{2} + l^{2}}"),
    (lambda n: (n.a + n.b) / (n.a - n.b), "(a + b)/(a - b)", r"\frac{a + b}{a - b}"),
    (lambda n: 1 / n.m, "1/m", r"\frac{1}{m}"),
    (lambda n: (n.x / n.l) ** 2, "x^2/l^2", r"\frac{x^{2}}{l^{2}}"),
    (lambda n: n.x / n.x, "x/x", r"\frac{x}{x}"),
    (lambda n: (n.x * n.k) ** HALF * 3, "3 sqrt(k x)", r"3 \, \sqrt{k \, x}"),
    (lambda n: n.x ** Fraction(2, 3), "x^(2/3)", r"x^{\frac{2}{3}}"),
    (lambda n: n.x ** (n.a + 1), "x^(a + 1)", r"x^{a + 1}"),
    (lambda n: (n.x + 1) ** n.a, "(x + 1)^a", r"\left(x + 1\right)^{a}"),
    (lambda n: 2 * n.pi * n.r * n.t, "2 pi r t", r"2 \, \pi \, r \, t"),
    (lambda n: Fraction(981, 100) * n.x - Fraction(1, 3), "9.81 x - 1/3", r"9.81 \, x - \frac{1}{3}"),
    (lambda n: 2.5e-8 * n.x, "2.5e-08 x", r"2.5 \cdot 10^{-8} \, x"),
    (lambda n: Fraction(1, 10**20) * n.x, "1e-20 x", r"10^{-20} \, x"),
    (lambda n: Fraction(3, 4) * (n.x + n.l), "3 (x + l)/4", r"\frac{3}{4} \, \left(x + l\right)"),
    (lambda n: n.I1 * n.omega * n.x_dot, "I1 omega x'", r"I_{1} \, \omega \, \dot{x}"),
    (lambda n: n.stop(n.x, n.k), "if(x < 0, k x, if(x < l, k x/2, 0))",
     r"\begin{cases} k \, x & \text{if}\ x < 0 \\ \frac{1}{2} \, k \, x & \text{if}\ x < l \\ "
     r"0 & \text{otherwise} \end{cases}"),
    (lambda n: abs_of(n.x) * maximum(n.x, n.a), "max(x, a) abs(x)",
     r"\max\left(x, a\right) \, \left|x\right|"),
    (lambda n: atan2(n.y, n.x) ** 2, "atan2(y, x)^2", r"\operatorname{atan2}\left(y, x\right)^{2}"),
    (lambda n: n.lambda_1 * n.a, "a lambda_1", r"a \, \lambda_{1}"),
    (lambda n: n.a - n.a * n.b + (n.a * n.b - n.a), "0", "0"),
]  # fmt: skip


def abs_of(x: Expr) -> Expr:
    return x.apply(op.ABS)


@pytest.mark.parametrize(("formula", "plain", "latex"), CASES, ids=[case[1] for case in CASES])
def test_formula(formula: Callable[[Names], Expr], plain: str, latex: str) -> None:
    node = formula(Names())
    assert to_display(node.graph, node.index) == plain
    assert to_latex(node.graph, node.index) == latex


@pytest.mark.parametrize("latex", [case[2] for case in CASES if "cases" not in case[2]])
def test_latex_is_accepted_by_a_renderer(latex: str) -> None:
    picture = MathTextParser("path").parse(f"${latex}$")
    assert picture.width > 0 and picture.height > 0 and picture.glyphs


@both_tiers
@given(samples(), st.randoms(use_true_random=False))
def test_display_does_not_depend_on_when_nodes_were_made(sample: Sample, rng: random.Random) -> None:
    first, second = Graph(), Graph()
    node = built(sample.program, first)[-1]
    other = built_shuffled(sample.program, second, rng)
    assert to_display(first, node) == to_display(second, other)
    assert to_latex(first, node) == to_latex(second, other)


@both_tiers
@given(samples())
def test_brackets_and_braces_are_balanced(sample: Sample) -> None:
    graph = Graph()
    latex = to_latex(graph, built(sample.program, graph)[-1])
    bare = latex.replace(r"\left(", "").replace(r"\right)", "")
    assert latex.count(r"\left(") == latex.count(r"\right)")
    assert not set(bare) & set("()")
    depth = 0
    for character in latex:
        depth += (character == "{") - (character == "}")
        assert depth >= 0
    assert depth == 0


@pytest.mark.parametrize(
    ("relation", "plain", "latex"),
    [
        ((op.LT, "x", "y"), "x < y", "x < y"),
        ((op.LE, "x", "y"), "x <= y", r"x \le y"),
        ((op.LT, 0, "x"), "x > 0", "x > 0"),
        ((op.LE, 0, "x"), "x >= 0", r"x \ge 0"),
        ((op.EQ, "x", "y"), "x == y", "x = y"),
        ((op.NOT, (op.EQ, "x", "y")), "x != y", r"x \ne y"),
        ((op.NOT, (op.LT, "x", "y")), "not x < y", r"\neg x < y"),
        ((op.AND, (op.LT, "x", "y"), (op.OR, (op.LT, "y", "x"), (op.LT, 1, "x"))),
         "(y < x or x > 1) and x < y", r"\left(y < x \vee x > 1\right) \wedge x < y"),
        ((op.NOT, (op.AND, (op.LT, "x", "y"), (op.LT, "y", "x"))),
         "not (x < y and y < x)", r"\neg \left(x < y \wedge y < x\right)"),
    ],
)  # fmt: skip
def test_conditions(relation: tuple[object, ...], plain: str, latex: str) -> None:
    graph = Graph()

    def node(item: object) -> int:
        if isinstance(item, tuple):
            return apply(graph, item[0], *map(node, item[1:]))
        return graph.symbol(Symbol(item)) if isinstance(item, str) else graph.constant(int(str(item)))

    # Beside another condition, since a choice with a negated one is turned round.
    choice = select(graph, node((op.AND, relation, (op.LT, "p", "q"))), graph.constant(1), 0)
    # The order of conditions that commute follows their hashes.
    assert words(to_display(graph, choice)) == words(f"if({plain} and p < q, 1, 0)")
    condition = rf"{latex} \wedge p < q"
    whole = rf"\begin{{cases}} 1 & \text{{if}}\ {condition} \\ 0 & \text{{otherwise}} \end{{cases}}"
    assert words(to_latex(graph, choice)) == words(whole)


def words(text: str) -> list[str]:
    return sorted(re.findall(r"\\?\w+|\S", text))


def test_derivatives_of_any_order() -> None:
    graph = Graph()
    nodes = [graph.symbol(Symbol("x_1", SymbolKind.COORDINATE, order)) for order in range(6)]
    assert [to_display(graph, node) for node in nodes] == ["x_1" + "'" * order for order in range(6)]
    dots = ["x_{1}", r"\dot{x_{1}}", r"\ddot{x_{1}}", r"\dddot{x_{1}}", r"\ddddot{x_{1}}", "{x_{1}^{(5)}}"]
    assert [to_latex(graph, node) for node in nodes] == dots


def test_names_given_are_used_and_dotted() -> None:
    n = Names()
    names = {
        Symbol("x", SymbolKind.COORDINATE): r"\xi",
        Symbol("x", SymbolKind.COORDINATE, 2): "a",
        Symbol("k"): "k_s",
    }
    node = (n.m * n.x_ddot + n.d * n.x_dot + n.k * n.x).index
    assert to_latex(n.graph, node, names) == r"m \, a + d \, \dot{\xi} + k_s \, \xi"


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("x", "x"), ("m1", "m_{1}"), ("beta_1", r"\beta_{1}"), ("Omega", r"\Omega"),
        ("Alpha", r"\mathrm{Alpha}"),
        ("lambda_rod_2", r"\lambda_{\mathrm{rod},2}"), ("l12_x", "l_{12,x}"), ("mass", r"\mathrm{mass}"),
        ("pi", r"\mathrm{pi}"), ("I", "I"), ("theta_dot", r"\theta_{\mathrm{dot}}"), ("_x", r"\mathrm{\_x}"),
        ("x_{1}", r"x_{\mathrm{\{1\}}}"), ("a b", r"\mathrm{a\ b}"), ("q1'", r"\mathrm{q1{\prime}}"),
        ("100%", r"\mathrm{100\%}"),
        ("\u03b8", r"{\theta}"), ("\u03bb1", r"{\lambda}_{1}"), ("\u0416", "\u0416"), ("\u202e", "{U202E}"),
    ],
)  # fmt: skip
def test_latex_names(name: str, latex: str) -> None:
    assert latex_name(name) == latex


@both_tiers
@given(st.text(st.characters(codec="utf-8"), min_size=1, max_size=12))
@example(r"\input{/etc/passwd}")
@example(r"\href{javascript:alert(1)}{x}")
@example("x$ $^^5c")
def test_no_name_becomes_a_command(name: str) -> None:
    latex = latex_name(name)
    letters = r"mathrm|backslash|wedge|sim|prime|" + "|".join(GREEK)
    rest = re.sub(rf"\\(?:(?:{letters})(?![A-Za-z])|[{{}}$&#%_ ])", "", latex)
    assert not set(rest) & set("\\$&#%~")
    assert "^" not in rest
    assert rest.count("{") == rest.count("}")


GREEK = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau upsilon phi chi "
    "psi omega pi Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split()
)


def test_names_are_sorted_as_people_count() -> None:
    names = ["x10", "x2", "l", "g", "m2", "m10", "I", "a", "mu", "B"]
    assert sorted(names, key=name_key) == ["m2", "m10", "I", "g", "a", "B", "l", "mu", "x2", "x10"]


def test_functions_of_the_user_are_written_by_their_names() -> None:
    n = Names()
    graph = n.graph
    table = graph.function(Torque("load_curve"))
    node = graph.many(op.CALL, ((n.x + n.a).index,), table)
    assert to_display(graph, node) == "load_curve(x + a)"
    assert to_latex(graph, power(graph, node, 2)) == r"\operatorname{load\_curve}\left(x + a\right)^{2}"


class Torque:
    """A function of the user."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self, *arguments: float) -> float:
        return sum(arguments)

    def derivative(self, position: int) -> Torque:
        return Torque(f"{self.name}_{position}")


def test_a_long_sum_takes_linear_time() -> None:
    graph = Graph()
    total = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    for k in range(19_000):
        total = add(graph, total, graph.symbol(Symbol(f"a{k}")))
    text = to_display(graph, total)
    assert text.startswith("x + a0 + a1 + a2 + ") and text.endswith(" + a18999")


def test_a_deep_formula_is_written_without_recursion() -> None:
    graph = Graph()
    node = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    for _ in range(5000):
        node = apply(graph, op.TANH, node)
    assert to_display(graph, node) == "tanh(" * 5000 + "x" + ")" * 5000
    assert to_latex(graph, node).startswith(r"\tanh\left(" * 5000)


def test_definitions_are_named_and_used() -> None:
    n = Names()
    graph = n.graph
    shared = (n.m * n.l**2 + n.I1).index
    root = mul(graph, shared, apply(graph, op.SIN, shared))
    assert to_display_with_definitions(graph, [root, neg(graph, shared)], 0) == (
        ["z1 sin(z1)", "-z1"],
        [("z1", "I1 + m l^2")],
    )
    texts, definitions = to_latex_with_definitions(graph, [root], 0)
    assert texts == [r"z_{1} \, \sin\left(z_{1}\right)"]
    assert definitions == [("z_{1}", r"I_{1} + m \, l^{2}")]
    assert to_display_with_definitions(graph, [shared]) == (["I1 + m l^2"], [])


def test_what_has_no_formula_is_an_error() -> None:
    n = Names()
    graph = n.graph
    entry = graph.node(
        op.PICK, graph.many(op.SADDLE, (n.m.index, n.F.index), graph.kernel(KernelNode(1, 0))), 0
    )
    node = n.x
    for _ in range(15):
        node = sin(node) * node + n.a
    for show in (to_display, to_latex):
        with pytest.raises(ExpressionError, match="no_formula"):
            show(graph, entry)
        with pytest.raises(ExpressionError, match="98301 operations"):
            show(graph, node.index)
