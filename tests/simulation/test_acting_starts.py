"""Events that set values where their value is zero at a start or restart: the first rate that is not zero decides."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from tests.laws.test_cradles import WIDTH, first_values, hits, in_rounds, names_of, rail
from tests.simulation.test_event_starts import INTEGRATORS, driven
from tests.simulation.test_events import BOUNCE, G, ball

ALL = [*INTEGRATORS, sb.GeneralizedAlpha()]
THROWN = np.array([1.0, 1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("integrator", ALL)
def test_a_touching_cradle_by_every_integrator(integrator: object) -> None:
    run = sb.simulate(rail(5), 0.1, first_values(THROWN, 0.0), events=hits(5), integrator=integrator)
    assert run.success and not any("zero first and second derivatives" in note for note in run.notes)
    assert in_rounds(names_of(run)) == [(1, 1), (2, 0), (2, 2), (3, 1), (3, 3), (4, 2)]
    assert [run[f"x{k}_dot"][-1] for k in range(5)] == pytest.approx([0, 0, 0, 1, 1], abs=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_ball_thrown_down_from_its_floor_bounces(integrator: object) -> None:
    """It rises with e*v: at t it is e*v*t - g*t^2/2 high."""
    run = sb.simulate(ball(), 0.05, {"y": 0, "y_dot": -1}, parameters={"e": 0.5}, events=BOUNCE,
                      integrator=integrator)  # fmt: skip
    assert run.success
    assert [event.t for event in run.events] == [0.0]
    e = 0.5
    assert run["y"][-1] == pytest.approx(e * 0.05 - G * 0.05**2 / 2.0, abs=1e-6)


@pytest.mark.parametrize(
    ("start", "action"),
    [({"y_dot": 0}, "-e*y_dot"), ({"y_dot": -1}, "e*y_dot"), ({"y_dot": -1}, "0")],
    ids=["lies", "not turned", "stopped"],
)
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_goes_on_after_its_action_at_a_start_chatters(
    start: dict[str, float], action: str, integrator: object
) -> None:
    """A ball that lies on its floor: the first rate is zero, the second is -g, before the action and after."""
    hit = sb.Event("y", -1, {"y_dot": action}, "hit")
    run = sb.simulate(ball(), 1.0, {"y": 0} | start, events=hit, integrator=integrator)
    assert run.status is sb.Status.CHATTERING and run.t[-1] == 0.0
    assert (
        "event 'hit' happens at the start" in run.notes[-1] and "moves in the same direction" in run.notes[-1]
    )


@pytest.mark.parametrize("action", ["record", "stop"])
def test_events_that_record_or_stop_wait_until_their_value_has_left_zero(action: str) -> None:
    down = sb.Event("y", -1, action, "down")
    fallen = sb.simulate(ball(), 0.5, {"y": 0, "y_dot": -1}, events=down)
    assert fallen.status is sb.Status.SUCCESS and not fallen.events
    thrown = sb.simulate(ball(), 0.5, {"y": 0, "y_dot": 1}, events=down)
    assert [event.t for event in thrown.events] == pytest.approx([2.0 / G])


def test_an_event_without_direction_waits_and_says_so() -> None:
    """From which side its value comes is not known where it never had a sign."""
    bounce = sb.Event("y", 0, {"y_dot": "-e*y_dot"}, "hit")
    run = sb.simulate(ball(), 0.1, {"y": 0, "y_dot": -1}, events=bounce)
    assert not run.events
    assert any("event 'hit'" in note and "direction = 1 or -1" in note for note in run.notes)


def test_a_value_at_rest_is_noted_until_something_happens() -> None:
    rest = sb.simulate(rail(3), 0.1, first_values(np.zeros(3), 0.0), events=hits(3))
    assert rest.success and not rest.events
    assert any(
        note.startswith("events '0', '1'") and "zero first and second derivatives" in note
        for note in rest.notes
    )


def test_what_depends_on_time_alone_happens_once_at_its_start() -> None:
    """No action changes where it goes: x_dot is 1 from the start on, and 2 from the end of the period on."""
    kick = sb.Event("sin(2*pi*t)", 1, {"x_dot": "x_dot + 1"}, "kick")
    run = sb.simulate(driven("0"), 1.5, {"x_dot": 0}, events=kick)
    assert run.success
    assert [event.t for event in run.events] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert run["x"][-1] == pytest.approx(1.0 + 2.0 * 0.5)


def test_a_passage_with_its_own_action_is_one_event() -> None:
    """A mass that is driven as it passes x = 0, beside another event that happens at the same place."""
    events = [
        sb.Event("x", 1, {"x_dot": "x_dot + 1"}, "kick"),
        sb.Event("2*x", 1, {"x_dot": "x_dot + 1"}, "more"),
    ]
    run = sb.simulate(driven("0"), 1.0, {"x": -0.5, "x_dot": 1}, events=events)
    assert run.success
    assert [event.name for event in run.events] == ["kick", "more"]
    assert run["x"][-1] == pytest.approx(3.0 * 0.5)


def test_a_force_that_sets_in_later_is_seen_at_the_sample() -> None:
    """The left ball is pushed from t = 0.1 on, a sample: it hits at once, and the right one leaves at 0."""
    force = sb.Drive(applied="push")
    joints = [
        sb.Prismatic("j0", "ground", sb.Body("A", mass=1), axis="x", coordinate="x0", force=force),
        sb.Prismatic("j1", "ground", sb.Body("B", mass=1), axis="x", coordinate="x1"),
    ]
    push = sb.Signal("push", "if(t < 0.05, 0, 1)", sample=0.1)
    eqs = sb.form_equations(sb.Model("pushed", [*joints, push]))
    run = sb.simulate(eqs, 0.3, {"x1": WIDTH}, events=hits(2))
    assert run.events and run.events[0].t == pytest.approx(0.1)
    assert run.status is sb.Status.CHATTERING  # exchanged speeds of zero leave the push as it is


def test_steps_and_sweeps_agree_with_simulate() -> None:
    eqs, events, start = rail(5), hits(5), first_values(THROWN, 0.0)
    stepper = sb.Stepper(eqs, 0.01, initial=start, inputs=[], events=events)
    happened = []
    for _ in range(5):
        stepper.step()
        happened += [int(event.name) for event in stepper.events]
    assert in_rounds(happened) == [(1, 1), (2, 0), (2, 2), (3, 1), (3, 3), (4, 2)]
    lying = sb.Stepper(ball(), 0.01, initial={"y": 0}, inputs=[], events=BOUNCE)
    with pytest.raises(sb.SimulationError, match="moves in the same direction"):
        lying.step()
    cases = sb.sweep(
        ball(), 0.3, {"e": [0.5, 0.9]}, initial={"y": 0, "y_dot": -1}, times=[0.0, 0.3], events=BOUNCE
    )
    for k, e in enumerate((0.5, 0.9)):
        alone = sb.simulate(ball(), 0.3, {"y": 0, "y_dot": -1}, parameters={"e": e}, events=BOUNCE)
        assert [event.t for event in cases.trajectory(k).events] == [event.t for event in alone.events]
        assert alone.events[0].t == 0.0
    lies = sb.sweep(ball(), 0.3, {"e": [0.5, 0.9]}, initial={"y": 0}, times=[0.0, 0.3], events=BOUNCE)
    assert all("moves in the same direction" in lies.case_notes[k] for k in range(2))


def test_a_step_that_ends_at_a_passage_does_not_repeat_it() -> None:
    """x = -0.5 + t passes zero at the end of a step of 0.5 s; the speed becomes 2 there, once."""
    kick = sb.Event("x", 1, {"x_dot": "x_dot + 1"}, "kick")
    stepper = sb.Stepper(driven("0"), 0.5, initial={"x": -0.5, "x_dot": 1}, inputs=[], events=kick)
    happened = []
    for _ in range(3):
        stepper.step()
        happened += stepper.events
    assert len(happened) == 1
    assert stepper["x_dot"] == pytest.approx(2.0)
