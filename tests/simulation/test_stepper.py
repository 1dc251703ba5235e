"""Motions step by step: the same as `simulate`, whatever the way, and to the bit after `restore`."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.codegen import kernel_call
from symbody.simulation.stepper import compiled_steps
from tests.simulation.loops import example, pushed_mass
from tests.simulation.test_friction import dragged

UPRIGHT = {"theta": 0.1, "x": 0.0}


def cart_pole() -> sb.EquationSet:
    return example("cart_pole")


def balancing(**options: Any) -> sb.Stepper:
    return sb.Stepper(cart_pole(), 0.01, initial=UPRIGHT, **options)


def forces(steps: int) -> list[float]:
    return np.random.default_rng(5).normal(0.0, 3.0, steps).tolist()


def difference(stepper: sb.Stepper, run: sb.Trajectory) -> float:
    last = np.concatenate([run.u[:, -1], run.q[:, -1]])
    return float(np.abs(np.concatenate([stepper.u, stepper.q]) - last).max())


def test_steps_with_changing_inputs_are_the_motions_of_simulate() -> None:
    stepper, state = balancing(), {**UPRIGHT, "x_dot": 0.0, "theta_dot": 0.0}
    for k, force in enumerate(forces(20)):
        stepper.step(F=force)
        span = (0.01 * k, 0.01 * (k + 1))
        run = sb.simulate(cart_pole(), span, state, inputs={"F": force})
        state = {name: float(run[name][-1]) for name in cart_pole().state_names}
    assert stepper.t == pytest.approx(0.2, rel=1e-15)
    assert difference(stepper, run) < 1e-8
    assert abs(stepper["theta"] - 0.1) > 0.01


def test_inputs_keep_their_values() -> None:
    kept, given = balancing(), balancing()
    kept.step(F=2.0)
    for _ in range(10):
        kept.step()
    for _ in range(11):
        given.step(F=2.0)
    assert kept.save() == given.save()
    assert kept.inputs == {"F": 2.0}


@pytest.mark.parametrize(
    ("integrator", "constraints"),
    [
        (None, None),
        (sb.Explicit(order=5), sb.Projection(1e-11)),
        (sb.Explicit(max_step=0.004), sb.Baumgarte()),
        (sb.FixedStep(1e-3), None),
        (sb.FixedStep(3e-4, "semi-implicit"), None),
        (sb.Stiff(), None),
        (None, sb.GGL()),
        (None, sb.Partition()),
    ],
    ids=str,
)
def test_every_method_takes_steps(integrator: Any, constraints: Any) -> None:
    options: dict[str, Any] = {"integrator": integrator, "constraints": constraints}
    stepper = sb.Stepper(example("slider_crank"), 0.012, inputs={"F": 0}, **options)
    for _ in range(5):
        stepper.step()
    run = sb.simulate(example("slider_crank"), 0.06, inputs={"F": 0}, **options)
    assert difference(stepper, run) < 2e-6
    assert np.abs(stepper["constraints"]).max() < 1e-7
    slow = isinstance(integrator, sb.Stiff) or isinstance(constraints, sb.GGL | sb.Partition)
    assert any("separate simulation" in note for note in stepper.notes) is slow


def test_loops_stay_closed() -> None:
    stepper = sb.Stepper(example("slider_crank"), 1e-3, inputs=["F"])
    for force in forces(2000):
        stepper.step(F=force)
    assert np.abs(stepper["constraints"]).max() < 1e-9
    assert np.abs(stepper["velocity_constraints"]).max() < 1e-9


@pytest.mark.parametrize("law", ["sin(5*t)", "if(t < 0.333, 1, -4)", "2*x_dot - t"])
def test_laws_in_time_and_states(law: str) -> None:
    stepper = balancing(inputs={"F": law})
    for _ in range(50):
        stepper.step()
    assert difference(stepper, sb.simulate(cart_pole(), 0.5, UPRIGHT, inputs={"F": law})) < 1e-7


def test_time_is_looked_at_far_ahead() -> None:
    """Pulses that lie beyond the first look ahead are not passed over."""
    law = "if(t > 12.3 and t < 12.301, 1000, 0)"
    stepper = sb.Stepper(pushed_mass(law, 0.0, 0.0), 0.01)
    for _ in range(1300):
        stepper.step()
    assert stepper["x_dot"] == pytest.approx(1.0, abs=1e-6)


def test_laws_in_python_and_tables() -> None:
    stepper = balancing(inputs={"F": lambda t, q, u: math.sin(5 * t) - u[0]})
    for _ in range(30):
        stepper.step()
    run = sb.simulate(cart_pole(), 0.3, UPRIGHT, inputs={"F": "sin(5*t) - x_dot"})
    assert difference(stepper, run) < 1e-8
    t = np.linspace(0.0, 0.2, 200)
    stepper = balancing(inputs={"F": sb.Table(t, np.sin(5 * t), outside="error")})
    for _ in range(19):
        stepper.step()
    with pytest.raises(sb.UsageError, match=r"simulation\.table_range"):
        for _ in range(3):
            stepper.step()


def test_a_law_that_fails_leaves_the_stepper_usable() -> None:
    def law(t: float, q: Any, u: Any) -> float:
        if t > 0.035:
            raise ValueError("no more")
        return 1.0

    stepper = balancing(inputs={"F": law})
    with pytest.raises(sb.SimulationError, match="no more"):
        for _ in range(10):
            stepper.step()
    assert stepper.t <= 0.035
    assert np.isfinite(stepper.q).all()
    assert stepper.reset().step().t == 0.01


@pytest.mark.parametrize("way", ["compiled", "law", "events", "separate"])
def test_restored_steppers_go_on_to_the_bit(way: str) -> None:
    options: dict[str, Any] = {
        "compiled": {},
        "law": {"inputs": {"F": "3*sin(9*t)"}},
        "events": {"events": sb.Event("theta - 0.12", name="far")},
        "separate": {"integrator": sb.Stiff()},
    }[way]
    count, stepper = 4 if way == "separate" else 40, balancing(**options)
    for place in stepper.inputs or ("F",):
        if way != "law":
            stepper.step(**{place: 1.5})
    for _ in range(count):
        stepper.step()
    saved = stepper.save()
    ends = []
    for other in (stepper, stepper.copy(), balancing(**options)):
        assert other.restore(saved) is other
        ends.append([other.step().save() for _ in range(count)])
    assert ends[0] == ends[1] == ends[2]
    assert len(set(ends[0])) == count


def test_values_of_parameters_are_saved() -> None:
    stepper = balancing()
    stepper.set(mp=0.3, l="0.2 + 0.4").step(F=1.0)
    other = balancing().restore(stepper.save())
    assert other.parameters == stepper.parameters
    assert other.step().save() == stepper.step().save()


def test_what_was_not_saved_here_is_refused() -> None:
    stepper = balancing()
    saved = stepper.step(F=1.0).save()
    for bad in (b"", saved[:-1], saved[:60] + b"x" + saved[61:], "text", None):
        with pytest.raises(sb.UsageError, match=r"stepper\.not_saved|restore"):
            stepper.restore(bad)  # type: ignore[arg-type]
    others = [
        sb.Stepper(example("slider_crank"), 0.01),
        balancing(rtol=1e-6),
        balancing(integrator=sb.FixedStep(1e-3)),
        balancing(inputs={"F": 1}),
    ]
    for other in others:
        with pytest.raises(sb.UsageError, match=r"stepper\.other_kind"):
            other.restore(saved)
    assert stepper.save() == saved


def test_a_copy_goes_its_own_way() -> None:
    stepper = balancing()
    stepper.step(F=1.0)
    other = stepper.copy()
    before = stepper.save()
    other.step(F=-5.0)
    assert stepper.save() == before
    stepper.step(F=-5.0)
    assert stepper.save() == other.save()


def test_reset_forgets_everything_but_parameters() -> None:
    fresh, used = balancing(), balancing()
    for force in forces(30):
        used.step(F=force)
    assert used.reset().save() == fresh.save()
    used.set(mp=0.2).step(F=1.0)
    used.reset({"x": 1.0}, theta="10 deg")
    assert (used.t, used["x"], used["theta"]) == (0.0, 1.0, pytest.approx(math.radians(10)))
    assert used.parameters == {"mp": 0.2}
    with pytest.raises(sb.UsageError, match=r"stepper\.input_without_value"):
        used.step()


def test_changed_parameters_count_from_then_on() -> None:
    stepper = balancing()
    stepper.step(F=1.0).set(mp=0.4, F=2.0)
    start = {name: stepper[name] for name in cart_pole().state_names}
    for _ in range(10):
        stepper.step()
    run = sb.simulate(cart_pole(), (0.01, 0.11), start, parameters={"mp": 0.4}, inputs={"F": 2.0})
    assert difference(stepper, run) < 1e-8


def test_changed_lengths_close_loops_again() -> None:
    stepper = sb.Stepper(example("slider_crank"), 1e-3, inputs=[])
    stepper.step()
    theta = stepper["theta"]
    stepper.set(L1=0.41)
    assert np.abs(stepper["constraints"]).max() < 1e-9
    assert stepper["theta"] == pytest.approx(theta, abs=0.1)
    before = stepper.save()
    for impossible in ({"m1": -1}, {"L1": 0.41, "G": "nothing"}):
        with pytest.raises(sb.SymbodyError):
            stepper.set(**impossible)
    assert stepper.save() == before
    assert np.abs(stepper.step()["constraints"]).max() < 1e-9


BALL = {"Y": 1.0, "Y_dot": 0.0}


def test_events_are_those_of_simulate() -> None:
    events = [
        sb.Event("Y", -1, {"Y_dot": "-0.8*Y_dot"}, name="bounce"),
        sb.Event("Y_dot", -1, name="top"),
    ]
    stepper = sb.Stepper(example("projectile"), 0.03, initial=BALL, events=events)
    seen = [event for _ in range(50) for event in stepper.step().events]
    run = sb.simulate(example("projectile"), 1.5, BALL, events=events)
    assert [event.name for event in seen] == [event.name for event in run.events]
    assert [event.t for event in seen] == pytest.approx([event.t for event in run.events], abs=1e-9)
    assert difference(stepper, run) < 1e-8


def test_a_stop_ends_the_step_early() -> None:
    stepper = sb.Stepper(example("projectile"), 0.03, initial=BALL, events=sb.Event("Y", -1, "stop"))
    while stepper.step().status is sb.Status.SUCCESS:
        assert stepper.t < 1.0
    assert stepper.status is sb.Status.STOPPED
    assert stepper.events[-1].t == stepper.t
    assert stepper["Y"] == pytest.approx(0.0, abs=1e-9)
    stopped = stepper.t
    assert stepper.step().status is sb.Status.SUCCESS
    assert stepper.t == pytest.approx(stopped + 0.03)
    assert not stepper.events


@pytest.mark.parametrize("integrator", [None, sb.Stiff()], ids=str)
def test_a_stop_beside_a_joint_that_sticks(integrator: Any) -> None:
    eqs, stop = sb.form_equations(dragged()), sb.Event("x - 0.05", 1, "stop")
    stepper = sb.Stepper(eqs, 0.5, initial={"x": 0.0}, integrator=integrator, events=stop)
    while stepper.step().status is sb.Status.SUCCESS:
        assert stepper.t < 5.0
    stopped = stepper.t
    assert stepper["x"] == pytest.approx(0.05)
    assert stepper.step().t == pytest.approx(stopped + 0.5)


def test_views_are_renewed_and_cannot_be_written() -> None:
    stepper = balancing()
    q, u = stepper.q, stepper.u
    stepper.step(F=1.0).set(mp=0.2).step().reset().step(F=2.0)
    assert q is stepper.q and u is stepper.u
    assert q.tolist() == [stepper["x"], stepper["theta"]]
    with pytest.raises(ValueError, match="read-only"):
        q[0] = 1.0


def test_outputs_and_states_are_those_at_present() -> None:
    stepper = balancing()
    stepper.step(F=1.5)
    state = stepper.state()
    assert dict(state.q) == pytest.approx({"x": stepper["x"], "theta": stepper["theta"]})
    assert stepper["x_ddot"] == pytest.approx(state.udot["x_ddot"])
    assert state.t == stepper.t == stepper["t"]
    assert stepper["work"] == pytest.approx(stepper["energy"] - balancing()["energy"], abs=1e-9)


def test_other_durations() -> None:
    stepper = balancing()
    for duration in (0.002, 0.013, 0.005):
        stepper.step(duration, F=1.0)
    assert stepper.t == pytest.approx(0.02)
    assert difference(stepper, sb.simulate(cart_pole(), 0.02, UPRIGHT, inputs={"F": 1.0})) < 1e-8
    assert stepper.step().t == pytest.approx(0.03)


def test_ends_of_steps_do_not_drift() -> None:
    stepper = sb.Stepper(cart_pole(), 0.1, inputs=[])
    for _ in range(1000):
        stepper.step()
    assert stepper.t == 100.0


def test_a_long_step() -> None:
    """Longer than what one call of machine code computes."""
    eqs = pushed_mass("-100*x", 1.0, 0.0)
    stepper = sb.Stepper(eqs, 5000.0, rtol=1e-9, max_steps=1_000_000)
    assert stepper.step().t == 5000.0
    assert stepper["x"] == pytest.approx(math.cos(50000.0), abs=1e-2)


@pytest.mark.parametrize(
    ("make", "status"),
    [
        (lambda: sb.Stepper(pushed_mass("x_dot**2", 0.0, 1.0), 0.3), "STEP_COLLAPSE"),
        (lambda: sb.Stepper(pushed_mass("sqrt(0.5 - t)", 0.0, 0.0), 0.3), "NOT_FINITE"),
        (lambda: sb.Stepper(pushed_mass("-100*x", 1.0, 0.0), 20.0, max_steps=10), "TOO_MANY_STEPS"),
    ],
    ids=["infinite", "root", "limit"],
)
def test_motions_that_break_off(make: Callable[[], sb.Stepper], status: str) -> None:
    stepper = make()
    with pytest.raises(sb.SimulationError, match=r"stepper\.broke_off") as caught:
        for _ in range(5):
            stepper.step()
    assert stepper.status.name in (status, "STEP_COLLAPSE")
    assert caught.value.problems[0].why == stepper.status.value
    assert np.isfinite(stepper.q).all()
    stepper.reset()
    assert stepper.status is sb.Status.SUCCESS


def test_steppers_in_threads() -> None:
    def run(seed: int) -> bytes:
        stepper = balancing()
        for force in np.random.default_rng(seed).normal(0.0, 3.0, 3000).tolist():
            stepper.step(F=force)
        return stepper.save()

    one_by_one = [run(seed) for seed in range(4)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, range(4))) == one_by_one


def test_without_the_builtin_call(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = balancing()
    monkeypatch.setattr(kernel_call, "available", lambda: False)
    slow = balancing()
    assert slow._go_on.__module__ == compiled_steps.__name__
    for force in forces(20):
        quick.step(F=force)
        slow.step(F=force)
    assert quick.save() == slow.save()


REFUSED: list[tuple[str, Callable[[sb.Stepper], object]]] = [
    ("stepper.unknown_name", lambda s: s.step(f=1.0)),
    ("stepper.unknown_name", lambda s: s.set(mass=1.0)),
    ("stepper.input_value", lambda s: s.step(F=math.nan)),
    ("stepper.input_value", lambda s: s.step(F=np.ones(1))),  # type: ignore[arg-type]
    ("stepper.input_value", lambda s: s.step(F="2")),  # type: ignore[arg-type]
    ("stepper.input_value", lambda s: s.set(F=math.inf)),
    ("stepper.dt", lambda s: s.step(-0.01, F=1.0)),
    ("stepper.dt", lambda s: s.step(math.nan)),
    ("stepper.input_without_value", lambda s: s.step()),
    ("stepper.input_without_value", lambda s: s.state()),
    ("stepper.input_without_value", lambda s: s["x_ddot"]),
    ("assembly.unknown_name", lambda s: s.reset(z=1.0)),
    ("expression.not_finite", lambda s: s.set(mp=math.nan)),
    ("model.negative_mass", lambda s: s.set(mp=-1.0)),
    ("equations.unknown_output", lambda s: s["nothing"]),
]


@pytest.mark.parametrize(
    ("code", "call"), REFUSED, ids=[f"{code} {k}" for k, (code, _) in enumerate(REFUSED)]
)
def test_refusals_change_nothing(code: str, call: Callable[[sb.Stepper], object]) -> None:
    stepper = balancing()
    before = stepper.save()
    with pytest.raises(sb.SymbodyError) as caught:
        call(stepper)
    assert caught.value.problems[0].code == code
    assert stepper.save() == before


def test_two_inputs_are_set_or_none() -> None:
    stepper = sb.Stepper(example("rr_robot"), 0.01)
    with pytest.raises(sb.UsageError) as caught:
        stepper.step(T1=1.0, T2=math.nan, T3=2.0)
    assert len(caught.value.problems) == 2
    assert stepper.inputs == {}
    assert stepper.step(T1=np.float64(1.0), T2=0).inputs == {"T1": 1.0, "T2": 0.0}


@pytest.mark.parametrize(
    ("code", "options"),
    [
        ("stepper.dt", {"dt": -0.01}),
        ("stepper.dt", {"dt": 0}),
        ("stepper.dt", {"dt": math.inf}),
        ("stepper.t", {"dt": 0.01, "t": math.nan}),
        ("stepper.unknown_name", {"dt": 0.01, "inputs": ["G"]}),
        ("stepper.inputs", {"dt": 0.01, "inputs": [3]}),
        ("stepper.inputs", {"dt": 0.01, "inputs": 3}),
        ("stepper.unknown_name", {"dt": 0.01, "inputs": {"G": 1}}),
        ("simulation.not_a_method", {"dt": 0.01, "integrator": 5}),
        ("simulation.rtol", {"dt": 0.01, "rtol": -1.0}),
        ("assembly.not_a_mapping", {"dt": 0.01, "initial": [1, 2]}),
    ],
)
def test_arguments_that_mean_nothing(code: str, options: dict[str, Any]) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        sb.Stepper(cart_pole(), **options)
    assert caught.value.problems[0].code == code


def test_inputs_by_names_alone() -> None:
    stepper = sb.Stepper(example("rr_robot"), 0.01, inputs=["T2"])
    assert stepper.notes == ("input T1 has no formula and is 0",)
    run = sb.simulate(example("rr_robot"), 0.01, inputs={"T2": 3.0})
    assert difference(stepper.step(T2=3.0), run) < 1e-8
