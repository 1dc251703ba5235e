"""Observed order of every method and of its dense output, on a pendulum in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipj

from symbody.simulation.explicit import Explicit
from tests.simulation.right_hand_sides import pendulum, run

Floats = NDArray[np.float64]

DURATION = 10.0
MODULUS = 0.5  # sine of half the amplitude
# Coarse enough that errors stand well above rounding, fine enough for the leading term.
ALL_METHODS = [(5, (160, 192, 224, 256, 320)), (8, (40, 48, 56, 64, 72))]


def exact(t: Any) -> Floats:
    """Speed and angle of a pendulum through its lowest point at t = 0, from Jacobi's elliptic functions."""
    sn, cn, _, _ = ellipj(t, MODULUS**2)
    return np.array([2 * MODULUS * cn, 2 * np.arcsin(MODULUS * sn)])


def errors(order: int, steps: int) -> tuple[float, float]:
    """Largest error at the ends of so many equal steps, and anywhere."""
    step = DURATION / steps
    method = Explicit(order=order, max_step=step, first_step=step)
    result = run(pendulum, 1, 1, exact(0.0), (0.0, DURATION), method=method, rtol=1e6, atol=1e6)
    assert result.statistics.accepted == steps
    dense = result.dense_output
    assert dense is not None
    anywhere = np.linspace(0.0, DURATION, 5003)
    return (
        float(np.abs(result.x - exact(result.t)).max()),
        float(np.abs(dense(anywhere) - exact(anywhere)).max()),
    )


@pytest.mark.parametrize(("order", "counts"), ALL_METHODS)
def test_the_error_falls_with_the_order_at_steps_and_between_them(
    order: int, counts: tuple[int, ...]
) -> None:
    measured = np.log([errors(order, steps) for steps in counts])
    slopes = np.polyfit(-np.log(counts), measured, 1)[0]
    # a polynomial of degree order - 1 is wrong by h^order between the ends of a step, as the samples are
    np.testing.assert_allclose(slopes, order, atol=0.15)
