"""Laws of twists, wrenches, transforms and inertias: exact in fractions, to rounding in floats."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.spatial.inertia import RigidInertia, central_inertia, single_body
from symbody.spatial.matrix import Matrix3, SymmetricTensor, Vector3, matrix3, skew
from symbody.spatial.transform import CoordinateRotation, Transform
from symbody.spatial.twist import Twist, Wrench

Number = Fraction
fractions = st.fractions(-9, 9, max_denominator=7)
vectors = st.tuples(fractions, fractions, fractions).map(Vector3)
twists = st.builds(Twist, vectors, vectors)
wrenches = st.builds(Wrench, vectors, vectors)
# Sines and cosines that are fractions: (1 - t^2) / (1 + t^2), 2 t / (1 + t^2).
turns = st.builds(
    lambda axis, t: CoordinateRotation(axis, (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)),
    st.sampled_from((0, 1, 2)),
    fractions,
)
steps = st.lists(turns | turns.map(lambda turn: turn.matrix), max_size=3).map(tuple)
transforms = st.builds(Transform, steps, vectors)
tensors = st.tuples(*[fractions] * 6).map(lambda entries: SymmetricTensor(*entries))
inertias = st.builds(RigidInertia, tensors, vectors, fractions)


@given(transforms, twists, wrenches)
def test_power_is_the_same_in_both_frames(
    X: Transform[Number], v: Twist[Number], f: Wrench[Vector3[Number]]
) -> None:
    assert X.twist_to_child(v).dot(f) == v.dot(X.wrench_to_parent(f))


@given(transforms, vectors)
def test_a_transform_and_its_inverse(X: Transform[Number], x: Vector3[Number]) -> None:
    assert X.inverse.point_to_parent(X.point_to_parent(x)) == x
    assert X.to_child(X.to_parent(x)) == x
    assert X.to_parent(x) == X.matrix @ x


@given(transforms, transforms, vectors)
def test_transforms_in_a_row(X: Transform[Number], Y: Transform[Number], x: Vector3[Number]) -> None:
    assert X.then(Y).point_to_parent(x) == X.point_to_parent(Y.point_to_parent(x))


@pytest.mark.exhaustive
@given(twists, twists, wrenches)
def test_rates_of_twists_and_wrenches_leave_power_as_it_is(
    v: Twist[Number], m: Twist[Number], f: Wrench[Vector3[Number]]
) -> None:
    assert v.cross(m).dot(f) + m.dot(v.cross_force(f)) == 0


@given(transforms, inertias, twists)
def test_inertias_move_as_wrenches_and_twists_do(
    X: Transform[Number], body: RigidInertia[Number], a: Twist[Number]
) -> None:
    seen = X.wrench_to_parent(body @ X.twist_to_child(a))
    assert body.to_parent(X) @ a == seen == single_body(body).to_parent(X) @ a


@given(inertias, twists, twists, fractions)
def test_an_articulated_body_gives_way_along_its_joint(
    body: RigidInertia[Number], S: Twist[Number], a: Twist[Number], shift: Fraction
) -> None:
    U = single_body(body) @ S
    D = S.dot(U)
    if D != 0:
        left = single_body(body).project_out(U, 1 / D)
        assert left @ (a + S * shift) == left @ a and S.dot(left @ a) == 0


@pytest.mark.exhaustive
@given(turns, tensors, st.tuples(vectors, vectors, vectors).map(Matrix3))
def test_tensors_turn_as_matrices_do(
    turn: CoordinateRotation[Number], K: SymmetricTensor[Number], A: Matrix3[Number]
) -> None:
    R = turn.matrix
    assert turn.rotate_tensor(K).matrix == R @ K.matrix @ R.T
    assert turn.rotate_matrix(A) == R @ A @ R.T


@given(vectors, vectors)
def test_the_skew_matrix_is_the_vector_product(a: Vector3[Number], b: Vector3[Number]) -> None:
    assert skew(a) @ b == a.cross(b) == -b.cross(a)


def test_floats_are_numbers_too() -> None:
    body = central_inertia(SymmetricTensor(2.0, 3.0, 4.0, 0.1, 0.2, 0.3), 5.0)
    quarter = matrix3((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    moved = body.to_parent(Transform((quarter,), Vector3((1.0, 0.0, 0.0))))
    # About the parent's origin: x and y exchanged, and m r^2 = 5 on the moments across x.
    assert moved.rotational == pytest.approx(SymmetricTensor(3.0, 2.0 + 5, 4.0 + 5, -0.1, -0.3, 0.2))
    assert moved.first == (5.0, 0.0, 0.0)
