"""The fault checklist, C: parameters and units. One test a row; the number is the row's."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from symbody.codegen.compile import compile
from symbody.equations.form import form_equations
from symbody.errors import ExpressionError, ModelError, SymbodyError
from symbody.formats import model_from_toml
from symbody.model import Body, Drive, Frame, Model, Prismatic, SpringDamper, resolve_parameters
from tests.faults.refusals import refused, refused_model


def oscillator(**parameters: object) -> Model:
    drive = Drive(stiffness="k", damping="d")
    slider = Prismatic("slider", "ground", Body("Mass", mass="m"), coordinate="x", force=drive)
    return Model("oscillator", [slider], parameters={"m": 1, "k": 4, "d": 0} | parameters)


def test_row_26_missing_and_unknown_values_are_listed_together() -> None:
    model = oscillator(k=None, d=None)
    found = refused(lambda: resolve_parameters(model), ModelError, "no value is given for k, d")
    assert found == [("parameters.missing", "parameters")]
    words = "did you mean 'k'"
    assert refused(lambda: resolve_parameters(oscillator(), {"kk": 1, "mm": 2}), ModelError, words) == [
        ("parameters.unknown", "parameters, kk"),
        ("parameters.unknown", "parameters, mm"),
    ]
    eqs = form_equations(model)
    refused(lambda: compile(eqs, "udot"), SymbodyError, "k, d")
    assert compile(eqs, "udot", {"k": 4, "d": 0})(0.0, [1.0], [0.0]) == pytest.approx([-4.0])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), Decimal("NaN"), np.float32("-inf")])
def test_row_27_values_that_are_not_finite(value: object) -> None:
    assert refused_model(parameters={"a": value}) == [("expression.not_finite", "model, parameters.a")]
    refused(lambda: resolve_parameters(oscillator(), {"k": value}), SymbodyError, "k")


def test_row_27_formulas_whose_value_is_not_finite() -> None:
    found = refused_model(parameters={"a": "log(b)", "b": -1}, words="a = log(b)")
    assert found == [("parameters.not_finite", "model, parameters.a")]


def test_row_28_negative_masses_and_stiffnesses() -> None:
    assert refused_model(Body("A", mass="m"), parameters={"m": -1}) == [
        ("model.negative_mass", "body A, mass")
    ]
    assert any("stiffness k is negative" in note for note in oscillator(k=-1).notes)
    spring = SpringDamper("s", "ground", "Mass", stiffness="-k", free=1)
    model = oscillator()
    notes = Model("more", [*model.elements, spring], parameters=model.parameters).notes
    assert any(note.startswith("spring s: the stiffness") for note in notes)
    # A length of zero is legal until something is divided by it.
    at = Frame(at=("L", 0, 0))
    assert Model("short", [Body("A", frames={"end": at})], parameters={"L": 0}).bodies
    found = refused_model(Body("A", mass="1/L"), parameters={"L": 0})
    assert [code for code, _ in found] == ["expression.undefined"] or found


@pytest.mark.parametrize(("text", "value"), [("1e-3", Fraction(1, 1000)), ("1E5", 100000), ("012", 12)])
def test_row_29_numbers_as_text_are_numbers(text: str, value: object) -> None:
    assert resolve_parameters(oscillator(k=text))["k"] == value


@pytest.mark.parametrize("text", ["9,81", "12:30:45", "no thing", "1e-3 kg"])
def test_row_29_text_that_is_no_number(text: str) -> None:
    ((_, where),) = refused_model(parameters={"a": text})[:1]
    assert where.startswith("model, parameters.a")
    quoted = f'name = "a"\n[parameters]\na = "{text}"\n'
    ((_, place), *_) = refused(lambda: model_from_toml(quoted, where="a.toml"))
    assert place.startswith("a.toml:3, ")


def test_row_30_degrees_for_radians_and_millimetres_for_metres() -> None:
    turned = Body("A", frames={"end": Frame(rotate=[("z", 90)])})
    assert any('"90 deg"' in note for note in Model("turned", [turned]).notes)
    rod = Body("Rod", mass=1, inertia=(0, 1 / 12, 1 / 12), frames={"end": Frame(at=(500_000, 0, 0))})
    assert any("are lengths in m" in note for note in Model("rod", [rod]).notes)


@pytest.mark.parametrize("text", ["9.81 m/s^2", "2 + 3 kg", "5 [N/m]", "90 degrees"])
def test_row_30_and_31_units_are_not_declared_and_nothing_is_guessed_from_them(text: str) -> None:
    """All quantities are in SI units and rad: a unit written out is refused with its column, never dropped."""
    ((code, where), *_) = refused_model(parameters={"a": text})
    assert code.startswith("expression.") and ", column " in where
    table = 'name = "a"\n[units]\nm = "kg"\n'
    assert refused(lambda: model_from_toml(table, where="a.toml"), words="units")[0][0] == "file.unknown_key"


def test_row_32_gravity_left_out_is_told() -> None:
    assert "gravity is zero" in oscillator().notes
    model = oscillator()
    heavy = Model("heavy", model.elements, gravity=(0, 0, -9.81), parameters=model.parameters)
    assert "gravity is zero" not in heavy.notes


@pytest.mark.parametrize(
    "value",
    [4, 4.0, np.int64(4), np.float32(4), np.array(4), np.array([4.0])[0], Fraction(4), Decimal(4), "4"],
    ids=repr,
)
def test_row_33_numbers_of_any_kind(value: object) -> None:
    assert resolve_parameters(oscillator(k=value))["k"] == 4
    udot = compile(form_equations(oscillator()), "udot", {"k": value})(0, np.array([1]), [np.float32(0)])
    assert udot == pytest.approx([-4.0]) and udot.dtype == float


@pytest.mark.parametrize("value", [4j, True, np.True_, type, [4], np.array([4, 5]), b"4"], ids=repr)
def test_row_33_what_is_no_number(value: object) -> None:
    ((code, where), *_) = refused(lambda: Model("bad", parameters={"a": value}))
    assert code.startswith("expression.") and where == "model, parameters.a"


@pytest.mark.parametrize("state", [["a"], [1j], [None], [object()]])
def test_row_33_states_that_are_no_numbers(state: list[object]) -> None:
    f = compile(form_equations(oscillator()), "udot")
    with pytest.raises(SymbodyError):
        f(0.0, state, [0.0])


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_row_34_parameters_of_any_size(scale: float) -> None:
    f = compile(form_equations(oscillator()), "udot", {"m": 1e-12 * scale, "k": 4e12 * scale})
    assert f(0.0, [1.0], [0.0]) == pytest.approx([-4e24], rel=1e-15)


def test_row_35_parameters_in_a_circle() -> None:
    found = refused_model(parameters={"a": "b", "b": "2*c", "c": "a"}, words="a -> b -> c -> a")
    assert found == [("parameters.cycle", "model, parameters.a")]
    model = oscillator()
    found = refused(lambda: resolve_parameters(model, {"k": "m", "m": "k"}), ModelError, "m -> k -> m")
    assert found[0][0] == "parameters.cycle"


def test_row_36_arrays_are_copied() -> None:
    inertia, parameters = np.array([1.0, 1.0, 1.0]), {"m": 1.0}
    body = Body("A", mass="m", inertia=inertia)
    model = Model("a", [body], parameters=parameters)
    inertia[:], parameters["m"] = 7.0, 9.0
    assert [value.text for value in body.inertia] == ["1.0"] * 3 and resolve_parameters(model)["m"] == 1
    f = compile(form_equations(oscillator()), "udot")
    q = np.array([1.0])
    first = f(0.0, q, [0.0])
    kept = first.copy()
    q[:] = 5.0
    f(0.0, q, [0.0])
    assert (first == kept).all()


def test_row_36_defaults_are_not_shared() -> None:
    assert Body("A").frames is not None and Body("A") == Body("A")
    with pytest.raises((TypeError, ExpressionError)):
        Body("A").frames["x"] = Frame()  # type: ignore[index]
