"""Frames: turns, matrices, and what is refused."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError, replace
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import ModelError
from symbody.model import Frame
from symbody.model.numbers import as_float, formula_value
from symbody.model.simple_rotation import SimpleRotation

Rows = list[list[float]]


def codes(error: pytest.ExceptionInfo[ModelError]) -> list[str]:
    return [problem.code for problem in error.value.problems]


def number(formula: object, **values: float) -> float:
    value = formula_value(formula, values)
    assert value is not None
    return as_float(value)


def turn_matrix(turn: SimpleRotation, **values: float) -> Rows:
    """Rodrigues' formula."""
    x, y, z = (number(component, **values) for component in turn.axis)
    angle = number(turn.angle, **values)
    c, s = math.cos(angle), math.sin(angle)
    k = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    n = (x, y, z)
    return [[(1 - c) * n[i] * n[j] + c * (i == j) + s * k[i][j] for j in range(3)] for i in range(3)]


def product(a: Rows, b: Rows) -> Rows:
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def matrix_of(frame: Frame, **values: float) -> Rows:
    result: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for turn in frame.turns():
        result = product(result, turn_matrix(turn, **values))
    return result


def close(a: Rows, b: Rows, tolerance: float) -> bool:
    return all(abs(a[i][j] - b[i][j]) <= tolerance for i in range(3) for j in range(3))


def test_defaults_are_the_body_frame() -> None:
    frame = Frame()
    assert [component.text for component in frame.at] == ["0", "0", "0"]
    assert frame.turns() == ()


def test_formulas_numbers_and_degrees() -> None:
    frame = Frame(at=("L/2", 0.25, Decimal("1.50")), rotate=[("z", "30 deg"), (("a", 0, 1), "phi")])
    assert [component.text for component in frame.at] == ["L/2", "0.25", "1.50"]
    assert number(frame.turns()[0].angle) == pytest.approx(math.pi / 6, rel=1e-15)
    assert [use.path for use in frame.formula_sites("f")] == [
        "f.at[0]",
        "f.at[1]",
        "f.at[2]",
        "f.rotate[0][1]",
        "f.rotate[1][0][0]",
        "f.rotate[1][0][1]",
        "f.rotate[1][0][2]",
        "f.rotate[1][1]",
    ]


def test_axes_are_normalized_exactly_where_possible() -> None:
    exact, rooted, symbolic = Frame(rotate=[((3, 0, 4), 1), ((1, 1, 0), 1), (("a", 0, "b"), 1)]).turns()
    assert [component.constant() for component in exact.axis] == [formula_value(c) for c in exact.axis]
    assert [str(component.constant()) for component in exact.axis] == ["3/5", "0", "4/5"]
    assert [number(component) for component in rooted.axis] == [1 / math.sqrt(2), 1 / math.sqrt(2), 0.0]
    # 0.8 and 0.6 up to the rounding of a root and a quotient: 2 units of 1.1e-16
    assert [number(c, a=8, b=6) for c in symbolic.axis] == pytest.approx([0.8, 0.0, 0.6], abs=2.3e-16)


def test_matrix_of_right_angles_gives_exact_angles() -> None:
    frame = Frame(matrix=[[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    (turn,) = frame.turns()
    assert turn.angle.text == "1*pi/2"
    assert [component.text for component in turn.axis] == ["0", "0", "1"]


@given(st.lists(st.floats(-3.2, 3.2), min_size=3, max_size=3))
def test_turns_of_a_matrix_give_it_back(angles: list[float]) -> None:
    given_matrix = matrix_of(Frame(rotate=list(zip("zxy", angles, strict=True))))
    again = matrix_of(Frame(matrix=given_matrix))
    # Angles near multiples of 15 degrees are snapped by up to 2e-11; near a right angle of the middle
    # turn they are known to the root of 1e-18 only, 1e-9.
    assert close(given_matrix, again, 3e-9)


@pytest.mark.parametrize("middle", ["90 deg", "-90 deg"])
def test_matrix_with_coinciding_axes(middle: str) -> None:
    given_matrix = matrix_of(Frame(rotate=[("z", 0.3), ("y", middle), ("x", -0.7)]))
    # cos of the rounded right angle is 6e-17; nothing else is lost but a few roundings
    assert close(given_matrix, matrix_of(Frame(matrix=given_matrix)), 1e-15)


def test_matrix_of_formulas() -> None:
    frame = Frame(matrix=[["cos(a)", "-sin(a)", 0], ["sin(a)", "cos(a)", 0], [0, 0, 1]])
    a = 0.4
    expected = [[math.cos(a), -math.sin(a), 0.0], [math.sin(a), math.cos(a), 0.0], [0.0, 0.0, 1.0]]
    assert close(matrix_of(frame, a=a), expected, 1e-15)


def test_every_fault_is_told() -> None:
    with pytest.raises(ModelError) as caught:
        Frame(at=("1,5", True, float("nan")), rotate=[("q", 1), ("x",)], matrix=[[1, 2, 3]])
    assert codes(caught) == [
        "expression.comma_decimal",
        "expression.type",
        "expression.not_finite",
        "model.axis_letter",
        "model.not_a_turn",
        "model.not_three",
    ]


@pytest.mark.parametrize(
    ("at", "what"),
    [
        (9.81, "three entries are needed, not one: 9.81"),
        ("xyz", "three entries are needed, not one: 'xyz'"),
        ((1, 2), "three entries are needed, not 2"),
    ],
)
def test_what_is_no_triple_is_told_once(at: object, what: str) -> None:
    with pytest.raises(ModelError) as caught:
        Frame(at=at)
    (problem,) = caught.value.problems
    assert (problem.code, problem.what) == ("model.not_three", what)
    assert problem.fix == "give the components along x, y and z"


@pytest.mark.parametrize("at", [(1, 2), (1, 2, 3, 4), "xyz", 5, {"x": 1}, (1, 2, 3j), (1, None, 2)])
def test_origin_must_be_three_real_components(at: object) -> None:
    with pytest.raises(ModelError):
        Frame(at=at)


def test_turns_and_matrix_exclude_each_other() -> None:
    with pytest.raises(ModelError) as caught:
        Frame(rotate=[("x", 1)], matrix=[[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert codes(caught) == ["model.two_rotations"]


def test_frozen_copied_and_picklable() -> None:
    at: list[float] = [1, 2, 3]
    frame = Frame(at=at)
    at[0] = 9
    assert frame.at[0].text == "1"
    with pytest.raises(FrozenInstanceError):
        frame.at = ()
    assert pickle.loads(pickle.dumps(frame)) == frame
    assert replace(frame, rotate=[("z", 1)]).at == frame.at
