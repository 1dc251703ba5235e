"""The fault checklist, B: names. One test a row; the number is the row's."""

from __future__ import annotations

import ast

import numpy as np
import pytest

from symbody.codegen.compile import compile, generate_code
from symbody.equations.form import form_equations
from symbody.expr.graph import Kind, Symbol
from symbody.model import Body, Drive, Frame, Model, Prismatic
from tests.faults.refusals import refused_file, refused_model

# Constants, functions and keywords elsewhere: of SymPy, Python, C, and of the papers.
ELSEWHERE = [
    "I", "E", "S", "N", "O", "Q", "beta", "gamma", "zeta", "Lambda", "re", "im", "sign", "test", "sum", "max",
    "lambda", "True", "None", "nan", "inf", "oo", "e", "j", "Symbol", "double", "register", "main", "int", "for",
    "return", "class", "def", "static", "udot", "q", "u", "r", "p", "qdd1", "z1", "work", "numpy", "restrict",
]  # fmt: skip


def oscillator(stiffness: str, coordinate: str = "x") -> Model:
    """A unit mass on a spring whose stiffness, 4 N/m, has the name given."""
    mass = Prismatic(
        "slider", "ground", Body("Mass", mass=1), coordinate=coordinate, force=Drive(stiffness=stiffness)
    )
    return Model("oscillator", [mass], parameters={stiffness: 4})


@pytest.mark.parametrize("name", ELSEWHERE)
def test_row_19_and_20_and_23_words_of_other_languages_are_names(name: str) -> None:
    eqs = form_equations(oscillator(name))
    assert compile(eqs, "udot")(0.0, [0.5], [0.0]) == pytest.approx([-2.0], rel=1e-15)
    stiffness = next(symbol for symbol in eqs.forcing.free_symbols if str(symbol) == name)
    assert stiffness.is_Symbol and eqs.forcing.diff(stiffness)[0] == -eqs.coordinates[0]
    ast.parse(generate_code(eqs, ["udot"], language="python"))  # keywords are not left in it


@pytest.mark.parametrize("name", ["I", "lambda", "double", "E", "test", "qdd1"])
def test_row_19_coordinates_too(name: str) -> None:
    eqs = form_equations(oscillator("k", coordinate=name))
    assert eqs.coordinate_names == (name,)
    assert compile(eqs, "udot")(0.0, [0.5], [0.0]) == pytest.approx([-2.0], rel=1e-15)


def test_row_19_time_and_pi_are_taken() -> None:
    for name in ("t", "pi"):
        assert refused_model(parameters={name: 1}) == [("names.reserved", f"model, parameters.{name}")]


@pytest.mark.parametrize("name", ["if", "and", "or", "not"])
def test_row_19_words_of_the_language_are_taken(name: str) -> None:
    assert refused_model(parameters={name: 1}) == [("names.keyword", f"model, parameters.{name}")]


@pytest.mark.parametrize("name", ["upper arm", "bras supérieur", "腕", "x_{1}", "q1-", "🦾"])
def test_row_20_elements_are_shown_as_named(name: str) -> None:
    slider = Prismatic(name, "ground", Body(f"{name} body", mass=2), axis="x")
    eqs = form_equations(Model("arm", [slider]))
    text = generate_code(eqs, ["udot"], language="c")
    assert text.isascii() or name not in text  # comments may quote, identifiers are plain
    assert compile(eqs, f'reaction "{name}"')(0.0, [0.0], [0.0]).shape == (6,)


@pytest.mark.parametrize("name", ["a\u202eb", "a\nb", "a\x00b", "a\u200bb"])
def test_row_20_what_does_not_print_is_refused(name: str) -> None:
    assert refused_model(parameters={name: 1})[0][0] == "names.control_character"
    assert refused_model(inputs=[name])[0][0] == "names.control_character"


@pytest.mark.parametrize("name", ["x_{1}", "q1'", "a b", "2x", "a-b"])
def test_row_20_symbols_must_fit_into_formulas(name: str) -> None:
    assert refused_model(parameters={name: 1}) == [("names.not_a_symbol", f"model, parameters.{name}")]


def test_row_21_names_that_look_alike_stay_apart() -> None:
    bodies = [Body("A"), Body("a"), Body("a b", mass=1), Body("a_b", mass=1)]
    joints = [
        Prismatic("s 1", "ground", "a b", coordinate="x"),
        Prismatic("s_1", "ground", "a_b", coordinate="X"),
    ]
    eqs = form_equations(Model("alike", [*bodies[2:], *joints], inputs=["f", "F"]))
    assert eqs.coordinate_names == ("x", "X") and eqs.input_names == ("f", "F")
    assert len(Model("alike", [*bodies, *joints]).bodies) == 4
    # Unnamed coordinates are made from the names of joints: these would be one.
    unnamed = [Prismatic("s 1", "ground", "a b"), Prismatic("s_1", "ground", "a_b")]
    assert refused_model(*bodies[2:], *unnamed)[0][0] == "names.duplicate"


def test_row_22_one_name_is_one_symbol() -> None:
    assert refused_model(parameters={"h": 1}, inputs=["h"])[0][0] == "names.duplicate"
    assert Symbol("h", Kind.PARAMETER) == Symbol("h", Kind.PARAMETER)
    eqs = form_equations(oscillator("k"))
    (stiffness,) = [symbol for symbol in eqs.forcing.free_symbols if str(symbol) == "k"]
    assert stiffness.assumptions0 == type(stiffness)("k").assumptions0


def test_row_24_very_long_names() -> None:
    assert refused_model(parameters={"a" * 10_000: 1}, words="at most 128")[0][0] == "names.too_long"
    assert form_equations(oscillator("k" * 128)).parameter_names == ("k" * 128,)


def test_row_25_names_that_are_none() -> None:
    for name, code in (("", "names.empty"), ("  ", "names.empty"), ("12", "names.digits")):
        assert refused_model(parameters={name: 1})[0][0] == code
        assert refused_model(inputs=[name])[0][0] == code
    with pytest.raises(Exception, match="only digits"):
        Body("12")
    with pytest.raises(Exception, match="the name is empty"):
        Body("A", frames={"": Frame()})


def test_row_19_files_name_the_line() -> None:
    refused_file("duplicate_body", "names.duplicate")
    assert np.isfinite(compile(form_equations(oscillator("nan")), "udot")(0.0, [1.0], [0.0])).all()
