"""Formulas as MathML: well-formed, of the structure of the LaTeX, broken where they are long."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from symbody.errors import ExpressionError
from symbody.expr import opcodes as op
from symbody.expr.canonical import make
from symbody.expr.expression import Expr, cos, number, sin, sqrt
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.printing.equation_layout import entry_names, equations_html, matrix_html
from symbody.expr.printing.latex import to_latex
from symbody.expr.printing.mathml import mathml_name, to_mathml, to_mathml_with_definitions
from symbody.expr.printing.mathml_tables import math_element, mathml_matrix
from symbody.expr.printing.numerals import Numerals
from tests.expr.printing.test_latex import Names
from tests.expr.strategies import Sample, both_tiers, built, samples

TIMES = '<mo lspace="0" rspace="0.17em">\u2062</mo>'
SPACE = "{http://www.w3.org/1998/Math/MathML}"
# Children of the elements that take a fixed number of them.
CHILDREN = {"mfrac": 2, "msup": 2, "msub": 2, "mover": 2}

CASES: list[tuple[Callable[[Names], Expr], str]] = [
    (lambda n: n.x_dot, '<mover accent="true"><mi>x</mi><mo stretchy="false">\u02d9</mo></mover>'),
    (lambda n: n.m * n.x_ddot,
     f'<mi>m</mi>{TIMES}<mover accent="true"><mi>x</mi><mo stretchy="false">\u00a8</mo></mover>'),
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
    assert formula == '<mover accent="true"><mi>X</mi><mo stretchy="false">\u02d9</mo></mover>'


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


def test_equations_may_be_broken_between_terms_and_inside_long_brackets() -> None:
    names = Names()
    terms = [getattr(names, f"k_{k}") * names.x for k in range(12)]
    inner = sum(terms[1:], terms[0])
    formula = to_mathml(names.graph, (sin(names.y) * inner + names.m).index)
    page = equations_html([(formula, "<mn>0</mn>")], ["holds"])
    rows = ElementTree.fromstring(page)
    assert [row.get("class") for row in rows] == ["sb-equation"]
    (row,) = rows
    outer = [part for part in row if "sb-term" in (part.get("class") or "")]
    assert len(outer) == 3  # two terms, and "= 0"
    (long,) = (part for part in outer if part.get("class") == "sb-term sb-long")
    assert len(long) == 12 and all(part.get("class") == "sb-term" for part in long)
    read = "".join(text for text in row.itertext() if text != "\u2062")
    whole = "".join(ElementTree.fromstring(f"<p>{formula}</p>").itertext()).replace("\u2062", "")
    assert read.replace("\u2062", "") == f"{whole}=0 (holds)"


@pytest.mark.parametrize("long", [False, True])
def test_a_wide_symmetric_matrix_is_drawn_of_names_with_its_upper_triangle(long: bool) -> None:
    entry = "<mi>a</mi>" if not long else "<mo>+</mo>".join(["<mi>abcdefg</mi>"] * 8)
    rows = [[entry, entry, "<mn>0</mn>"], [entry, "<mn>1</mn>", entry], ["<mn>0</mn>", entry, entry]]
    root = ElementTree.fromstring(f"<p>{matrix_html('<mi>M</mi>', rows, entry_names('M', 3, 3))}</p>")
    listed = [row for row in root.iter("div") if row.get("class") == "sb-equation"]
    assert len(listed) == (5 if long else 0)
    drawn = ["".join(cell.itertext()) for cell in root.iter(f"{SPACE}mtd")]
    assert drawn == (
        ["M11", "M12", "0", "M12", "M22", "M23", "0", "M23", "M33"] if long else list("aa0a1a0aa")
    )


def test_rounded_numbers_bear_their_full_value() -> None:
    names = Names()
    node = (names.m * 2.899053227347741 + names.x * number(names.graph, Fraction("9.81234567"))).index
    numerals = Numerals(6, frozenset({Fraction("9.81234567")}))
    (formula,), _ = to_mathml_with_definitions(names.graph, [node], numerals=numerals)
    assert '<mn data-full="2.899053227347741">2.89905</mn>' in formula and "<mn>9.81234567</mn>" in formula
    assert 'title="2.89905 = 2.899053227347741"' in equations_html([(formula, "<mn>0</mn>")])
    assert "data-full" not in to_mathml(names.graph, node)


def test_matrices_and_pages() -> None:
    table = parsed(mathml_matrix([["<mi>a</mi>", "<mn>0</mn>"], ["<mn>1</mn>", "<mi>b</mi>"]]))
    assert [[cell[0].text for cell in row] for row in table.iter("mtr")] == [["a", "0"], ["1", "b"]]
    root = ElementTree.fromstring(math_element("<mi>x</mi>", block=True))
    assert root.tag == "{http://www.w3.org/1998/Math/MathML}math"
    assert root.get("display") == "block"
