"""Events that nobody chose: all integrators, and the loop over many cases, find the same."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.results.trajectory import Trajectory
from tests.tiers import cases

END = 6.0


@cache
def oscillator() -> sb.EquationSet:
    force = sb.Drive("-k*x - 0.1*x_dot + cos(3*t)")
    parts = [sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=force)]
    return sb.form_equations(sb.Model("oscillator", parts, parameters={"k": 4.0}))


def random_events(random: np.random.Generator) -> list[sb.Event]:
    events = []
    for k in range(int(random.integers(1, 4))):
        a, b, c = (round(float(number), 3) for number in random.uniform(-1.0, 1.0, 3))
        values = [f"x - ({a})", f"x_dot + ({a})*x", f"sin({3 * abs(b) + 0.5}*t) - ({a})", f"x**2 - {abs(a)}"]
        values.append(f"x*x_dot - ({0.3 * a})")
        actions = ["record", {"x_dot": "-0.7*x_dot"}, {"x_dot": f"x_dot/2 + ({c})"}, {"x_dot": 0}, {"x": b}]
        chosen = int(random.integers(len(values))), int(random.integers(len(actions)))
        way = int(random.integers(-1, 2))
        events.append(sb.Event(values[chosen[0]], way, actions[chosen[1]], f"e{k}"))  # type: ignore[arg-type]
    return events


def assert_same(run: Trajectory, usual: Trajectory, tolerance: float) -> None:
    assert run.status is usual.status
    assert [event.name for event in run.events] == [event.name for event in usual.events]
    np.testing.assert_allclose(
        [event.t for event in run.events], [event.t for event in usual.events], atol=tolerance
    )


@pytest.mark.parametrize("seed", cases(range(10), fast=[1]))
def test_random_events_are_the_same_for_all_integrators(seed: int) -> None:
    random = np.random.default_rng(seed)
    events, x = random_events(random), float(random.uniform(-1.0, 1.0))
    given = {"events": events, "rtol": 1e-10}
    usual = sb.simulate(oscillator(), END, {"x": x}, **given)
    for method in (sb.Explicit(order=5), sb.FixedStep(2e-3)):
        assert_same(sb.simulate(oscillator(), END, {"x": x}, integrator=method, **given), usual, 1e-5)
    cases = sb.sweep(oscillator(), END, {"k": [4.0, 5.0]}, initial={"x": x}, times=[0.0, END], **given)
    assert_same(cases.trajectory(0), usual, 1e-5)
    stiff = sb.simulate(oscillator(), END, {"x": x}, integrator=sb.Stiff(), events=events)
    if usual.status is sb.Status.CHATTERING:  # which an implicit method ends at bounces it still tolerates
        assert stiff.status is usual.status and stiff.t[-1] == pytest.approx(usual.t[-1], abs=1e-3)
        return
    assert_same(stiff, usual, 1e-3)
