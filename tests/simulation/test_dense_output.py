"""The polynomials between samples."""

from __future__ import annotations

import numpy as np
import pytest

from symbody.errors import UsageError
from symbody.simulation.native.dense_output import DenseOutput

# x = t^3 on [0, 1] and [1, 3] as cubics of Hermite: rows x0, move, h x0' - move, 2 move - h (x0' + x1')
CUBE = DenseOutput(
    np.array([0.0, 1.0, 3.0]),
    np.array([[[0.0], [1.0], [-1.0], [-1.0]], [[1.0], [26.0], [6.0 - 26.0], [52.0 - 2.0 * 30.0]]]),
)


def test_a_cubic_is_reproduced() -> None:
    times = np.array([0.0, 0.25, 1.0, 1.5, 3.0])
    np.testing.assert_allclose(CUBE(times), [times**3], rtol=4e-16)
    assert CUBE(2.0).tolist() == [8.0]
    assert CUBE([[0.0, 1.0, 2.0]]).shape == (1, 1, 3)


def test_a_step_begins_with_its_own_polynomial() -> None:
    jump = DenseOutput(CUBE.breaks, CUBE.pieces + np.array([[[0.0]], [[100.0]]]) * np.eye(4, 1)[:, :1])
    assert jump(1.0).tolist() == [101.0]


def test_breaks_may_fall() -> None:
    pieces = np.array([[[27.0], [-26.0], [-2 * 27.0 + 26.0], [-52.0 + 2.0 * 30.0]]])
    backwards = DenseOutput(np.array([3.0, 1.0]), pieces)
    np.testing.assert_allclose(backwards([3.0, 2.0, 1.5, 1.0]), [[27.0, 8.0, 3.375, 1.0]], rtol=1e-15)


@pytest.mark.parametrize("time", [-0.1, 3.0000001, np.nan])
def test_times_outside_are_refused(time: float) -> None:
    with pytest.raises(UsageError, match=r"lies outside the motion, which runs from 0 to 3"):
        CUBE([0.5, time])
