"""Values of parameters that are formulas of each other."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import ModelError
from symbody.model import Model, resolve_parameters
from symbody.model.parameters import cycle_problems


def model(**parameters: object) -> Model:
    return Model("parameters", parameters=parameters)


def test_order_follows_dependence_and_else_the_file() -> None:
    assert model(c="a + b", a=1, d="c*c", b="2*a").parameter_order() == ("a", "b", "c", "d")


def test_values_are_exact_where_formulas_are() -> None:
    values = resolve_parameters(model(m=9.81, k="2*m/3", n=3, f="sqrt(4)", g="2**0.5", h="pi/2", x=0.1 + 0.2))
    assert values["m"] == Fraction(981, 100) and isinstance(values["m"], Fraction)
    assert values["k"] == Fraction(654, 100)
    assert values["n"] == 3 and isinstance(values["n"], int)
    assert values["f"] == 2
    assert values["g"] == math.sqrt(2)
    assert values["h"] == math.pi / 2
    assert values["x"] == 0.30000000000000004 and isinstance(values["x"], float)


def test_what_depends_on_an_overridden_one_follows() -> None:
    chain = model(m=1, k="4*m", d="k/2", other=7)
    assert resolve_parameters(chain, {"m": "1/3"}) == {
        "m": Fraction(1, 3),
        "k": Fraction(4, 3),
        "d": Fraction(2, 3),
        "other": 7,
    }
    assert resolve_parameters(chain, {"k": "other"})["d"] == Fraction(7, 2)
    assert chain.parameters["k"].text == "4*m"


@pytest.mark.parametrize(
    "number",
    [np.float64(0.5), np.float32(0.5), np.int64(2), np.array(0.5), np.array(3), Fraction(1, 2), 2, "1/2"],
)
def test_numbers_of_other_libraries(number: object) -> None:
    assert resolve_parameters(model(m=1), {"m": number})["m"] == Fraction(str(number))


@pytest.mark.parametrize(
    "value",
    [
        True,
        np.True_,
        1j,
        np.complex128(1),
        np.array([1.0, 2.0]),
        [1],
        {"a": 1},
        object(),
        math.inf,
        np.float64("nan"),
        None,
    ],
)
def test_what_is_no_number(value: object) -> None:
    with pytest.raises(ModelError) as caught:
        resolve_parameters(model(m=1), {"m": value})
    (problem,) = caught.value.problems
    assert problem.where == "parameters, m" and problem.fix


def test_all_missing_values_at_once() -> None:
    declared = model(m=None, k="2*m", d=None, c="k + d", g=1)
    with pytest.raises(ModelError) as caught:
        resolve_parameters(declared)
    (problem,) = caught.value.problems
    assert problem.code == "parameters.missing" and "m, d" in problem.what
    assert resolve_parameters(declared, {"m": 1, "d": 2})["c"] == 4


def test_unknown_names_with_the_nearest() -> None:
    with pytest.raises(ModelError) as caught:
        resolve_parameters(model(mass=1), {"mas": 1, "q": 2, "mass": "2*z"})
    assert [problem.code for problem in caught.value.problems] == [
        "parameters.unknown",
        "parameters.unknown",
        "names.unknown",
    ]
    assert "'mass'" in caught.value.problems[0].fix


@pytest.mark.parametrize(
    ("parameters", "path"),
    [
        ({"a": "b", "b": "a"}, "a -> b -> a"),
        ({"a": "a + 1"}, "a -> a"),
        ({"x": 1, "a": "b*x", "b": "c", "c": "2*a"}, "a -> b -> c -> a"),
    ],
)
def test_cycles_show_their_path(parameters: dict[str, object], path: str) -> None:
    with pytest.raises(ModelError) as caught:
        model(**parameters)
    (problem,) = caught.value.problems
    assert problem.code == "parameters.cycle" and path in problem.what


def test_two_cycles_are_two_problems() -> None:
    with pytest.raises(ModelError) as caught:
        model(a="b", b="a", c="d", d="c")
    assert [problem.code for problem in caught.value.problems] == ["parameters.cycle"] * 2


def test_override_that_closes_a_cycle() -> None:
    with pytest.raises(ModelError, match="m -> k -> m"):
        resolve_parameters(model(m=1, k="2*m"), {"m": "k"})


@pytest.mark.parametrize("text", ["1/(m - 1)", "log(m - 2)", "exp(1000*m)", "sqrt(-m)"])
def test_values_that_do_not_exist_name_the_parameter(text: str) -> None:
    with pytest.raises(ModelError) as caught:
        model(m=1, k=text)
    (problem,) = caught.value.problems
    assert problem.where.startswith("model, parameters.k")


def test_long_chain_needs_no_recursion() -> None:
    names = [f"p{k}" for k in range(3000)]
    parameters: dict[str, object] = {name: f"p{k + 1} + 1" for k, name in enumerate(names)}
    chain = model(**parameters, p3000=0)
    assert resolve_parameters(chain)["p0"] == 3000
    assert chain.parameter_order()[0] == "p3000"


@given(st.permutations(range(6)))
def test_order_of_definition_does_not_matter(order: list[int]) -> None:
    formulas = {"p0": "1", "p1": "p0 + 1", "p2": "p1*p0", "p3": "p2 - p1", "p4": "p3 + p2", "p5": "p4*2"}
    shuffled = {f"p{k}": formulas[f"p{k}"] for k in order}
    assert resolve_parameters(model(**shuffled)) == resolve_parameters(model(**formulas))
    assert not cycle_problems(model(**shuffled).parameters)
