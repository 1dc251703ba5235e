"""The fault checklist, B: names. One test a row; the number is the row's."""

from __future__ import annotations

import ast
from builtins import compile as builtins_compile

import numpy as np
import pytest
from sympy.core.function import AppliedUndef, Derivative

from symbody.codegen.compile import compile
from symbody.equations.form import form_equations
from symbody.expr.graph import Symbol, SymbolKind
from symbody.model import Body, Drive, Frame, Model, Prismatic, Revolute
from symbody.simulation.programs.generate_code import generate_code
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


def test_row_23_names_that_generated_code_would_choose() -> None:
    """Definitions of closed forms, temporaries of code and derivatives step aside, and values stay right."""
    names = {"z1": 0.7, "z2": 1.3, "x_ddot_0": 0.4, "t1": 2.0, "out": 0.3}
    length, mass, inertia, gravity, damping = names
    frames = {"top": Frame(at=(0, 0, length)), "end": Frame(at=(length, 0, f"-{length}"))}
    count = 6  # enough for closed forms in definitions
    bodies = [
        Body(f"B{k}", mass, (inertia, f"2*{inertia}", f"2*{inertia}"), frames=frames) for k in range(count)
    ]
    joints = [
        Revolute(f"J{k}", f"B{k - 1}.end" if k else "ground", f"B{k}.top", axis="xyz"[k % 3],
                 coordinate=f"qdd{k}", torque=Drive(damping=damping))
        for k in range(count)
    ]  # fmt: skip
    eqs = form_equations(Model("chain", [*bodies, *joints], ("0", "0", f"-{gravity}"), names))
    matrix, definitions = eqs.mass_matrix, eqs.definitions
    assert definitions and not {str(name) for name, _ in definitions} & set(names)
    q, u = np.linspace(0.2, 0.9, count), np.linspace(-1.0, 1.0, count)
    values = {str(symbol): value for symbol, value in zip(eqs.coordinates, q, strict=True)}

    def number(expression: object) -> float:
        free = {s: values[str(s)] for s in (*expression.free_symbols, *expression.atoms(AppliedUndef))
                if str(s) in values}  # fmt: skip
        return float(expression.xreplace(free))

    values |= names
    for name, formula in definitions:
        if not formula.has(Derivative) and set(
            map(str, (*formula.free_symbols, *formula.atoms(AppliedUndef)))
        ) - {"t"} <= set(values):
            values[str(name)] = number(formula)
    mass_matrix, udot = compile(eqs, ["mass_matrix", "udot"])(0.0, q, u)
    assert number(matrix[0, 1]) == pytest.approx(mass_matrix[0, 1], rel=1e-12)
    namespace: dict[str, object] = {}
    exec(builtins_compile(generate_code(eqs, ["udot"], language="python"), "f", "exec"), namespace)
    function = namespace["f"]
    assert callable(function)
    found = np.asarray(function(0.0, list(q), list(u), [], list(names.values())))
    np.testing.assert_allclose(found, udot, rtol=1e-10)


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
    assert Symbol("h", SymbolKind.PARAMETER) == Symbol("h", SymbolKind.PARAMETER)
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
