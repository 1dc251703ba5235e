"""Events: where they are found, what they do, and in which order."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.errors import FormulationError, UsageError
from symbody.simulation.results.trajectory import Trajectory
from tests.mechanisms import pendulum

EXAMPLES = Path(__file__).parents[2] / "examples"
EPS = np.finfo(float).eps
G = 9.81


@cache
def at_rest() -> sb.EquationSet:
    """A slider without forces: every step is as long as the integrator allows."""
    parts = [sb.Body("B", mass="m"), sb.Prismatic("j", "ground", "B", axis="y", coordinate="y")]
    return sb.form_equations(sb.Model("slider", parts, parameters={"m": 2}))


@cache
def ball() -> sb.EquationSet:
    parts = [sb.Body("B", mass="m"), sb.Prismatic("j", "ground", "B", axis="y", coordinate="y")]
    parameters = {"m": 2, "e": "0.5"}
    return sb.form_equations(sb.Model("ball", parts, parameters=parameters, gravity=(0, "-9.81", 0)))


@cache
def slider_crank() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))


def times_of(run: Trajectory, name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([t for found, t, _ in run.events if found == name])


BOUNCE = sb.Event("y", -1, {"y_dot": "-e*y_dot"}, "hit")


@pytest.mark.parametrize("order", [5, 8])
def test_every_zero_is_found_though_the_steps_are_longer_than_the_period(order: int) -> None:
    run = sb.simulate(at_rest(), 100.0, integrator=sb.Explicit(order=order), events=sb.Event("sin(t)"))
    assert run.statistics.accepted < 31
    # at k pi the argument, its sine and Brent's last step are each rounded once: some ulp of 100
    np.testing.assert_allclose(times_of(run, "sin(t)"), np.pi * np.arange(1, 32), rtol=0, atol=400 * EPS)


def test_grazing_values_count_once_and_near_misses_do_not() -> None:
    watched = {"top": "sin(t) - 1", "bottom": "1 + sin(t)", "miss": "sin(t) - 1 - 1e-8"}
    run = sb.simulate(at_rest(), 100.0, events=[sb.Event(text, name=name) for name, text in watched.items()])
    turns = 2 * np.pi * np.arange(16)
    # where the derivative of the interpolant through 13 points vanishes: 1e-15 over an interval of about 0.1
    np.testing.assert_allclose(times_of(run, "top"), np.pi / 2 + turns, rtol=0, atol=1e-10)
    np.testing.assert_allclose(times_of(run, "bottom"), 1.5 * np.pi + turns[:16], rtol=0, atol=1e-10)
    assert times_of(run, "miss").size == 0


def test_two_zeros_between_two_samples_are_both_found() -> None:
    run = sb.simulate(at_rest(), 100.0, events=sb.Event("sin(t) - 1 + 1e-8", name="pair"))
    # sin(pi/2 + d) = 1 - 1e-8 at d = +-sqrt(2e-8), up to d^3; its slope 1.4e-4 divides an ulp of 1
    pairs = np.pi / 2 + 2 * np.pi * np.arange(16)[:, np.newaxis] + np.sqrt(2e-8) * np.array([-1, 1])
    np.testing.assert_allclose(times_of(run, "pair"), pairs.ravel(), rtol=0, atol=1e-11)


def test_directions() -> None:
    events = [sb.Event("cos(t)", 1, name="up"), sb.Event("cos(t)", -1, name="down")]
    run = sb.simulate(at_rest(), 10.0, events=events)
    np.testing.assert_allclose(times_of(run, "down"), np.pi * np.array([0.5, 2.5]), rtol=1e-14)
    np.testing.assert_allclose(times_of(run, "up"), np.pi * np.array([1.5]), rtol=1e-14)
    back = sb.simulate(at_rest(), (10.0, 0.0), events=events)  # the motion runs against time
    np.testing.assert_allclose(times_of(back, "up"), np.pi * np.array([2.5, 0.5]), rtol=1e-14)


def test_a_value_that_starts_at_zero_has_to_leave_it_first() -> None:
    run = sb.simulate(ball(), 2.0, initial={"y_dot": 5.0}, events=sb.Event("y"))
    assert len(run.events) == 1
    # y = 5 t - g t^2 / 2; rtol 1e-8 a step, and a parabola is exact for either method
    assert run.events[0].t == pytest.approx(10.0 / G, rel=1e-12)
    assert not sb.simulate(at_rest(), 2.0, events=sb.Event("y")).events


def test_a_stop_is_the_last_sample() -> None:
    stop = sb.Event("y", action="stop", name="floor")
    run = sb.simulate(ball(), 9.0, initial={"y": 1.0}, events=[stop, sb.Event("y - 0.5", name="half")])
    fall = np.sqrt(2.0 / G)
    assert run.status is sb.Status.STOPPED and run.success
    assert [name for name, _, _ in run.events] == ["half", "floor"]
    assert run.t[-1] == run.events[-1].t == pytest.approx(fall, rel=1e-13)
    assert abs(run["y"][-1]) < 4 * EPS
    assert run.at(run.t[-1])["y"] == pytest.approx(run["y"][-1], abs=4 * EPS)
    with pytest.raises(UsageError, match="outside the motion"):
        run.at(1.01 * fall)
    wanted = sb.simulate(ball(), 9.0, initial={"y": 1.0}, times=np.linspace(0, 9, 91), events=stop)
    assert wanted.t.tolist() == [*np.linspace(0, 9, 91)[:5], run.t[-1]]
    # between samples: y = 1 - g t^2 / 2 is a polynomial that the cut piece reproduces
    t = np.linspace(0.0, run.t[-1], 50)
    np.testing.assert_allclose(run.at(t)["y"], 1 - G * t**2 / 2, rtol=0, atol=1e-13)


def test_a_map_starts_the_motion_anew() -> None:
    run = sb.simulate(ball(), 1.2, initial={"y": 1.0}, events=BOUNCE)
    first, speed = np.sqrt(2.0 / G), np.sqrt(2.0 * G)
    hits = first + 2 * first * np.cumsum([0.0, 0.5, 0.25])
    np.testing.assert_allclose(times_of(run, "hit"), hits[hits < 1.2], rtol=1e-13)
    assert run.events[0].state == pytest.approx({"y": 0.0, "y_dot": -speed}, abs=1e-12)
    place = int(np.searchsorted(run.t, run.events[0].t))
    assert run.t[place] == run.t[place + 1]  # before and after
    np.testing.assert_allclose(run["y_dot"][place : place + 2], [-speed, speed / 2], rtol=1e-12)
    t = np.linspace(hits[0], hits[1], 20)[1:-1]
    s = t - hits[0]
    np.testing.assert_allclose(run.at(t)["y"], speed / 2 * s - G * s**2 / 2, rtol=0, atol=1e-12)
    # what a bounce takes away is work: 3/4 of m g h, then 3/4 of the rest
    assert run.work[-1] == pytest.approx(-2 * G * (1 - 0.25**3), rel=1e-12)
    assert run.energy_drift < 1e-12


def test_wanted_times_go_on_through_maps() -> None:
    times = np.linspace(0.0, 1.2, 25)
    run = sb.simulate(ball(), 1.2, initial={"y": 1.0}, times=times, events=BOUNCE)
    every = sb.simulate(ball(), 1.2, initial={"y": 1.0}, events=BOUNCE)
    np.testing.assert_array_equal(run.t, times)
    np.testing.assert_allclose(run["y"], every.at(times)["y"], rtol=0, atol=1e-13)


@pytest.mark.parametrize("e", ["0.9", "0.5", "0.1"])
def test_chattering_ends_the_run_where_the_bounces_accumulate(e: str) -> None:
    run = sb.simulate(ball(), 30.0, initial={"y": 1.0}, parameters={"e": e}, events=BOUNCE)
    assert run.status is sb.Status.CHATTERING and not run.success
    assert "event 'hit'" in run.notes[-1]
    # the remaining bounces take less than the instant of 1e-7 of the span, over 1 - e for those to come
    end = np.sqrt(2.0 / G) * (1 + float(e)) / (1 - float(e))
    assert run.t[-1] == pytest.approx(end, abs=1e-7 * 30.0 / (1 - float(e)))
    assert run["y"].min() > -1e-12


def test_simultaneous_events_come_in_the_order_given() -> None:
    names = "dcba"
    events = [sb.Event("y - 0.5", name=name) for name in names]
    run = sb.simulate(ball(), 9.0, initial={"y": 1.0}, events=events)
    assert "".join(name for name, _, _ in run.events) == names
    mapped = [
        sb.Event("y", -1, {"y_dot": "1"}, "first"),
        sb.Event("2*y", -1, {"y_dot": "3*y_dot"}, "second"),
        sb.Event("t - 0.6", 0, "stop"),
    ]
    run = sb.simulate(ball(), 9.0, initial={"y": 1.0}, events=mapped)
    assert [name for name, _, _ in run.events] == ["first", "second", "t - 0.6"]
    fall = np.sqrt(2.0 / G)
    assert run["y_dot"][-1] == pytest.approx(3.0 - G * (0.6 - fall), rel=1e-12)


def test_what_is_found_does_not_depend_on_the_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    events = [sb.Event("sin(3*theta)"), sb.Event("theta_dot - 3"), sb.Event("theta", 1, {"theta_dot": "2"})]
    whole = sb.simulate(pendulum(), 20.0, initial={"theta": 2.0}, events=events)
    monkeypatch.setattr("symbody.simulation.native.run.FIRST_SLICE", 1)
    monkeypatch.setattr("symbody.simulation.native.run.SLICE_SECONDS", 0.0)
    single = sb.simulate(pendulum(), 20.0, initial={"theta": 2.0}, events=events)
    assert whole.events == single.events and len(whole.events) > 20
    np.testing.assert_array_equal(whole.q, single.q)


def test_events_of_a_pendulum_against_its_period() -> None:
    run = sb.simulate(
        pendulum(), 20.0, initial={"theta": 2.0}, rtol=1e-12, atol=1e-13, events=sb.Event("theta")
    )
    # complete elliptic integral by the arithmetic-geometric mean
    a, b = 1.0, np.cos(1.0)
    for _ in range(6):
        a, b = (a + b) / 2, np.sqrt(a * b)
    half = np.pi / np.sqrt(G) / a
    found = times_of(run, "theta")
    # local errors of 1e-12 in some 300 steps move the phase by some 1e-10
    np.testing.assert_allclose(found, half * (np.arange(found.size) + 0.5), rtol=0, atol=1e-9)


def test_maps_on_a_closed_loop_leave_it_closed() -> None:
    brake = sb.Event("sin(theta)", 0, {"theta_dot": "0.5*theta_dot"}, "brake")
    run = sb.simulate(slider_crank(), 3.0, initial={"theta_dot": 8.0}, events=brake)
    assert len(run.events) >= 3
    assert run.constraint_violation.max() < 1e-9
    assert run.velocity_violation.max() < 1e-14
    for _, t, before in run.events:
        k = int(np.searchsorted(run.t, t))
        # The crank turns half as fast, and of a loop with one freedom all else does: rates are linear in one.
        set_to = [before[name] / 2 for name in ("theta_dot", "beta_dot", "s_dot")]
        after = [float(run[name][k + 1]) for name in ("theta_dot", "beta_dot", "s_dot")]
        assert after[0] == set_to[0]
        # closed to 1e-10 of lengths and angles before and after, of which rates of some 10 rad/s follow
        np.testing.assert_allclose(after, set_to, rtol=0, atol=1e-8)
    assert run.energy_drift < 1e-6 * run["kinetic_energy"].max()


def test_reactions_and_named_angles_can_be_watched() -> None:
    events = [sb.Event("reaction A Fx", name="force"), sb.Event("theta - 1 + s*B")]
    data_run = sb.simulate(slider_crank(), 2.0, events=events)
    for name, t, _ in data_run.events:
        moment = data_run.at(t)
        # Brent's last step is an ulp of t; the force changes by less than 1e5 N/s here
        assert abs(float(moment["reaction A Fx" if name == "force" else name])) < 1e-9
    assert {name for name, _, _ in data_run.events} == {"force", "theta - 1 + s*B"}


def test_events_see_the_turns_of_a_measured_angle() -> None:
    # joint D is cut, so the angle of the follower's pin is a sum of the crank's and of the rod's
    each = [sb.Event(f"(B) + {2 * np.pi * k - 1!r}", name=str(k)) for k in range(30)]
    turned = sb.Event("sin((B)/2 - 1/2)", name="turned")
    run = sb.simulate(slider_crank(), 4.0, initial={"theta_dot": 20.0}, events=[*each, turned])
    angle = run["(B)"]  # "B" is the matrix of the inputs
    assert (angle.max() - angle.min()) / (2 * np.pi) > 5
    unwound = np.floor((angle - 1) / (2 * np.pi))
    passed = np.count_nonzero(np.diff(unwound))
    assert times_of(run, "turned").size == passed == len(run.events) - passed
    for k, event in enumerate(each):
        assert times_of(run, str(k)).size == np.count_nonzero(np.diff(np.sign(angle + 2 * np.pi * k - 1))), (
            event
        )


def test_what_is_refused() -> None:
    for bad in ({"direction": 2}, {"action": "jump"}, {"action": {}}):
        with pytest.raises(UsageError, match="is not a valid choice"):
            sb.Event("y", **bad)
    with pytest.raises(FormulationError, match="neither an output nor an expression"):
        sb.simulate(ball(), 1.0, events=sb.Event("z"))
    with pytest.raises(UsageError, match="shape"):
        sb.simulate(ball(), 1.0, events=sb.Event("reaction j"))
    with pytest.raises(UsageError, match="'m' is not a state"):
        sb.simulate(ball(), 1.0, events=sb.Event("y", 0, {"m": "1"}))
    with pytest.raises(UsageError, match="its own name"):
        sb.simulate(ball(), 1.0, events=[sb.Event("y"), sb.Event("y", 1)])
    with pytest.raises(UsageError, match="not an event"):
        sb.simulate(ball(), 1.0, events=["y"])


def test_events_survive_a_file(tmp_path: Path) -> None:
    run = sb.simulate(ball(), 1.2, initial={"y": 1.0}, events=BOUNCE)
    run.save(tmp_path / "run.npz")
    again = sb.Trajectory.load(tmp_path / "run.npz")
    assert again.events == run.events
    assert again.events[0].name == "hit"
    np.testing.assert_array_equal(again.at(1.0)["y"], run.at(1.0)["y"])


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(0.037), sb.Stiff()])
def test_an_action_that_leads_away_from_zero_is_not_chattering(integrator: object) -> None:
    """Speed grows by 9.81 m/s a second and is taken back to 0 at 4.905 m/s: every half second, for ever."""
    watched = sb.Event("y_dot + 4.905", action={"y_dot": 0}, name="reset")
    run = sb.simulate(ball(), 2.25, integrator=integrator, events=watched)
    assert run.status is sb.Status.SUCCESS
    np.testing.assert_allclose(times_of(run, "reset"), [0.5, 1.0, 1.5, 2.0], rtol=1e-6)


def test_times_that_rounding_shakes_are_not_chattering() -> None:
    watched = sb.Event("t - 1234.56789", action={"y_dot": 1}, name="kick")
    run = sb.simulate(at_rest(), 1e4, integrator=sb.Stiff(), events=watched)
    assert run.status is sb.Status.SUCCESS
    np.testing.assert_allclose(times_of(run, "kick"), [1234.56789], rtol=1e-15)
    assert run["y"][-1] == pytest.approx(1e4 - 1234.56789, rel=1e-8)


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(0.25), sb.Stiff()])
def test_the_last_wanted_time_is_the_state_after_an_event_there(integrator: object) -> None:
    watched = sb.Event("t - 2", action={"y_dot": 5})
    run = sb.simulate(at_rest(), 2.0, times=[0.0, 2.0], integrator=integrator, events=watched)
    assert run["y_dot"].tolist() == [0.0, 5.0]


@pytest.mark.parametrize("integrator", [None, sb.Stiff()])
@pytest.mark.parametrize(("formula", "value"), [("sqrt(y - 1)", "nan"), ("1/max(y - 1, 0)", "inf")])
def test_an_action_without_a_value_is_named(integrator: object, formula: str, value: str) -> None:
    hit = sb.Event("y", -1, {"y": "0", "y_dot": formula}, "hit")
    run = sb.simulate(ball(), 2.0, initial={"y": 1.0}, events=hit, integrator=integrator)  # type: ignore[arg-type]
    assert run.status is sb.Status.NOT_FINITE
    note = run.notes[-1]
    assert f"the action of event 'hit' sets y_dot to {value}: '{formula}'" in note
    assert "use a formula" in note
    assert run.t[-1] == run.events[-1].t == pytest.approx(np.sqrt(2.0 / G), rel=1e-5)
    assert run["y_dot"][-1] == pytest.approx(-np.sqrt(2.0 * G), rel=1e-5)
    stepper = sb.Stepper(ball(), 0.1, initial={"y": 1.0}, events=hit, integrator=integrator)  # type: ignore[arg-type]
    with pytest.raises(sb.SimulationError, match="event 'hit' sets y_dot") as caught:
        while stepper.t < 2.0:
            stepper.step()
    assert caught.value.problems[0].code == "stepper.broke_off"
    assert stepper["y_dot"] == pytest.approx(-np.sqrt(2.0 * G), rel=1e-5)
    if integrator is None:
        cases = sb.sweep(ball(), 2.0, initial={"y": [1.0, 30.0]}, times=[0.0, 2.0], events=hit)
        assert [status.name for status in cases.status] == ["NOT_FINITE", "SUCCESS"]
        assert any("sets y_dot" in note for note in cases.trajectory(0).notes)


def test_a_change_of_modes_repeats_no_event_since_the_last_sample() -> None:
    """A joint breaks away between two samples, behind an event that has taken its value to the other side."""
    body = sb.Body("Block", mass=2)
    pull = sb.Drive(applied="pull + 12*sin(3*t) - 5*x")
    slide = sb.Prismatic("slide", "ground", body, axis="x", coordinate="x",
                         friction=sb.Friction(0.3, mu_static=0.4), force=pull)  # fmt: skip
    held = sb.Signal("pull", "0.01*x", sample=0.9)
    start = {"x": 1.0, "x_dot": 2.0}
    eqs = sb.form_equations(sb.Model("block", [body, slide, held], (0, 0, -9.81), initial=start))
    run = sb.simulate(eqs, 1.5, events=sb.Event("t - 1", name="once"))
    assert [change.mode for change in run.modes if change.t > 1.0] == ["slips backward"]
    assert [event.t for event in run.events if event.name == "once"] == [1.0]
