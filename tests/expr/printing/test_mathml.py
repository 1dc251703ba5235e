"""Formulas as MathML: well-formed, of the structure of the LaTeX, broken where they are long."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import make
from symbody.expr.expression import Expr, cos, sin, sqrt
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.printing.latex import to_latex
from symbody.expr.printing.mathml import mathml_name, to_mathml, to_mathml_with_definitions
from symbody.expr.printing.mathml_tables import break_rows, math_element, mathml_equations, mathml_matrix
from tests.expr.printing.test_latex import Names
from tests.expr.strategies import Sample, both_tiers, built, samples

TIMES = '<mo lspace="0" rspace="0.17em">\u2062</mo>'
# Children of the elements that take a fixed number of them.
CHILDREN = {"mfrac": 2, "msup": 2, "msub": 2, "mover": 2}

CASES: list[tuple[Callable[[Names], Expr], str]] = [
    (lambda n: n.x_dot, '<mover><mi>x</mi><mo>\u02d9</mo></mover>'),
    (lambda n: n.m * n.x_ddot,
     f'<mi>m</mi>{TIMES}<mover><mi>x</mi><mo>\u00a8</mo></mover>'),
    (lambda n: n.beta_1, "<msub><mi>β</mi><mn>1</mn></msub>"),
    (lambda n: -n.k * n.x, f'<mo form="prefix">\u2212</mo><mi>k</mi>{TIMES}<mi>x</mi>'),
    (lambda n: n.x / n.l, "<mfrac><mi>x</mi><mi>l</mi></mfrac>"),
    (lambda n: n.x**2, "<msup><mi>x</mi><mn>2</mn></msup>"),
    (lambda n: sqrt(n.x), "<msqrt><mi>x</mi></msqrt>"),
    (lambda n: sin(n.theta) ** 2,
     "<msup><mi>sin</mi><mn>2</mn></msup><mo>\u2061</mo><mrow><mo>(</mo><mi>θ</mi><mo>)</mo></mrow>"),
    (lambda n: n.k * (n.x - n.l),
     f"<mi>k</mi>{TIMES}<mrow><mo>(</mo><mi>x</mi><mo>\u2212</mo><mi>l</mi><mo>)</mo></mrow>"),
    (lambda n: n.pi * n.l, f"<mi>π</mi>{TIMES}<mi>l</mi>"),
]  # fmt: skip


def parsed(formula: str) -> Element:
    return ElementTree.fromstring(f"<mrow>{formula}</mrow>")


def counted(formula: str) -> Counter[str]:
    return Counter(element.tag for element in parsed(formula).iter())


@pytest.mark.parametrize("case", range(len(CASES)))
def test_elements_of_formulas(case: int) -> None:
    make_value, expected = CASES[case]
    names = Names()
    assert to_mathml(names.graph, make_value(names).index) == expected


def test_choices_are_cases() -> None:
    names = Names()
    formula = to_mathml(names.graph, names.stop(names.x, names.k).index)
    rows = [[cell.text or "" for cell in row.iter("mtext")] for row in parsed(formula).iter("mtr")]
    assert rows == [["if "], ["if "], ["otherwise"]]
    assert "<mo>&lt;</mo>" in formula


@both_tiers
@given(samples())
def test_random_formulas_have_the_structure_of_their_latex(sample: Sample) -> None:
    graph = Graph()
    node = built(sample.program, graph)[-1]
    formula, latex = to_mathml(graph, node), to_latex(graph, node)
    tags = counted(formula)
    pairs = {"mfrac": r"\frac{", "msqrt": r"\sqrt{", "mtable": r"\begin{cases}"}
    assert {tag: tags[tag] for tag in pairs} == {tag: latex.count(text) for tag, text in pairs.items()}
    assert formula.count("<mo>(</mo>") == formula.count("<mo>)</mo>") == latex.count(r"\left(")
    for element in parsed(formula).iter():
        assert len(element) == CHILDREN.get(element.tag, len(element)), element.tag


@given(st.text(min_size=1, max_size=12))
@example("<script>alert(1)</script>")
@example("a&b_c<d")
@example("\x00\x1b\x7f")
def test_no_name_becomes_an_element(name: str) -> None:
    tags = counted(mathml_name(name))
    assert set(tags) <= {"mrow", "mi", "mn", "mo", "msub"}
    assert "\x00" not in mathml_name(name)


def test_names_of_the_caller() -> None:
    names = Names()
    given_names = {Symbol("x", SymbolKind.COORDINATE): "<mi>X</mi>"}
    formula = to_mathml(names.graph, names.x_dot.index, given_names)
    assert formula == "<mover><mi>X</mi><mo>\u02d9</mo></mover>"


def test_shared_parts_are_defined() -> None:
    names = Names()
    part = sin(names.x + names.y)
    total = part * part + cos(part)
    (formula,), definitions = to_mathml_with_definitions(names.graph, [total.index], 2)
    assert [name for name, _ in definitions] == ["<msub><mi>z</mi><mn>1</mn></msub>"]
    assert formula.count("<mi>z</mi>") == 2


def test_formulas_that_are_too_long_are_refused() -> None:
    graph = Graph()
    x = graph.symbol(Symbol("x", SymbolKind.COORDINATE))
    deep = x
    for _ in range(20):
        deep = make(graph, op.MUL, (make(graph, op.ADD, (deep, x)), deep))
    with pytest.raises(ExpressionError, match="written out the formula has"):
        to_mathml(graph, deep)


def test_long_equations_are_broken_at_their_terms() -> None:
    names = Names()
    terms = [getattr(names, f"k_{k}") * names.x for k in range(40)]
    total = sum(terms[1:], terms[0])
    formula = to_mathml(names.graph, total.index)
    rows = break_rows(formula, 30)
    assert len(rows) > 3
    assert sum(counted(row)["mo"] for row in rows) == counted(formula)["mo"]
    assert all(parsed(row)[1].text == "+" for row in rows[1:])
    table = parsed(mathml_equations([(to_mathml(names.graph, names.x_ddot.index), formula)], 30))
    cells = [["".join(cell.itertext()) for cell in row] for row in table.iter("mtr")]
    assert [row[1] for row in cells] == ["=", *[""] * (len(rows) - 1)]
    assert all(row[2] for row in cells)


def test_matrices_and_pages() -> None:
    table = parsed(mathml_matrix([["<mi>a</mi>", "<mn>0</mn>"], ["<mn>1</mn>", "<mi>b</mi>"]]))
    assert [[cell[0].text for cell in row] for row in table.iter("mtr")] == [["a", "0"], ["1", "b"]]
    root = ElementTree.fromstring(math_element("<mi>x</mi>", block=True))
    assert root.tag == "{http://www.w3.org/1998/Math/MathML}math"
    assert root.get("display") == "block"
