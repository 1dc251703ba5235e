"""Names of elements and of symbols."""

from __future__ import annotations

import pytest

from symbody.expr.language.formula import Formula
from symbody.model.naming import element_problem, make_symbol, symbol_problem

# Words of Python, C, SymPy and of the expression language's functions: only names here.
WORDS = """I E S N O Q beta gamma zeta lambda Lambda re im sign test sum max True None nan inf oo e j class
    double register main int void import qdd1 sin x_1 _ θ μ_s Ω""".split()


@pytest.mark.parametrize("name", WORDS)
def test_any_word_is_a_symbol(name: str) -> None:
    assert symbol_problem(name, "here") is None
    assert Formula.from_value(f"2*{name} + 1").names == (name,)


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("t", "names.reserved"),
        ("pi", "names.reserved"),
        ("if", "names.keyword"),
        ("not", "names.keyword"),
        ("", "names.empty"),
        ("  ", "names.empty"),
        ("12", "names.digits"),
        ("1x", "names.not_a_symbol"),
        ("x_{1}", "names.not_a_symbol"),
        ("q1'", "names.not_a_symbol"),
        ("a b", "names.not_a_symbol"),
        ("a.b", "names.not_a_symbol"),
        ("🙂", "names.not_a_symbol"),
        (" x", "names.blank"),
        ("x\u202ey", "names.control_character"),
        ("x\ny", "names.control_character"),
        ("x\0", "names.control_character"),
        ("x" * 129, "names.too_long"),
        (3, "names.not_text"),
    ],
)
def test_illegal_symbol(name: object, code: str) -> None:
    problem = symbol_problem(name, "input 3")
    assert problem is not None
    assert (problem.code, problem.where) == (code, "input 3")
    assert problem.fix and problem.what.isprintable()


def test_longest_name_is_legal() -> None:
    assert symbol_problem("x" * 128, "") is None
    assert element_problem("x" * 128, "") is None


@pytest.mark.parametrize(
    "name", ["upper arm", "Käfer", "🙂 wheel", "lambda", "a-b", "x_{1}", "t", "4-bar", "轴"]
)
def test_elements_may_be_called_almost_anything(name: str) -> None:
    assert element_problem(name, "") is None


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("ground", "names.reserved"),
        ("GROUND", "names.reserved"),
        ("a.b", "names.mark"),
        ('a"b', "names.mark"),
        ("a'b", "names.mark"),
        ("", "names.empty"),
        ("7", "names.digits"),
        ("a\tb", "names.control_character"),
        ("\u200bx", "names.control_character"),
        ("a ", "names.blank"),
        (None, "names.not_text"),
    ],
)
def test_illegal_element_name(name: object, code: str) -> None:
    problem = element_problem(name, "body")
    assert problem is not None and problem.code == code and problem.fix


@pytest.mark.parametrize(
    ("name", "symbol"),
    [
        ("slider", "slider"),
        ("upper arm", "upper_arm"),
        ("4-bar", "_4_bar"),
        ("t", "_t"),
        ("if", "_if"),
        ("a🙂", "a_"),
    ],
)
def test_symbol_from_an_element_name(name: str, symbol: str) -> None:
    assert make_symbol(name) == symbol
    assert symbol_problem(make_symbol(name), "") is None
