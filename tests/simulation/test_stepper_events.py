"""Events at the ends of steps: what a `Stepper` sees is what `simulate` sees, wherever its steps end."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.simulation.loops import example, pushed_mass
from tests.simulation.test_random_events import END, oscillator, random_events

ACTIONS: list[Any] = ["record", "stop", {"x_dot": "-x_dot"}, {"x_dot": "x_dot/2"}]
Seen = list[tuple[str, float]]


def shifted(t: float, ulps: int) -> float:
    """Return the number so many representable ones behind another."""
    for _ in range(abs(ulps)):
        t = float(np.nextafter(t, np.inf if ulps > 0 else -np.inf))
    return t


@cache
def free_mass() -> sb.EquationSet:
    return pushed_mass("0", 0.0, 0.0)


def passing(zero: float, way: int, event: sb.Event, **options: Any) -> sb.Stepper:
    """Return steps of a mass that passes x = 0 at a time, one way or the other."""
    start = {"x": -way * zero, "x_dot": float(way)}
    return sb.Stepper(free_mass(), 0.1, initial=start, events=event, **options)


def take(stepper: sb.Stepper, steps: int) -> list[float]:
    return [event.t for _ in range(steps) for event in stepper.step().events]


@pytest.mark.parametrize("action", ACTIONS, ids=["record", "stop", "reflect", "slow"])
@pytest.mark.parametrize("ulps", [-3, -1, 0, 1, 3])
def test_a_zero_beside_the_end_of_a_step_is_one_event(ulps: int, action: Any) -> None:
    for steps in (1, 3):
        zero = shifted(0.1 * steps, ulps)
        for way, direction in ((1, 0), (1, 1), (-1, 0), (-1, -1)):
            seen = take(passing(zero, way, sb.Event("x", direction, action)), steps + 3)
            assert seen == pytest.approx([zero], abs=1e-14)
        assert not take(passing(zero, 1, sb.Event("x", -1)), steps + 3)


@pytest.mark.exhaustive
@pytest.mark.parametrize("integrator", [sb.FixedStep(0.013), sb.GeneralizedAlpha(), sb.Stiff()], ids=str)
@pytest.mark.parametrize("action", ACTIONS, ids=["record", "stop", "reflect", "slow"])
def test_every_method_has_one_event_there(integrator: Any, action: Any) -> None:
    for steps in (1, 2, 7):
        for ulps in (-3, -1, 0, 1, 3):
            zero = shifted(0.1 * steps, ulps)
            for way, direction in ((1, 0), (-1, -1)):
                stepper = passing(zero, way, sb.Event("x", direction, action), integrator=integrator)
                assert take(stepper, steps + 3) == pytest.approx([zero], abs=1e-12)


def compare_with_simulate(seed: int) -> None:
    """Compare over steps of random lengths, and over steps that end beside every event."""
    random = np.random.default_rng(seed)
    events, x = random_events(random), float(random.uniform(-1.0, 1.0))
    run = sb.simulate(oscillator(), END, {"x": x}, events=events, rtol=1e-10)
    if run.status is not sb.Status.SUCCESS:  # chattering: within an instant of the step, or of the motion
        return
    beside = [shifted(event.t, int(random.integers(-3, 4))) for event in run.events]
    for ends in (np.sort(random.uniform(0.0, END, 30)).tolist(), beside):
        stepper = sb.Stepper(oscillator(), 0.1, initial={"x": x}, events=events, rtol=1e-10)
        seen: Seen = []
        for end in (*ends, END):
            if end > stepper.t:
                seen += [(event.name, event.t) for event in stepper.step(end - stepper.t).events]
        assert [name for name, _ in seen] == [event.name for event in run.events]
        assert [t for _, t in seen] == pytest.approx([event.t for event in run.events], abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_events_do_not_depend_on_where_steps_end(seed: int) -> None:
    compare_with_simulate(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(6, 246, 40))
def test_many_random_events_do_not_depend_on_where_steps_end(first: int) -> None:
    for seed in range(first, first + 40):
        compare_with_simulate(seed)


@pytest.mark.parametrize("integrator", [None, sb.Stiff()], ids=str)
def test_restored_steppers_see_what_lies_just_ahead(integrator: Any) -> None:
    def make() -> sb.Stepper:
        return passing(shifted(0.1, 1), 1, sb.Event("x", 1), integrator=integrator)

    stepper = make()
    while not stepper.events and stepper.t < 0.05:
        stepper.step()
    saved, seen = stepper.save(), list(stepper.events)
    others = [stepper.copy(), make().restore(saved), stepper]
    later = [[*seen, *other.step().events] for other in others]
    assert [len(some) for some in later] == [1, 1, 1]
    assert len({other.save() for other in others}) == 1
    assert not take(stepper, 3)
    assert len(take(stepper.reset(), 3)) == 1


def test_other_parameters_hide_no_event() -> None:
    eqs = sb.form_equations(
        sb.Model("mass", [sb.Prismatic("j", "ground", sb.Body("B", mass="m"), coordinate="x")],
                 parameters={"m": 1.0})
    )  # fmt: skip
    for ulps in (0, 1, 3):
        start = {"x": -shifted(0.1, ulps), "x_dot": 1.0}
        stepper = sb.Stepper(eqs, 0.1, initial=start, events=sb.Event("x"))
        seen = take(stepper, 1) + take(stepper.set(m=2.0), 2)
        assert seen == pytest.approx([0.1])


def test_inputs_that_jump_through_zero_are_events() -> None:
    """With laws in time, as `simulate` sees them; and with values that steps give."""
    event = sb.Event("F - 1", name="strong")
    eqs = example("cart_pole")
    law = "if(t < 0.3, 0, 2)"
    run = sb.simulate(eqs, 0.5, inputs={"F": law}, events=event)
    assert take(sb.Stepper(eqs, 0.1, inputs={"F": law}, events=event), 5) == pytest.approx(
        [event.t for event in run.events]
    )
    stepper = sb.Stepper(eqs, 0.1, events=event)
    seen = [[event.t for event in stepper.step(F=force).events] for force in (0.0, 2.0, 3.0, -1.0, -1.0)]
    assert seen == [[], [0.1], [], [pytest.approx(0.3)], []]


def test_a_motion_of_its_own_watches_what_stopped_the_one_before() -> None:
    """x = cos(2 t) passes zero at pi/4, and again within the next step."""
    eqs = pushed_mass("-4*x", 1.0, 0.0)
    stepper = sb.Stepper(eqs, 2.0, events=sb.Event("x", 0, "stop"), integrator=sb.Stiff())
    assert take(stepper, 3) == pytest.approx(np.pi / 4 * np.array([1.0, 3.0, 5.0]), abs=1e-5)


@pytest.mark.parametrize("action", ACTIONS[:3], ids=["record", "stop", "reflect"])
def test_a_zero_beside_a_sample_and_the_end_of_a_step_is_one_event(action: Any) -> None:
    held = sb.Signal("held", value="cos(3*t)", sample=0.1)
    slide = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive("0*held"))
    eqs = sb.form_equations(sb.Model("held", [slide, held]))
    for steps, ulps in ((1, -2), (2, 0), (2, 1), (3, 1)):
        zero = shifted(0.1 * steps, ulps)
        stepper = sb.Stepper(eqs, 0.1, initial={"x": -zero, "x_dot": 1.0}, events=sb.Event("x", 0, action))
        assert take(stepper, steps + 2) == pytest.approx([zero], abs=1e-12)


@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_a_zero_just_behind_a_sample_at_the_end_of_a_step_is_one_event(direction: int) -> None:
    """Rounding decides whether w = 0.3 t has passed 0.3 t_k at the sample t_k: some pass it behind."""
    held = sb.Signal("held", value="cos(3*t)", sample=0.1)
    slide = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="w", force=sb.Drive("0*held"))
    eqs = sb.form_equations(sb.Model("held", [slide, held]))
    behind = 0
    for k in range(1, 10):
        event = sb.Event(f"w - {0.3 * (0.1 * k)}", direction, "record")
        stepper = sb.Stepper(eqs, 0.05, initial={"w": 0, "w_dot": 0.3}, events=event)
        take(stepper, 2 * k)
        behind += stepper["w"] < 0.3 * (0.1 * k)
        stepper.reset()
        expected = [0.1 * k] if direction >= 0 else []
        assert take(stepper, 2 * k + 2) == pytest.approx(expected, abs=1e-9)
    assert behind > 0


METHODS: list[dict[str, Any]] = [
    {}, {"integrator": sb.FixedStep(0.01)}, {"integrator": sb.Stiff()}, {"integrator": sb.GeneralizedAlpha()},
    {"constraints": sb.Partition()},
]  # fmt: skip


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("dt", [0.4, 0.1, 0.02])
def test_two_actions_within_rounding_of_the_end_of_a_step_both_happen(
    method: dict[str, Any], dt: float
) -> None:
    """x = t, so both values are zero at 0.4, where a step ends; the speed is 1, then 1 + 1 and 1 + 1 + 2."""
    both = [
        sb.Event("t - 0.4", action={"x_dot": "x_dot + 1"}, name="clock"),
        sb.Event("x - 0.4", action={"x_dot": "x_dot + 2"}, name="place"),
    ]
    stepper = sb.Stepper(free_mass(), dt, initial={"x": 0.0, "x_dot": 1.0}, events=both, **method)
    names = [event.name for _ in range(round(0.8 / dt)) for event in stepper.step().events]
    assert sorted(names) == ["clock", "place"]
    assert stepper["x"] == pytest.approx(0.4 + 0.4 * 4.0, abs=1e-9)
