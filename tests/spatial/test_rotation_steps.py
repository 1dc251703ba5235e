"""Euler parameters and direction cosines as steps; what merges and what does not."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation as Reference
from sympy.physics.vector import ReferenceFrame, dynamicsymbols

from symbody.expr.expression import number
from symbody.expr.graph import Graph
from symbody.spatial.euler_parameters import EulerParameters, euler_parameter_omega, euler_parameter_rates
from symbody.spatial.rotation import (
    AxisRotation,
    DirectionCosines,
    ElementaryRotation,
    Rotation,
    angle_sum,
    compose_steps,
    identity,
    rotation_matrix,
    transpose,
)
from tests.spatial.numbers import matrix_of, matrix_values, named, triple, values

EPS = np.finfo(float).eps
# Entries are sums of at most ten products of numbers below 1, and reference values as many.
ROUNDING = 100 * EPS


def unit_four(seed: int) -> dict[str, float]:
    four = np.random.default_rng(seed).normal(size=4)
    return dict(zip(("e0", "e1", "e2", "e3"), (four / np.linalg.norm(four)).tolist(), strict=True))


def parameters_in(graph: Graph) -> EulerParameters:
    return EulerParameters(*named(graph, "e0 e1 e2 e3"))


@pytest.mark.parametrize("seed", range(5))
def test_matrix_and_rates_agree_with_sympy(seed: int) -> None:
    graph = Graph()
    at, parameters = unit_four(seed), parameters_in(graph)
    symbols = dynamicsymbols("e0:4")
    start, end = ReferenceFrame("N"), ReferenceFrame("B")
    end.orient_quaternion(start, symbols)
    rates = np.random.default_rng(seed + 100).normal(size=4)
    rates -= (rates @ [*at.values()]) * np.array([*at.values()])  # the norm stays
    numbers = dict(zip([s.diff() for s in symbols], rates, strict=True)) | dict(
        zip(symbols, at.values(), strict=True)
    )
    expected = np.array(start.dcm(end).evalf(subs=numbers), dtype=float)
    assert np.abs(matrix_values(graph, parameters.matrix(graph), at) - expected).max() < ROUNDING
    in_end = np.array([float(w.evalf(subs=numbers)) for w in end.ang_vel_in(start).to_matrix(end)])
    for side, omega in (("end", in_end), ("start", expected @ in_end)):
        found = values(graph, euler_parameter_rates(parameters, triple(graph, *omega), side), at)
        assert np.abs(found - rates).max() < ROUNDING
        four = tuple(number(graph, float(r)) for r in rates)
        back = values(graph, euler_parameter_omega(parameters, four, side), at)
        assert np.abs(back - omega).max() < ROUNDING


def test_matrix_is_homogeneous_so_it_stays_a_multiple_of_a_rotation() -> None:
    graph = Graph()
    at = {name: 1.5 * value for name, value in unit_four(7).items()}
    r = matrix_values(graph, parameters_in(graph).matrix(graph), at)
    # R R^T is the fourth power of the norm; its entries are sums of three products of numbers below 2.25.
    assert np.abs(r @ r.T - 1.5**4 * np.eye(3)).max() < 10 * ROUNDING


def test_direction_cosines_are_their_matrix() -> None:
    graph = Graph()
    cosines = Reference.random(random_state=3).as_matrix()
    step = DirectionCosines(matrix_of(graph, cosines))
    assert np.array_equal(matrix_values(graph, rotation_matrix(graph, compose_steps([step])), {}), cosines)
    assert np.array_equal(matrix_values(graph, step.inverse.matrix(graph), {}), cosines.T)
    assert compose_steps([DirectionCosines(identity(graph))]) == Rotation()


def test_a_step_and_its_inverse_are_nothing() -> None:
    graph = Graph()
    four = parameters_in(graph)
    opposite = EulerParameters(-four.e0, -four.e1, -four.e2, -four.e3)
    cosines = DirectionCosines(matrix_of(graph, Reference.random(random_state=3).as_matrix()))
    turn = AxisRotation(triple(graph, 0, 0, 1), named(graph, "a")[0])
    for step in (four, cosines, turn):
        assert compose_steps([step, step.inverse]) == compose_steps([step.inverse, step]) == Rotation()
    assert compose_steps([opposite, four.inverse]) == Rotation()
    assert len(compose_steps([four, four]).turns) == 2


def test_merging_goes_on_with_the_new_neighbours() -> None:
    graph = Graph()
    a, b = named(graph, "a b")
    z, x = triple(graph, 0, 0, 1), triple(graph, 1, 0, 0)
    four = parameters_in(graph)
    steps: list[ElementaryRotation] = [AxisRotation(z, a), four, AxisRotation(x, b)]
    there = Rotation(tuple(steps))
    assert there.then(Rotation((AxisRotation(x, -b), four.inverse, AxisRotation(z, b)))) == Rotation(
        (AxisRotation(z, a + b),)
    )
    assert there.then(there.inverse) == Rotation()
    # Also where a rotation was put together without merging.
    assert Rotation((AxisRotation(z, a), four)).then(Rotation((four.inverse,))).turns == (AxisRotation(z, a),)
    assert Rotation((AxisRotation(z, a), AxisRotation(z, b))).then(Rotation()).turns == (
        AxisRotation(z, a + b),
    )


def test_opposite_terms_of_merged_angles_cancel() -> None:
    graph = Graph()
    a, b, c = named(graph, "a b c")
    z = triple(graph, 0, 0, 1)
    assert compose_steps([AxisRotation(z, a), AxisRotation(z, b), AxisRotation(z, -b)]).turns == (
        AxisRotation(z, a),
    )
    assert (
        compose_steps([AxisRotation(z, a + b), AxisRotation(z, c - a), AxisRotation(z, -(b + c))])
        == Rotation()
    )
    assert angle_sum(a + 2 * b, a - b * 2) == 2 * a
    assert angle_sum(a + b, c) == a + b + c
    assert angle_sum(a / 3 + 1, b - a / 3) == 1 + b


STEPS = st.lists(st.integers(-6, 6).filter(bool), max_size=12)


def drawn(graph: Graph, codes: list[int]) -> Rotation:
    z, x, minus_z = triple(graph, 0, 0, 1), triple(graph, 1, 0, 0), triple(graph, 0, 0, -1)
    a, b = named(graph, "a b")
    cosines = DirectionCosines(matrix_of(graph, Reference.random(random_state=5).as_matrix()))
    known: list[ElementaryRotation] = [
        AxisRotation(z, a),
        AxisRotation(x, b),
        AxisRotation(minus_z, b),
        parameters_in(graph),
        cosines,
        AxisRotation(x, a),
    ]
    return compose_steps([known[abs(k) - 1] if k > 0 else known[abs(k) - 1].inverse for k in codes])


@given(STEPS, STEPS)
def test_rotations_are_a_group_whose_matrices_multiply(first: list[int], second: list[int]) -> None:
    graph = Graph()
    r, s = drawn(graph, first), drawn(graph, second)
    at = {"a": 0.7, "b": -1.9} | unit_four(2)

    def matrix(rotation: Rotation) -> np.ndarray:
        return matrix_values(graph, rotation_matrix(graph, rotation), at)

    assert r.then(r.inverse) == r.inverse.then(r) == Rotation()
    # Not "==" of the two: a turn about z by a is also one about -z by -a.
    assert r.then(s).then(s.inverse.then(r.inverse)) == Rotation()
    assert r.then(s).then(s.inverse).then(r.inverse) == Rotation()
    # At most 24 factors, each with an error of some 10 eps that the others do not enlarge.
    assert np.abs(matrix(r) @ matrix(s) - matrix(r.then(s))).max() < 5 * ROUNDING
    assert np.abs(matrix(r) @ matrix(r).T - np.eye(3)).max() < 5 * ROUNDING
    assert np.abs(matrix(r.inverse) - matrix(r).T).max() < 5 * ROUNDING


def test_the_matrix_of_a_turn_about_an_exact_axis_is_orthogonal() -> None:
    graph = Graph()
    (a,) = named(graph, "a")
    unit = (number(graph, Fraction(2, 7)), number(graph, Fraction(3, 7)), number(graph, Fraction(6, 7)))
    matrix = AxisRotation(unit, a).matrix(graph)
    numbers = matrix_values(graph, matrix, {"a": 1.2})
    assert np.abs(numbers @ numbers.T - np.eye(3)).max() < ROUNDING
    assert np.abs(matrix_values(graph, transpose(matrix), {"a": 1.2}) - numbers.T).max() == 0
