"""Newton's method from far away and from near by, and ranks, on curves whose points are known."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from symbody.manifold import (
    ConstraintManifold,
    count_significant,
    descend,
    least_step,
    null_space,
    pivot_order,
    rank,
)

Floats = NDArray[np.float64]
ONE = np.ones(1)


def circle(q: Floats) -> tuple[Floats, Floats]:
    """Return ``x^2 + y^2 - 1`` and its derivatives."""
    return np.array([q @ q - 1.0]), 2.0 * q[np.newaxis]


def crossing(q: Floats) -> tuple[Floats, Floats]:
    """Return ``x y``, two lines that cross at 0."""
    return np.array([q[0] * q[1]]), np.array([[q[1], q[0]]])


def manifold(function: Any, **options: Any) -> ConstraintManifold:
    return ConstraintManifold(function, np.ones(2), ONE, **options)


@pytest.mark.parametrize("guess", [(30.0, 40.0), (1e-3, -2e-3), (0.6, 0.8)])
def test_the_nearest_point_of_a_circle_lies_on_the_ray(guess: tuple[float, float]) -> None:
    end = manifold(circle).project(guess, least_step)
    assert end.is_closed and end.residual < 1e-14
    assert end.q == pytest.approx(np.array(guess) / np.hypot(*guess))


def test_what_is_not_free_keeps_its_value() -> None:
    end = manifold(circle, free=np.array([False, True])).project((0.6, 0.1))
    assert end.is_closed and end.q == pytest.approx([0.6, 0.8]) and end.q[0] == 0.6


def test_a_point_off_every_solution_is_not_closed() -> None:
    end = manifold(circle, free=np.array([False, True])).project((1.5, 0.3))
    assert not end.is_closed and 1.25 <= end.residual < 1.26


def test_damped_steps_reach_the_crossing_of_branches() -> None:
    assert manifold(crossing).project((1e-3, 1e-3)).is_closed
    assert manifold(crossing).tangent(np.zeros(2)).shape == (2, 2)


def test_whole_steps_refuse_a_predictor_that_leads_elsewhere() -> None:
    on_circle = manifold(circle)
    beside = on_circle.correct(np.array([0.61, 0.81]), (np.array([0.0, 1.0]), 0.8))
    assert beside == pytest.approx([0.6, 0.8])
    assert on_circle.correct(np.array([0.1, 0.81]), (np.array([0.0, 1.0]), 1.2)) is None
    assert on_circle.correct(np.array([np.nan, 1.0])) is None


def test_ranks_do_not_depend_on_the_length_of_rows() -> None:
    rows = np.array([[1.0, 0.0, 0.0], [0.0, 1e-5, 0.0], [2.0, 3e-5, 0.0]])
    assert rank(rows) == 2 and rank(rows * 1e4) == 2
    assert null_space(rows, 1e-9) == pytest.approx(np.array([[0.0], [0.0], [1.0]]), abs=1e-9)
    assert count_significant(np.array([[3.0, 1e-9], [3.0, 2.0]])) == 2
    order, pivots = pivot_order([[1.0, 5.0, 0.0], [0.0, 0.0, 2.0]])
    assert order[0] == 1 and order[1] == 2 and pivots == pytest.approx([5.0, 2.0])


class Wall(NamedTuple):
    """A residual that falls by a thousandth of each unit, with slopes that promise all of it."""

    x: float

    @property
    def values(self) -> NDArray[np.float64]:
        return np.array([1.0 - 2e-3 * self.x])

    @property
    def slopes(self) -> NDArray[np.float64]:
        return np.array([[-1.0]])


def test_a_search_that_crawls_ends_after_its_patience() -> None:
    def move(wall: Wall, step: NDArray[np.float64]) -> Wall:
        return Wall(wall.x + float(step[0]))

    assert descend(Wall(0.0), move, patience=8).x < 9.0
    assert descend(Wall(0.0), move).x > 60.0
