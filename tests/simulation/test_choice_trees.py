"""Tables in formulas are looked at before a motion as step functions: the same pieces, in less work."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.inputs import time_functions as functions_of_time
from symbody.simulation.inputs.breakpoints import Breakpoints, find_breakpoints
from symbody.simulation.inputs.time_functions import time_functions

SPAN = (0.0, 3.0)
# Beside its time a change is known to some roundings of the largest time.
MARGIN = 64 * float(np.finfo(float).eps) * SPAN[1]


def pieces(
    argument: str, points: list[tuple[float, float]], slopes: np.ndarray
) -> tuple[list[Breakpoints], int]:
    """The pieces for some values of a parameter, and the number of operations looked at."""
    parts = [
        sb.Body("B", mass=1),
        sb.Lookup("road", points=points, argument=argument),
        sb.Prismatic("j", "ground", "B", coordinate="x", force=sb.Drive(applied="3*road + sin(t)")),
    ]
    eqs = sb.form_equations(sb.Model("m", parts, parameters={"k": 1}))
    function = sb.compile(eqs, "udot", free=["k"])
    functions = time_functions(function.sequence, {}, with_parameters=True)
    assert functions is not None
    return find_breakpoints(functions, SPAN, slopes[:, np.newaxis]), len(functions.operations)


@pytest.mark.parametrize("argument", ["t", "k*t", "1 - k*t/2", "k*t + 0.3"])
@pytest.mark.parametrize("jumps", [False, True])
def test_the_pieces_are_those_of_the_choices(
    argument: str, jumps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(7)
    places = np.sort(rng.uniform(-1, 4, 40))
    if jumps:
        places[10] = places[11]
        places[20] = places[21]
    points = [(float(x), float(y)) for x, y in zip(places, rng.uniform(-1, 1, 40), strict=True)]
    slopes = np.array([1.0, 0.4, 1.7])
    folded, few = pieces(argument, points, slopes)
    monkeypatch.setattr(functions_of_time, "_FEWEST", 10**9)
    plain, many = pieces(argument, points, slopes)
    assert few < many / 4
    for one, two in zip(folded, plain, strict=True):
        assert one.times.size > 2
        np.testing.assert_allclose(one.times, two.times, rtol=0, atol=MARGIN)
        np.testing.assert_allclose(one.longest, two.longest, rtol=0, atol=4 * MARGIN)
        np.testing.assert_array_equal(one.jumps, two.jumps)


def test_values_at_bounds_and_beyond() -> None:
    steps = functions_of_time.StepFunction(0, np.array([0.0, 1.0, 2.0]), np.array([5.0, 6.0, 7.0, 8.0]))
    np.testing.assert_array_equal(
        steps.evaluate(np.array([-1.0, 0.0, 0.5, 1.0, 2.0, 9.0, np.nan])), [5, 6, 6, 7, 8, 8, 8]
    )


def test_a_motion_over_a_long_table_is_that_of_its_points() -> None:
    places = np.linspace(0.0, 2.0, 400)
    points = [(float(x), float(np.sin(7 * x))) for x in places]
    parts = [
        sb.Body("B", mass=1),
        sb.Lookup("push", points=points),
        sb.Prismatic("j", "ground", "B", coordinate="x", force=sb.Drive(applied="push")),
    ]
    run = sb.simulate(sb.form_equations(sb.Model("m", parts)), 2.0)
    # Straight lines between points of a sine fall short of it by at most (7 h)^2/8.
    assert run["x"][-1] == pytest.approx(2.0 / 7 - np.sin(14.0) / 49, abs=5e-4)
