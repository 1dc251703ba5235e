"""Instants of samples: products of a count and a time, in the order of the model, beside events and ends."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.model.element import Element
from tests.tiers import cases


def cart(*elements: Element, force: str = "0", speed: float = 1.0) -> sb.EquationSet:
    """Equations of a cart of 1 kg on a rail."""
    drive = sb.Drive(applied=force)
    joint = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=drive)
    return sb.form_equations(sb.Model("cart", [joint, *elements], initial={"x_dot": speed}))


TENTHS = np.linspace(0.0, 1.0, 11)


@pytest.mark.parametrize("force", ["0", "sin(a)", "0.1*a + 0.2*b - 0.3*c"])
def test_values_of_two_rates_follow_the_order_of_the_model(force: str) -> None:
    a, b = sb.Signal("a", "a + 1", sample=0.1), sb.Signal("b", "a", sample=0.3)
    c = sb.Signal("c", "b + 10*a", sample=0.1)
    run = sb.simulate(cart(a, b, c, force=force), 1.0, times=TENTHS)
    np.testing.assert_array_equal(run["a"], np.arange(1, 12))
    np.testing.assert_array_equal(run["b"], [1, 1, 1, 4, 4, 4, 7, 7, 7, 10, 10])
    np.testing.assert_array_equal(run["c"], run["b"] + 10 * run["a"])
    run = sb.simulate(cart(b, a, c, force=force), 1.0, times=TENTHS)  # b has what a was before
    np.testing.assert_array_equal(run["b"], [0, 0, 0, 3, 3, 3, 6, 6, 6, 9, 9])
    np.testing.assert_array_equal(run["c"], run["b"] + 10 * run["a"])
    assert run.held_values is not None
    assert run.held_values.t.size == 11  # 0.3 and 3*0.1 are one instant


def test_a_ring_of_values_has_the_delay_of_a_sample() -> None:
    eqs = cart(sb.Signal("a", "b + 1", sample=0.1), sb.Signal("b", "2*a", sample=0.1), force="a")
    run = sb.simulate(eqs, 0.3)
    assert run.held_values is not None
    np.testing.assert_array_equal(run.held_values.values, [[1, 3, 7, 15], [2, 6, 14, 30]])


@pytest.mark.parametrize("start", cases([0.0, 5.0], fast=[5.0]))
def test_a_million_samples_do_not_drift(start: float) -> None:
    eqs = cart(sb.Signal("n", "n + 1", sample=1e-3), force="sin(n)")
    run = sb.simulate(eqs, (start, start + 1000.0), times=[start + 1000.0], max_steps=10_000_000)
    assert run["n"][0] == 1_000_001
    assert run.held_values is not None
    np.testing.assert_allclose(run.held_values.t, start + 1e-3 * np.arange(1_000_001), rtol=1e-15)


def test_a_sample_time_may_leave_the_end_between_two_samples() -> None:
    run = sb.simulate(cart(sb.Signal("n", "n + 1", sample=0.3), force="n"), 1.0)
    assert run.held_values is not None
    np.testing.assert_allclose(run.held_values.t, [0.0, 0.3, 0.6, 0.9], rtol=1e-15)
    wanted, speed, place = [1, 2, 3, 4], 1.0, 0.0
    for force, length in zip(wanted, [0.3, 0.3, 0.3, 0.1], strict=True):
        place += speed * length + force * length**2 / 2
        speed += force * length
    assert run["x"][-1] == pytest.approx(place, rel=1e-13)
    assert run["x_dot"][-1] == pytest.approx(speed, rel=1e-13)


def test_outputs_at_samples_have_the_new_values() -> None:
    eqs = cart(sb.Signal("n", "n + 1", sample=0.1), force="n")
    every, given = sb.simulate(eqs, 1.0), sb.simulate(eqs, 1.0, times=TENTHS)
    np.testing.assert_array_equal(given["n"], np.arange(1, 12))
    np.testing.assert_array_equal(given["x_ddot"], given["n"])
    for run in (every, given):
        assert run["n"][-1] == 11  # a sample at the end of the motion is taken
        np.testing.assert_array_equal(run["x_ddot"], run["n"])
    np.testing.assert_array_equal(sb.simulate(eqs, 0.0)["n"], [1.0])


def test_what_an_event_sets_is_sampled_at_the_same_instant() -> None:
    eqs = cart(sb.Signal("v", "x_dot", sample=0.25), force="0*v")
    push = sb.Event("t - 0.5", action={"x_dot": "x_dot + 1"})
    for times in (None, np.linspace(0, 1, 5)):
        run = sb.simulate(eqs, 1.0, events=push, times=times)
        assert run.held_values is not None
        np.testing.assert_allclose(run.held_values.values[0], [1, 1, 2, 2, 2], rtol=1e-14)
        assert [event.t for event in run.events] == [0.5]


def test_values_that_jump_at_samples_are_events() -> None:
    eqs = cart(sb.Signal("n", "n + 1", sample=0.25), force="n")
    events = [
        sb.Event("n - 2.5", name="rises", direction=1),
        sb.Event("2.5 - n", name="never", direction=1),
        sb.Event("x_ddot - 3.5", name="pushed"),
        sb.Event("x - 1.2", name="place"),
    ]
    run = sb.simulate(eqs, 1.0, events=events)
    happened = {event.name: event.t for event in run.events}
    assert set(happened) == {"rises", "pushed", "place"}
    assert happened["rises"] == pytest.approx(0.5, rel=1e-14)
    assert happened["pushed"] == pytest.approx(0.75, rel=1e-14)
    assert run.at(happened["place"])["x"] == pytest.approx(1.2, rel=1e-12)


def test_an_event_that_acts_at_a_jump_goes_on_from_there() -> None:
    eqs = cart(sb.Signal("n", "n + 1", sample=0.25), force="n")
    stop = sb.Event("n - 2.5", action={"x_dot": 0})
    run = sb.simulate(eqs, 1.0, events=stop)
    assert run["x_dot"][-1] == pytest.approx(3 * 0.25 + 4 * 0.25, rel=1e-12)
    ended = sb.simulate(eqs, 1.0, events=sb.Event("n - 2.5", action="stop"))
    assert ended.t[-1] == pytest.approx(0.5, rel=1e-14)


def test_an_event_just_behind_a_sample_is_not_lost() -> None:
    """By rounding alone 3*0.29 lies before 0.87, and many an n/10 before a crossing at n*0.1*speed."""
    eqs = cart(sb.Signal("v", "x_dot", sample=0.29), force="0*t + 1e-300*v")
    for event in ("t - 0.87", "t - 0.87 + 0*x", "x - 0.87"):
        run = sb.simulate(eqs, 2.0, events=sb.Event(event, 1, {"x_dot": "x_dot + 4"}))
        assert [occurrence.t for occurrence in run.events] == pytest.approx([0.87], rel=1e-12), event
        assert run["x"][-1] == pytest.approx(0.87 + 5 * (2.0 - 0.87), rel=1e-9)
    eqs = cart(sb.Signal("v", "x_dot", sample=0.1), force="1e-300*v")
    for n in range(1, 40, 2):
        speed = 1.0 / (n * 0.37)
        wall = sb.Event(f"x - {speed * n * 0.1!r}", 0, {"x_dot": "-x_dot"})
        run = sb.simulate(eqs, n * 0.1 + 0.05, {"x_dot": speed}, events=wall)
        assert [event.t for event in run.events] == pytest.approx([n * 0.1], rel=1e-12)


def test_events_between_samples_are_where_they_are_without_a_watch() -> None:
    eqs = cart(sb.Signal("brake", "-x", sample=0.1), force="20*brake", speed=1.0)
    run = sb.simulate(eqs, 3.0, events=sb.Event("x_dot", action="record"), rtol=1e-11)
    plain = sb.simulate(eqs, 3.0, rtol=1e-11)
    assert len(run.events) >= 3
    for event in run.events:
        assert plain.at(event.t)["x_dot"] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_array_equal(run["x"], plain["x"])


def test_time_may_jump_beside_a_sample() -> None:
    eqs = cart(sb.Signal("n", "if(t < 0.5, 1, 2)", sample=0.25), force="n + if(t < 0.5, 0, 4)", speed=0.0)
    run = sb.simulate(eqs, 1.0)
    assert run["x_dot"][-1] == pytest.approx(0.5 * 1 + 0.5 * 6, rel=1e-12)
    assert run.statistics.accepted < 60


@pytest.mark.parametrize(("step", "jump"), [(0.29, 0.87), (0.35, 1.05), (0.1, 0.3), (0.25, 0.75)])
def test_a_sample_is_behind_what_jumps_at_its_instant(step: float, jump: float) -> None:
    """Products such as 3*0.29 may be less than the time of the jump by rounding."""
    joint = sb.Prismatic(
        "slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(applied="n")
    )
    held = [sb.Signal("n", "F", sample=step), sb.Signal("log", "F + count", sample=step),
            sb.Signal("count", f"floor(t/{step})", sample=step)]  # fmt: skip
    eqs = sb.form_equations(sb.Model("cart", [joint, *held], inputs=["F"]))
    early = np.linspace(0.0, jump, 50)
    laws = [f"if(t < {jump}, 0, 1)", ((0, jump, jump, 9), (0, 0, 1, 1)),
            (np.append(early, [jump, 9]), np.append(0 * early, [1, 1]))]  # fmt: skip
    for law in laws:
        record = sb.simulate(eqs, 2.0, inputs={"F": law}).held_values
        assert record is not None
        np.testing.assert_array_equal(
            record.values[:, :5], [[0, 0, 0, 1, 1], [0, 0, 1, 3, 4], [0, 1, 2, 3, 4]]
        )


def test_inputs_of_every_kind_drive_beside_samples() -> None:
    joint = sb.Prismatic(
        "slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(applied="n")
    )
    model = sb.Model("cart", [joint, sb.Signal("n", "n + F", sample=0.1)], inputs=["F"])
    eqs = sb.form_equations(model)
    t = np.linspace(0.0, 1.0, 101)
    laws = ["sin(t)", lambda t, q, u: float(np.sin(t)), sb.Table(t, np.sin(t), "cubic")]
    formula, function, table = (sb.simulate(eqs, 1.0, inputs={"F": law}, rtol=1e-10) for law in laws)
    assert function["x"][-1] == pytest.approx(formula["x"][-1], rel=1e-12)
    assert table["x"][-1] == pytest.approx(formula["x"][-1], rel=1e-7)
    np.testing.assert_allclose(function["n"], formula["n"], rtol=1e-12)
