"""The 24 sequences against SymPy, their rates, and the angles of a matrix."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Sequence

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from sympy.physics.vector import ReferenceFrame, dynamicsymbols

from symbody.errors import FrameError
from symbody.expr.expression import Expr, cos, sin
from symbody.expr.graph import Graph
from symbody.spatial.euler_angles import angle_rates, angles_of_matrix, euler_rotations, sequence_axes
from symbody.spatial.rotation import AxisRotation, compose_steps, rotation_matrix
from tests.spatial.numbers import matrix_of, matrix_values, named, names_in, triple, values
from tests.tiers import cases

WRITTEN = ["".join(s) for s in itertools.product("123", repeat=3) if s[0] != s[1] != s[2]]
SEQUENCES = [prefix + written for prefix in ("", "space ") for written in WRITTEN]
EPS = np.finfo(float).eps
# Entries are sums of products of sines and cosines: below 30 roundings of numbers below 3.
ROUNDING = 100 * EPS
# Rates up to 2 make omega up to 6 with some 30 roundings; the way back has about as many and divides by a
# determinant above 0.38 (the middle angles lie in 0.4 .. 1.1): 2 * 30 * 6 / 0.38 eps < 1000 eps.
RATE_ROUNDING = 1000 * EPS


def sympy_frames(sequence: str, angles: Sequence[sp.Expr]) -> tuple[ReferenceFrame, ReferenceFrame]:
    start, end = ReferenceFrame("N"), ReferenceFrame("B")
    if sequence.startswith("space"):
        end.orient_space_fixed(start, angles, sequence.removeprefix("space "))
    else:
        end.orient_body_fixed(start, angles, sequence)
    return start, end


def random_state(sequence: str) -> tuple[dict[str, float], list[float]]:
    source = random.Random(sequence)
    angles = [source.uniform(-3, 3), source.uniform(0.4, 1.1), source.uniform(-3, 3)]
    return dict(zip("abc", angles, strict=True)), [source.uniform(-2, 2) for _ in range(3)]


def test_there_are_24() -> None:
    assert len(SEQUENCES) == 24


@pytest.mark.parametrize("sequence", cases(SEQUENCES, fast=SEQUENCES[::4]))
def test_matrix_and_rates_agree_with_sympy(sequence: str) -> None:
    at, rates = random_state(sequence)
    symbols = dynamicsymbols("a b c")
    start, end = sympy_frames(sequence, symbols)
    numbers = dict(zip([s.diff() for s in symbols], rates, strict=True)) | dict(
        zip(symbols, at.values(), strict=True)
    )
    graph = Graph()
    turns = euler_rotations(graph, sequence, named(graph, "a b c"))
    expected = np.array(start.dcm(end).evalf(subs=numbers), dtype=float)
    found = matrix_values(graph, rotation_matrix(graph, compose_steps(turns)), at)
    assert np.abs(found - expected).max() < ROUNDING
    in_body_order = rates[::-1] if sequence.startswith("space") else rates
    for side, frame in (("start", start), ("end", end)):
        omega = [float(w.evalf(subs=numbers)) for w in end.ang_vel_in(start).to_matrix(frame)]
        rated, _ = angle_rates(graph, turns, triple(graph, *omega), side)
        assert np.abs(values(graph, rated, at) - in_body_order).max() < RATE_ROUNDING


def test_313_in_end_axes_divides_by_the_sine_of_the_middle_angle_alone() -> None:
    graph = Graph()
    zeta, eta, xi = named(graph, "zeta eta xi")
    wx, wy, wz = named(graph, "wx wy wz")
    rates, determinant = angle_rates(
        graph, euler_rotations(graph, "313", (zeta, eta, xi)), (wx, wy, wz), "end"
    )
    assert determinant == -sin(eta)
    across = sin(xi) * wx + cos(xi) * wy
    assert rates == (across / sin(eta), cos(xi) * wx - sin(xi) * wy, wz - cos(eta) * (across / sin(eta)))


def test_only_the_angles_that_matter_appear() -> None:
    graph = Graph()
    turns = euler_rotations(graph, "123", named(graph, "a b c"))
    omega = named(graph, "x y z")
    for side, unseen in (("start", "c"), ("end", "a")):
        rates, determinant = angle_rates(graph, turns, omega, side)
        assert names_in(*rates) == {"a", "b", "c", "x", "y", "z"} - {unseen}
        assert determinant == cos(turns[1].angle)


def test_rates_of_axes_that_are_not_perpendicular() -> None:
    graph = Graph()
    # Three constant unit axes, no two perpendicular.
    axes = [np.array(a) for a in ([0.6, 0.0, 0.8], [0.36, 0.48, 0.8], [0.0, 0.8, -0.6])]
    turns = tuple(
        AxisRotation(triple(graph, *axis), angle)
        for axis, angle in zip(axes, named(graph, "a b c"), strict=True)
    )
    at, rates = {"a": 0.4, "b": 1.3, "c": -0.7}, [0.3, -1.1, 0.6]
    r1, r2, r3 = (matrix_values(graph, turn.matrix(graph), at) for turn in turns)
    in_start = rates[0] * axes[0] + rates[1] * r1 @ axes[1] + rates[2] * r1 @ r2 @ axes[2]
    for side, omega in (("start", in_start), ("end", (r1 @ r2 @ r3).T @ in_start)):
        found, determinant = angle_rates(graph, turns, triple(graph, *omega), side)
        size = abs(values(graph, [determinant], at)[0])
        assert size > 0.1  # so that the bound of RATE_ROUNDING holds but for a factor of 4
        assert np.abs(values(graph, found, at) - rates).max() < 4 * RATE_ROUNDING


def rebuilt(graph: Graph, sequence: str, angles: tuple[Expr, Expr, Expr]) -> np.ndarray:
    return matrix_values(
        graph, rotation_matrix(graph, compose_steps(euler_rotations(graph, sequence, angles))), {}
    )


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_measured_angles_are_the_angles_and_rebuild_the_matrix_where_singular(sequence: str) -> None:
    middle = 0.0 if sequence[-3] == sequence[-1] else math.pi / 2
    for angles in ((0.5, 0.8, -2.1), (-2.9, 1.1, 3.0), (0.7, middle, 0.4)):
        graph = Graph()
        turns = euler_rotations(graph, sequence, triple(graph, *angles))
        matrix = matrix_values(graph, rotation_matrix(graph, compose_steps(turns)), {})
        measured = angles_of_matrix(matrix_of(graph, matrix), sequence)
        # The entries are wrong by about eps, the outer angles by that over sin or cos of the middle one;
        # where it is singular the product is still right to rounding.
        assert np.abs(rebuilt(graph, sequence, measured) - matrix).max() < ROUNDING
        if angles[1] != middle:
            assert values(graph, measured, {}) == pytest.approx(angles, abs=ROUNDING)


@given(
    st.tuples(*[st.floats(-10, 10) for _ in range(3)]), st.sampled_from(SEQUENCES), st.sampled_from(SEQUENCES)
)
def test_any_rotation_is_measured_in_any_sequence(
    angles: tuple[float, float, float], made_by: str, measured_by: str
) -> None:
    graph = Graph()
    turns = euler_rotations(graph, made_by, triple(graph, *angles))
    matrix = matrix_values(graph, rotation_matrix(graph, compose_steps(turns)), {})
    measured = angles_of_matrix(matrix_of(graph, matrix), measured_by)
    assert np.abs(rebuilt(graph, measured_by, measured) - matrix).max() < ROUNDING
    middle = values(graph, measured, {})[1]
    same = measured_by[-3] == measured_by[-1]
    assert -ROUNDING <= middle <= math.pi + ROUNDING if same else abs(middle) <= math.pi / 2 + ROUNDING


def test_digits_and_letters_mean_the_same() -> None:
    assert sequence_axes("313") == sequence_axes("zxz") == (("z", "x", "z"), False)
    assert sequence_axes("space 123") == sequence_axes("space xyz") == (("x", "y", "z"), True)


@pytest.mark.parametrize(
    "sequence", ["", "12", "1234", "XYZ", "014", "112", "xyy", "space", "spacexyz", "body 123"]
)
def test_other_words_are_refused_with_the_way_to_write_them(sequence: str) -> None:
    with pytest.raises(FrameError) as caught:
        sequence_axes(sequence)
    (problem,) = caught.value.problems
    assert repr(sequence) in problem.what and problem.why and '"313"' in problem.fix


def test_angular_velocity_needs_three_angles() -> None:
    graph = Graph()
    turns = euler_rotations(graph, "123", named(graph, "a b c"))
    with pytest.raises(FrameError, match="2 angles"):
        angle_rates(graph, turns[:2], named(graph, "x y z"))
