"""Observed order of every method, of its dense output, and through impacts, on motions in closed form."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipj

import symbody as sb
from symbody.simulation.methods.explicit import Explicit
from tests.simulation.right_hand_sides import pendulum, run

Floats = NDArray[np.float64]

DURATION = 10.0
MODULUS = 0.5  # sine of half the amplitude
# Coarse enough that errors stand well above rounding, fine enough for the leading term.
ALL_METHODS = [(5, (160, 192, 224, 256, 320)), (8, (40, 48, 56, 64, 72))]

# A mass on a spring that hits a wall where the spring is relaxed: every flight lasts pi, however much speed is
# lost. Flights last so many steps and 0.4 of one, so that impacts cut steps at the same share at every count.
RESTITUTION = 0.8
IMPACTS = 4
BOUNCING = [(5, (90, 115, 145, 180)), (8, (8, 9, 10, 12, 14))]


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


@cache
def mass_on_spring() -> sb.EquationSet:
    drive = sb.Drive(stiffness=1)
    parts = [sb.Body("B", mass=1), sb.Prismatic("j", "ground", "B", axis="y", coordinate="y", force=drive)]
    return sb.form_equations(sb.Model("wall", parts, parameters={"e": RESTITUTION}))


def impact_errors(order: int, steps: int) -> list[float]:
    """Errors of the times of all impacts, and of the state half a flight after the last."""
    step = np.pi / (steps + 0.4)
    result = sb.simulate(
        mass_on_spring(),
        (IMPACTS + 0.5) * np.pi,
        initial={"y": 0.0, "y_dot": 1.0},
        integrator=Explicit(order, max_step=step, first_step=step),
        events=sb.Event("y", -1, {"y_dot": "-e*y_dot"}),
        rtol=0.0,
        atol=1e2,  # loose, yet small enough for the first step after an impact to be the longest allowed
    )
    found = np.array([t for _, t, _ in result.events])
    apart = np.abs(found - np.pi * np.arange(1, IMPACTS + 1))
    amplitude = abs(float(result["y"][-1]) - RESTITUTION**IMPACTS)
    return [*map(float, apart), amplitude, abs(float(result["y_dot"][-1]))]


@pytest.mark.parametrize(("order", "counts"), BOUNCING)
def test_impacts_keep_the_order_of_times_and_states(order: int, counts: tuple[int, ...]) -> None:
    measured = np.array([impact_errors(order, steps) for steps in counts])
    # far above the rounding of times up to 4 pi, 2e-15
    assert measured.min() > 1e-13
    slopes = np.polyfit(-np.log(np.add(counts, 0.4)), np.log(measured), 1)[0]
    # a step cut at an event ends on the dense output, whose error over one step is that of the method over all
    np.testing.assert_allclose(slopes, order, atol=0.15)
