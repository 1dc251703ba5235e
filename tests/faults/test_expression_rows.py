"""The fault checklist, J: expressions. One test a row; the number is the row's.

What the language refuses is tested in full with the parser; here the way from a model and a file.
"""

from __future__ import annotations

import builtins
import os

import pytest

from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.formats import model_from_toml
from symbody.model import Body, Model, Prismatic
from tests.effort import limited
from tests.faults.refusals import refused, refused_file, refused_model


def codes_of(text: str) -> list[str]:
    """Codes of what is wrong with a formula, as it comes through a model and through a file, with place."""
    found = refused(lambda: Body("A", mass=text))
    assert all(where.startswith("body A, mass, ") and "column " in where for _, where in found)
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    written = f'name = "a"\n\n[[body]]\nname = "A"\nmass = "{quoted}"\n'
    if text.isprintable():  # what does not print has no place in TOML
        placed = refused(lambda: model_from_toml(written, where="a.toml"))
        assert [code for code, _ in placed] == [code for code, _ in found]
        assert all(where.startswith("a.toml:5, body A, mass, ") for _, where in placed)
    return [code.removeprefix("expression.") for code, _ in found]


def test_row_99_text_is_never_run(monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[str] = []
    monkeypatch.setattr(os, "getpid", lambda: ran.append("getpid"))
    for name in ("eval", "exec", "compile", "__import__"):
        kept = getattr(builtins, name)

        def watched(*given: object, kept: object = kept, name: str = name, **named: object) -> object:
            if given and "os" in str(given[0]):
                ran.append(name)
            return kept(*given, **named)

        monkeypatch.setattr(builtins, name, watched)
    for text in (
        "__import__('os').getpid()",
        "eval(\"__import__('os')\")",
        "exec('import os')",
        "os.getpid()",
    ):
        assert codes_of(text)
    assert ran == []
    refused_file("code_in_formula", "expression.string")
    refused_file("attribute_in_formula", "expression.attribute")


def test_row_99_a_name_that_is_code_elsewhere_is_a_name() -> None:
    model = Model("names", [Body("A", mass="eval + lambda")], parameters={"eval": 1, "lambda": 2})
    assert model.body("A").mass.names == ("eval", "lambda")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("().__class__.__bases__", "attribute"), ("a.b", "attribute"), ("sin(x)[0]", "subscript"),
        ("lambda: x", "syntax"), ("(x for x in y)", "syntax"), ("[x for x in y]", "subscript"),
        ("f'{x}'", "string"), ("(x := 2)", "assignment"), ("`x`", "backtick"), ("x + \0", "control_character"),
        ("x\N{RIGHT-TO-LEFT OVERRIDE}", "control_character"), ("{x}", "braces"),
    ],
)  # fmt: skip
def test_row_100_python_that_is_no_formula(text: str, code: str) -> None:
    assert code in codes_of(text)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("9**9**9", "exponent"), ("factorial(10**6)", "unknown_function"), ("(x+y+z)**120", "exponent"),
        ("(2**64)**64", "constant_range"), ("exp(1000)", "constant_range"), ("1e400", "number"),
    ],
)  # fmt: skip
def test_row_101_what_costs_too_much_is_seen_before(text: str, code: str) -> None:
    with limited(2):  # the limit promised for any input
        assert code in codes_of(text)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("(" * 3000 + "x" + ")" * 3000, "nesting"), ("sin(" * 500 + "x" + ")" * 500, "nesting"),
        ("x**" * 3000 + "x", "nesting"), ("x+" * 10_000 + "x", "too_many_tokens"),
        ("x" + " " * 70_000, "too_many_characters"),
    ],
    ids=["brackets", "functions", "powers", "tokens", "characters"],
)  # fmt: skip
def test_row_102_depth_and_size_are_limited(text: str, code: str) -> None:
    assert code in codes_of(text)


def test_row_102_up_to_the_limits_it_works() -> None:
    deep = "(" * 200 + "m" + ")" * 200
    long = "+".join(["m"] * 10_000)  # 19,999 tokens
    model = Model("large", [Body("A", mass=deep), Body("B", mass=long)], parameters={"m": 1})
    assert all(body.mass.names == ("m",) for body in model.bodies)


@pytest.mark.parametrize(
    ("text", "fix"),
    [("2x", "write 2*x"), ("x y", "write x*y"), ("2(x+1)", "write 2*("), ("50 N/m", "remove the unit")],
)
def test_row_103_multiplication_is_written(text: str, fix: str) -> None:
    assert codes_of(text) == ["implicit_multiplication"]
    refused(lambda: Body("A", mass=text), words=fix)
    refused_file("implicit_multiplication", "expression.implicit_multiplication")


def test_row_103_a_caret_is_a_power() -> None:
    graph = Graph()
    roots = [
        build(
            Formula.from_value(text), graph, lambda name, _: graph.symbol(Symbol(name, SymbolKind.PARAMETER))
        )
        for text in ("x^2", "x**2")
    ]
    assert roots[0] == roots[1]


def test_row_104_decimal_commas() -> None:
    assert codes_of("9,81") == ["comma_decimal"]
    refused_file("decimal_comma", "expression.comma_decimal", words="write 9.81")


@pytest.mark.parametrize("text", ["1\N{MINUS SIGN}x", "\N{FULLWIDTH DIGIT ONE}-x", "1-\N{NO-BREAK SPACE}x"])
def test_row_104_variants_of_plain_characters_are_normalized(text: str) -> None:
    assert Formula.from_value(text).program[-1].kind == Formula.from_value("1-x").program[-1].kind
    assert Formula.from_value(text).names == ("x",)


@pytest.mark.parametrize("text", ["x \N{EN DASH} 1", "x\N{SUPERSCRIPT TWO}", "a\N{MULTIPLICATION SIGN}b"])
def test_row_104_other_characters_are_refused(text: str) -> None:
    assert codes_of(text) == ["character"]


def test_row_104_a_refused_formula_leaves_the_rest_of_the_model_alone() -> None:
    good = Body("A", mass="m")
    assert refused_model(good, Prismatic("j", "ground", "A", coordinate="x"), parameters={"m": "1,5"}) == [
        ("expression.comma_decimal", "model, parameters.m, column 2")
    ]
    assert Model("good", [good], parameters={"m": "1.5"}).body("A") == good
