"""Values of events where motions begin anew: bounces down to the tolerance, actions that stop, late times."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.simulation.test_events import BOUNCE, G, at_rest, ball, slider_crank, times_of
from tests.tiers import cases

INTEGRATORS = [None, sb.Explicit(order=5), sb.FixedStep(0.013), sb.Stiff(), sb.Stiff(max_order=2)]


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("floor", cases([0.0, 5.0, -300.0], fast=[5.0]))
def test_no_ball_falls_through_its_floor(integrator: object, floor: float) -> None:
    """Whatever heights and losses, and however low the bounces become: up, down, and never below."""
    random = np.random.default_rng(18)
    for _ in range(2):
        e, height = float(random.choice([1e-3, 0.1, 0.5, 0.8])), 10.0 ** random.uniform(-5, 1)
        direction, span = int(random.choice([0, -1])), float(random.choice([3.0, 300.0]))
        bounce = sb.Event(f"y - ({floor})", direction, {"y_dot": "-e*y_dot"}, "hit")
        given = {"initial": {"y": floor + height}, "parameters": {"e": e}, "integrator": integrator}
        run = sb.simulate(ball(), span, events=bounce, **given)
        ends = np.sqrt(2.0 * height / G) * (1.0 + e) / (1.0 - e)  # where bounces accumulate
        assert run.status is (sb.Status.CHATTERING if ends < span else sb.Status.SUCCESS)
        # of rounding, and of what is tolerated of a place far from zero
        assert run["y"].min() >= floor - 1e-12 * (1.0 + abs(floor))
        assert run.t[-1] <= min(ends, span) * (1.0 + 1e-3) + 3e-3 * np.sqrt(abs(floor))


def test_bounces_end_where_stiff_motions_tolerate_them() -> None:
    """Heights of 1e-10 m are what is tolerated; bounces accumulate some times sqrt(1e-10 / g) before."""
    run = sb.simulate(ball(), 30.0, initial={"y": 1.0}, events=BOUNCE, integrator=sb.Stiff())
    assert run.status is sb.Status.CHATTERING
    assert "event 'hit'" in run.notes[-1]
    assert run.t[-1] == pytest.approx(3.0 * np.sqrt(2.0 / G), abs=1e-4)


@cache
def driven(force: str) -> sb.EquationSet:
    parts = [sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive(applied=force))]
    return sb.form_equations(sb.Model("driven", parts))


@pytest.mark.parametrize("integrator", INTEGRATORS[::2])
@pytest.mark.parametrize(("place", "direction"), [(0.0, 0), (5.0, -1), (-300.0, 0)])
def test_an_action_that_stops_a_motion_is_no_chattering(
    integrator: object, place: float, direction: int
) -> None:
    """From rest the force leads on through the place: x = -(t - T)^2/2 from the moment T there."""
    halt = sb.Event(f"x - ({place})", direction, {"x_dot": 0})
    start = {"x": place + 1.0, "x_dot": -0.3}
    run = sb.simulate(driven("-1"), 5.0, start, events=halt, integrator=integrator)
    assert run.success
    moment = -0.3 + np.sqrt(0.09 + 2.0)
    assert [event.t for event in run.events] == pytest.approx([moment], rel=1e-5)
    assert run["x"][-1] - place == pytest.approx(-((5.0 - moment) ** 2) / 2.0, rel=1e-4)


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(0.001), sb.Stiff()])
def test_a_closed_mechanism_that_is_stopped_goes_on(integrator: object) -> None:
    """What closing the loops leaves of the speed is rounding, of either sign."""
    halt = sb.Event("theta - 0.7", action={"theta_dot": 0})
    run = sb.simulate(slider_crank(), 1.5, inputs={"F": 0.3}, events=halt, integrator=integrator)
    assert run.success


def test_a_mass_between_two_floors_that_stop_it() -> None:
    """A spring leads the mass back through both places again and again; each time it is stopped there once."""
    watched = [sb.Event(f"x - {place}", action={"x_dot": 0}, name=str(place)) for place in (0.5, -0.25)]
    for integrator in (None, sb.Stiff()):
        run = sb.simulate(driven("-x"), 6.0, {"x": 1.0}, events=watched, integrator=integrator)
        assert run.success
        # from rest at 1 to 0.5, from there through 0 to -0.25 and, from rest again, to 0.25 at most
        times = np.cumsum([np.pi / 3.0, np.arccos(-0.5)])
        assert [event.t for event in run.events[:2]] == pytest.approx(times, rel=1e-6)
        assert all(later.t - event.t > 0.1 for event, later in zip(run.events, run.events[1:], strict=False))


@pytest.mark.parametrize("at", [98765.4321, 123456.789])
@pytest.mark.parametrize("integrator", INTEGRATORS[:2] + INTEGRATORS[3:])
def test_a_late_time_happens_once(at: float, integrator: object) -> None:
    kick = sb.Event(f"t - {at}", action={"y_dot": 1}, name="kick")
    run = sb.simulate(at_rest(), 1e6, integrator=integrator, events=kick)
    assert run.status is sb.Status.SUCCESS
    np.testing.assert_allclose(times_of(run, "kick"), [at], rtol=1e-15)


@pytest.mark.parametrize("integrator", cases(INTEGRATORS[:4:2] + INTEGRATORS[3:4], fast=INTEGRATORS[:1]))
@pytest.mark.parametrize(
    ("value", "times", "word"),
    [
        ("1/(t - 1)", [], "at t = 1 s at a pole"),
        ("tan(t)", [], "at t = 1.5708 s at a pole"),
        ("1/sin(3*t)", [], "at t = 1.0472 s at a pole"),
        ("1/(t - 1) + 1/(t - 2)", [1.5], "at t = 1 s at a pole"),
        ("1/(t - 1)**2 - 4", [0.5, 1.5], ""),
        ("floor(t) - 0.5", [1.0], ""),
        ("t - floor(t) - 0.5", [0.5, 1.0, 1.5, 2.0, 2.5], ""),
        ("sqrt(1 - t) - 0.5", [0.75], "not a number at t = 1"),
        ("log(t - 1)", [2.0], "not a number at t = 0 s"),
    ],
)
def test_poles_and_values_that_are_no_numbers(
    integrator: object, value: str, times: list[float], word: str
) -> None:
    run = sb.simulate(at_rest(), 2.9, events=sb.Event(value), integrator=integrator)
    assert run.success
    assert [event.t for event in run.events] == pytest.approx(times, rel=1e-9)
    notes = [note for note in run.notes if note.startswith("event ")]
    assert len(notes) == (1 if word else 0)
    assert all(word in note and repr(value) in note for note in notes)


@pytest.mark.parametrize("integrator", [*INTEGRATORS, sb.GeneralizedAlpha()])
@pytest.mark.parametrize("height", cases([0.3, 5.0, -300.0], fast=[0.3]))
def test_what_begins_at_rest_where_its_event_is_zero_just_leaves(integrator: object, height: float) -> None:
    """Also where first steps are so short that they move the place by roundings, up or down."""
    events = [sb.Event(f"y - ({height})", 0, name="any"), sb.Event(f"y - ({height})", -1, "stop", "down")]
    run = sb.simulate(ball(), 1.0, initial={"y": height}, events=events, integrator=integrator)
    assert run.status is sb.Status.SUCCESS and not run.events
