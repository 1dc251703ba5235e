"""Prescribed rates that jump strike what hangs on them; prescribed positions cannot jump."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.errors import UsageError
from tests.tiers import cases

LENGTH, MASS, INERTIA = 0.7, 1.5, 0.1
GROUND = {"eye": sb.Frame(at=(0, 0, LENGTH))}
WAYS: list[dict[str, object]] = [
    {}, {"integrator": sb.Explicit(order=5)}, {"integrator": sb.Stiff()}, {"integrator": sb.FixedStep(1e-3)},
    {"constraints": sb.GGL()}, {"constraints": sb.Partition()}, {"constraints": sb.Baumgarte()},
]  # fmt: skip


def cart_with_pendulum(motion: str, as_constraint: bool) -> sb.EquationSet:
    """A cart on x, and below it a bar whose centre hangs LENGTH below the pin."""
    cart = sb.Body("Cart", mass=2)
    bar = sb.Body("Bar", mass=MASS, inertia=(INERTIA,) * 3, frames=GROUND)
    parts = [
        cart, bar,
        sb.Prismatic("slide", "ground", cart, axis="x", coordinate="x", motion=motion, as_constraint=as_constraint),
        sb.Revolute("pin", cart, "Bar.eye", axis="y", coordinate="th"),
    ]  # fmt: skip
    return sb.form_equations(sb.Model("struck", parts, gravity=(0, 0, -9.81)))


def jump(run: sb.Trajectory, name: str, t: float) -> tuple[float, float]:
    """The values of the two samples at a jump."""
    place = int(np.flatnonzero(np.abs(run.t - t) < 1e-13)[0])
    return float(run[name][place]), float(run[name][place + 1])


@pytest.mark.parametrize("way", WAYS, ids=[str(list(way.values())[:1]) for way in WAYS])
@pytest.mark.parametrize("as_constraint", [False, True])
def test_a_cart_that_starts_with_a_jerk_strikes_its_pendulum(
    way: dict[str, object], as_constraint: bool
) -> None:
    """The moment of momentum about the pin does not change: (J + m l^2) dw + m l cos(th) dv = 0.

    The centre lies at x - l sin(th), so its velocity is v - l cos(th) w: the sign of l is that of -z here.
    """
    eqs = cart_with_pendulum("if(t < 1, 0, 1.5*(t - 1))", as_constraint)
    run = sb.simulate(eqs, 1.5, {"th": 0.4}, **way)  # type: ignore[arg-type]
    assert run.success
    angle, speed = jump(run, "th", 1.0), jump(run, "th_dot", 1.0)
    # what the frame eye says: the centre is at -LENGTH along the bar's z
    exact = MASS * LENGTH * np.cos(angle[0]) * 1.5 / (INERTIA + MASS * LENGTH**2)
    assert angle[0] == angle[1]
    assert speed[1] - speed[0] == pytest.approx(exact, rel=1e-12)
    np.testing.assert_allclose(jump(run, "x_dot", 1.0), [0.0, 1.5], rtol=0, atol=1e-9)
    # energy balance: what the motion puts in at the jump counts as work
    assert run.energy_drift < 1e-5
    change = jump(run, "energy", 1.0)
    work = jump(run, "work", 1.0)
    assert work[1] - work[0] == pytest.approx(change[1] - change[0], rel=1e-6)
    assert any("prescribed rates jump" in note for note in run.notes)


BACKWARD: list[dict[str, object]] = [
    {"integrator": sb.Explicit()}, {"integrator": sb.FixedStep(1e-3)}, {"integrator": sb.Stiff()},
    {"integrator": sb.GeneralizedAlpha()}, {"constraints": sb.GGL()},
]  # fmt: skip


@pytest.mark.parametrize("way", BACKWARD, ids=[str(list(way.values())[0]) for way in BACKWARD])
@pytest.mark.parametrize("as_constraint", cases([False, True], fast=[True]))
def test_a_backward_motion_passes_a_jump_at_its_very_start(
    way: dict[str, object], as_constraint: bool
) -> None:
    """It is that from 0.1 us later on: its rate of 1 rad/s, and 4 rad/s2, change less than 1e-6 by that."""
    eqs = cart_with_pendulum("if(t < 1, 0, 1.5*(t - 1))", as_constraint)
    first = {"th": 0.4, "th_dot": 1.0}
    at, later = (sb.simulate(eqs, (t, 0.5), first, **way) for t in (1.0, 1.0000001))  # type: ignore[arg-type]
    exact = MASS * LENGTH * np.cos(0.4) * 1.5 / (INERTIA + MASS * LENGTH**2)
    assert at["th_dot"][:2] == pytest.approx([1.0, 1.0 - exact], abs=1e-9)
    np.testing.assert_allclose(at["x_dot"][:2], [1.5, 0.0], rtol=0, atol=1e-9)
    for name in ("th", "th_dot"):
        assert at[name][-1] == pytest.approx(later[name][-1], abs=1e-6)
    for run in (at, later):
        assert run.success
        assert any("t = 1 s prescribed rates jump" in note for note in run.notes)


@pytest.mark.parametrize("as_constraint", [False, True])
def test_samples_at_a_jump_are_those_behind_it(as_constraint: bool) -> None:
    eqs = cart_with_pendulum("interp1(t, 0, 0, 1, 0, 2, 1.5)", as_constraint)
    times = np.linspace(0.0, 1.5, 4)
    run = sb.simulate(eqs, 1.5, {"th": 0.4}, times=times)
    every = sb.simulate(eqs, 1.5, {"th": 0.4})
    np.testing.assert_array_equal(run.t, times)
    assert run["th_dot"][2] == pytest.approx(jump(every, "th_dot", 1.0)[1], rel=1e-6)
    swept = sb.sweep(eqs, 1.5, initial={"th": [0.4, 0.5]}, times=times)
    np.testing.assert_allclose(swept["th_dot"][0], run["th_dot"], rtol=0, atol=1e-6)


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("motion", ["if(t < 1, 0, 0.1)", "if(t < 1, 0, t)", "floor(t)", "0.1*sign(t - 0.5)"])
def test_positions_that_jump_are_refused_with_the_cure(motion: str, as_constraint: bool) -> None:
    eqs = cart_with_pendulum(motion, as_constraint)
    with pytest.raises(UsageError, match="the prescribed position jumps at t =") as caught:
        sb.simulate(eqs, 1.5)
    (problem,) = caught.value.problems
    assert problem.code == "simulation.torn_motion"
    assert problem.where == "motion x"
    assert "smoothstep" in problem.fix


def test_smooth_motions_and_whole_turns_strike_nothing() -> None:
    for motion in ("smoothstep(t, 0.5, 1)", "sin(t)", "if(t < 1, t^2, 2*t - 1)"):
        run = sb.simulate(cart_with_pendulum(motion, False), 1.5, {"th": 0.4})
        assert run.success
        assert not any("jump" in note for note in run.notes)
    wheel = sb.Body("Wheel", mass=1, inertia=(1, 1, 1))
    bar = sb.Body("Bar", mass=MASS, inertia=(INERTIA,) * 3, frames=GROUND)
    ends = []
    for motion in ("3*t", "mod(3*t, 2*pi)"):
        parts = [
            wheel, bar, sb.Revolute("axle", "ground", wheel, axis="y", coordinate="a", motion=motion),
            sb.Revolute("pin", wheel, "Bar.eye", axis="y", coordinate="th"),
        ]  # fmt: skip
        run = sb.simulate(sb.form_equations(sb.Model("w", parts, gravity=(0, 0, -9.81))), 5.0, {"th": 0.4})
        assert run.success
        assert not any("jump" in note for note in run.notes)
        ends.append(run["th"][-1])
    assert ends[1] == pytest.approx(ends[0], abs=1e-6)


def test_friction_of_struck_reactions_is_refused_or_noted() -> None:
    eqs = struck_rider(friction=sb.Friction(0.3))
    with pytest.raises(UsageError, match="prescribed rates jump at t = 0.4 s"):
        sb.simulate(eqs, 2.0)
    run = sb.simulate(struck_rider(friction=sb.Friction(0.3, v0=0.01)), 2.0)
    assert any("friction of ridden is neglected where prescribed rates jump" in note for note in run.notes)


@pytest.mark.parametrize(("rate", "then"), [(2.0, 0.0), (0.25, 0.75)])
def test_a_jump_pulls_at_a_taut_rope_and_lets_it_go_slack(rate: float, then: float) -> None:
    """A rider behind a carrier, on a rope of 1 m that is taut: it is pulled along at once, or coasts."""
    parts = [
        sb.Prismatic("carried", "ground", sb.Body("Carrier", mass=1), axis="x", coordinate="p",
                     motion=f"if(t < 0.4, t, 0.4 + {rate}*(t - 0.4))"),
        sb.Prismatic("ridden", "Carrier", sb.Body("Rider", mass=3), axis="x", coordinate="r"),
        sb.Distance("rope", "Carrier", "Rider", 1.0, rope=True),
    ]  # fmt: skip
    eqs = sb.form_equations(sb.Model("struck", parts))
    run = sb.simulate(eqs, 0.8, {"r": -1.0, "r_dot": 0.0})
    assert run.success
    assert run["r_dot"][-1] == pytest.approx(then, abs=1e-12)
    assert run["r"][-1] == pytest.approx(-1.0 + 0.4 * then, abs=1e-9)
    assert run.energy_drift < 1e-9


def cart_on_two_rows(behind: str) -> sb.EquationSet:
    """A cart whose constraint is another from t = 1 on; at the start the two disagree."""
    slide = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    row = sb.Constraint("phases", f"if(t < 1, x - 0.1*t, {behind})")
    return sb.form_equations(sb.Model("phases", [slide, row]))


def test_a_constraint_that_changes_is_judged_where_the_motion_comes_to_it() -> None:
    run = sb.simulate(cart_on_two_rows("x^2 - 0.01"), 2.0, times=np.linspace(0, 2, 21))
    assert run.success
    np.testing.assert_allclose(run["x"], 0.1 * np.minimum(run.t, 1), rtol=0, atol=1e-9)
    assert abs(run["x_dot"][-1]) < 1e-9
    with pytest.raises(UsageError, match="position jumps at t = 1"):
        sb.simulate(cart_on_two_rows("x^2 - 0.02"), 2.0)


def test_a_constraint_that_changes_nothing_at_the_start_is_judged_there_too() -> None:
    parts: list[sb.Element] = [
        sb.Prismatic(f"slide {name}", "ground", sb.Body(name.upper(), mass=1), axis="x", coordinate=name)
        for name in "xy"
    ]
    eqs = sb.form_equations(sb.Model("pair", [*parts, sb.Constraint("row", "if(t < 1, x - y, x*y)")]))
    assert sb.simulate(eqs, 2.0).success  # at rest at 0, where both hold
    with pytest.raises(UsageError, match="position jumps at t = 1"):
        sb.simulate(eqs, 2.0, {"x_dot": 1.0})


def struck_rider(**more: Any) -> sb.EquationSet:
    """A rider on a carrier whose rate jumps from 1 to 2 m/s at 0.4 s."""
    law = "if(t < 0.4, t, 2*t - 0.4)"
    parts = [
        sb.Prismatic("carried", "ground", sb.Body("Carrier", mass=1), axis="x", coordinate="p", motion=law),
        sb.Prismatic("ridden", "Carrier", sb.Body("Rider", mass=1), axis="x", coordinate="r", friction=more.get("friction")),
    ]  # fmt: skip
    ropes = [sb.Distance("rope", "Carrier", "Rider", 3.0, rope=True)] if "rope" in more else []
    return sb.form_equations(sb.Model("struck", [*parts, *ropes]))


@pytest.mark.parametrize("hung", ["joint that sticks", "rope"])
@pytest.mark.parametrize("dt", cases([0.05, 0.03, 0.4], fast=[0.4]))
def test_rates_jump_under_friction_and_beside_ropes(hung: str, dt: float) -> None:
    """Friction of 0.5 N is finite: the rider goes on at 1 m/s; a slack rope pulls when it is 3 m long, at 4.4 s."""
    friction = sb.Friction(force=0.5, static=0.6)
    eqs = struck_rider(friction=friction) if hung == "joint that sticks" else struck_rider(rope=True)
    stepper = sb.Stepper(eqs, dt, initial={"r": 1.0, "r_dot": 0.0})
    lanes = sb.LaneStepper(eqs, dt, 2, initial={"r": 1.0, "r_dot": 0.0})
    run = sb.simulate(eqs, 6.0, initial={"r": 1.0, "r_dot": 0.0}, times=np.arange(0, 6, dt))
    assert run.success

    def place(t: float) -> float:
        s = max(t - 0.4, 0.0)
        if hung == "rope":
            return max(1.0 - s, -3.0)
        s = min(s, 2.0)
        return 1.0 - s + s**2 / 4

    for k in range(1, round(5.9 / dt)):
        stepper.step()
        lanes.step()
        for value in (stepper.q[0], *lanes.q[:, 0], run["r"][k]):
            assert value == pytest.approx(place(k * dt), abs=1e-7)


def test_steps_refuse_friction_of_struck_reactions() -> None:
    eqs = struck_rider(friction=sb.Friction(0.05))
    stepper = sb.Stepper(eqs, 0.05, initial={"r": 1.0, "r_dot": 0.0})
    with pytest.raises(UsageError) as error:
        for _ in range(40):
            stepper.step()
    assert error.value.problems[0].code == "simulation.struck_friction"
    assert float(stepper.t) < 0.4 <= float(stepper.t) + 0.05 + 1e-9
    with pytest.raises(UsageError):  # nothing has moved, nor counts as a step
        stepper.step()


@pytest.mark.parametrize("way", WAYS, ids=[str(list(way.values())[:1]) for way in WAYS])
@pytest.mark.parametrize("end", [0.4, 0.8])
def test_of_times_the_sample_at_a_jump_is_behind_the_action_there(way: dict[str, object], end: float) -> None:
    """The carrier becomes faster by 1 m/s, by which the rider falls behind; then an action turns that into 0.2."""
    turned = sb.Event("r_dot + 0.5", action={"r_dot": "r_dot + 1.2"})
    times = np.array([0.0, 0.4, end] if end > 0.4 else [0.0, 0.4])
    run = sb.simulate(
        struck_rider(), end, {"r": 1.0, "r_dot": 0.0}, times=times, events=turned, **way  # type: ignore[arg-type]
    )  # fmt: skip
    np.testing.assert_array_equal(run.t, times)
    np.testing.assert_allclose(run["r_dot"], [0.0, *[0.2] * (times.size - 1)], rtol=0, atol=1e-9)
    assert run["r"][-1] == pytest.approx(1.0 + 0.2 * (end - 0.4), abs=1e-9)
    assert run["energy"][1] - run["energy"][0] == pytest.approx(run["work"][1], rel=1e-9)
