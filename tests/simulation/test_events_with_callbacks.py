"""Events beside inputs computed in Python, interruptions and failures inside the loop that looks for them."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.errors import SimulationError
from symbody.simulation.inputs.steepness import NODES
from tests.simulation.test_events import ball, times_of


def pushed() -> sb.EquationSet:
    parts = [sb.Body("B", mass=2), sb.Prismatic("j", "ground", "B", coordinate="x", force=sb.Drive("F"))]
    return sb.form_equations(sb.Model("pushed", parts, inputs=["F"]))


def test_events_watch_what_python_computes() -> None:
    run = sb.simulate(
        pushed(), 3.0, inputs={"F": lambda t, q, u: 2.0 * np.cos(t)}, events=[sb.Event("F"), sb.Event("x_dot - 0.5")]
    )  # fmt: skip
    # x_dot = sin(t): F is zero at pi/2, x_dot a half at pi/6 and 5 pi/6; rtol 1e-8 a step
    np.testing.assert_allclose(times_of(run, "F"), [np.pi / 2.0], rtol=1e-14)
    np.testing.assert_allclose(times_of(run, "x_dot - 0.5"), [np.pi / 6.0, 5.0 * np.pi / 6.0], rtol=1e-7)


def test_a_law_that_fails_where_only_events_look_is_named() -> None:
    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        if abs((t - 1.0) / 0.1 - NODES[1]) < 1e-6:  # no stage of the step lies there
            raise ValueError("no more")
        return 0.0

    steps = sb.FixedStep(0.1)
    assert sb.simulate(pushed(), 3.0, inputs={"F": law}, integrator=steps).success
    with pytest.raises(SimulationError, match="no more"):
        sb.simulate(pushed(), 3.0, inputs={"F": law}, events=sb.Event("F - 1"), integrator=steps)


def test_an_interrupted_motion_ends_where_it_was_seen() -> None:
    calls = []

    def progress(share: float) -> bool:
        calls.append(share)
        return len(calls) < 3

    bounce = sb.Event("y", -1, {"y_dot": "-y_dot"}, "hit")
    run = sb.simulate(ball(), 500.0, initial={"y": 1.0}, events=bounce, progress=progress)
    assert run.status is sb.Status.INTERRUPTED and run.events
    assert run["y"].min() > -1e-9 and run.t[-1] >= run.events[-1].t
    assert run.at(run.t[-1])["y"] == pytest.approx(run["y"][-1], abs=1e-12)


def test_steps_of_one_length_bounce_too() -> None:
    bounce = sb.Event("y", -1, {"y_dot": "-y_dot"}, "hit")
    run = sb.simulate(ball(), 5.0, initial={"y": 1.0}, events=bounce, integrator=sb.FixedStep(0.01))
    fall = np.sqrt(2.0 / 9.81)
    np.testing.assert_allclose(
        times_of(run, "hit"), fall * np.arange(1, 12, 2)[: len(run.events)], rtol=1e-12
    )
