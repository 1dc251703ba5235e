"""Which inertia tensors are possible."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import symbody as sb
from symbody.model.inertia import is_possible_inertia

POINT = st.tuples(st.floats(0.0, 10.0), *[st.floats(-5.0, 5.0)] * 3)


def tensor(points: list[tuple[float, float, float, float]]) -> tuple[list[float], list[float]]:
    """Moments and products of point masses (m, x, y, z) about the origin."""
    moments = [
        sum(m * (y * y + z * z) for m, x, y, z in points),
        sum(m * (x * x + z * z) for m, x, y, z in points),
        sum(m * (x * x + y * y) for m, x, y, z in points),
    ]
    products = [
        -sum(m * x * y for m, x, y, z in points),
        -sum(m * x * z for m, x, y, z in points),
        -sum(m * y * z for m, x, y, z in points),
    ]
    return moments, products


@given(st.lists(POINT, min_size=1, max_size=5))
def test_any_set_of_masses_has_a_possible_inertia(points: list[tuple[float, float, float, float]]) -> None:
    assert is_possible_inertia(*tensor(points))


@pytest.mark.parametrize("scale", [1e-30, 1e-15, 1.0, 1e12])
@pytest.mark.parametrize(
    ("moments", "products", "possible"),
    [
        ((0, 0, 0), (0, 0, 0), True),
        ((1, 1, 2), (0, 0, 0), True),  # a plate
        ((0, 1, 1), (0, 0, 0), True),  # a rod
        ((1, 1, 2.000000001), (0, 0, 0), True),  # off by half of the tolerance
        ((1, 1, 2.00000001), (0, 0, 0), False),
        ((1, 1, 5), (0, 0, 0), False),
        ((-1, 1, 1), (0, 0, 0), False),
        ((1, 1, 1), (0.49, 0, 0), True),
        ((1, 1, 1), (0.51, 0, 0), False),
        # Second moments 1 with all correlations r: positive down to r = -1/2, positive up to 1.
        ((2, 2, 2), (-0.9, -0.9, -0.9), True),
        ((2, 2, 2), (0.9, 0.9, 0.9), False),
    ],
)
def test_limits_at_any_scale(
    moments: tuple[float, ...], products: tuple[float, ...], possible: bool, scale: float
) -> None:
    assert is_possible_inertia([m * scale for m in moments], [p * scale for p in products]) is possible


def test_a_matrix_of_inertia_is_answered_by_how_to_give_it() -> None:
    with pytest.raises(sb.ModelError) as caught:
        sb.Body("B", mass=1, inertia=np.eye(3))
    (problem,) = caught.value.problems
    assert problem.code == "model.not_three" and "products=" in problem.fix
