"""Backward differentiation: closed forms, stiffness, the change from explicit steps, events, failures."""

from __future__ import annotations

import math
import sys
import threading

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import Scales
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.methods import integration
from symbody.simulation.methods.explicit import integrate
from symbody.simulation.methods.implicit.state_jacobian import STATE_JACOBIAN, with_state_jacobian
from symbody.simulation.simulation_problem import SimulationProblem
from tests.simulation.loops import damped_slider, example, held_pendulum, pushed_mass, turning_pendulum

# Global errors of backward differentiation over some hundred steps: 1e-8 each, of one sign.
GLOBAL = 1e-5


def slider_at(t: np.ndarray, push: float = 0.0) -> np.ndarray:
    """``x'' + 1e6 x' + 1e6 x = push`` from x = 1 at rest."""
    root = math.sqrt(1e12 - 4e6) / 2.0
    slow, fast = -1e6 / (5e5 + root), -5e5 - root
    rest = push / 1e6
    share = (1.0 - rest) / (fast - slow)
    return rest + share * (fast * np.exp(slow * t) - slow * np.exp(fast * t))


def test_stiff_slider_takes_few_steps_where_explicit_steps_are_hopeless() -> None:
    times = np.linspace(0.0, 5.0, 11)
    run = sb.simulate(damped_slider(), 5.0, times=times, integrator=sb.Stiff())
    assert run.success and run.statistics.accepted < 400
    assert np.abs(run["x"] - slider_at(times)).max() < GLOBAL
    assert np.abs(run.at(1.234).q[0] - slider_at(np.array(1.234))) < GLOBAL


def test_explicit_stops_as_stiff() -> None:
    function = sb.compile(damped_slider(), "xdot")
    raw = integrate(
        function.address, function.work_size, 1, 1, [0.0, 1.0], (0.0, 5.0), method=sb.Explicit(), inputs=[0.0],
        constants=function.constants(), stop_when_stiff=True,
    )  # fmt: skip
    assert raw.status is sb.Status.STIFF and raw.reached < 1.0


@pytest.mark.parametrize("times", [None, np.linspace(0.0, 5.0, 51)])
def test_without_integrator_stiff_motions_change_over_on_the_way(times: np.ndarray | None) -> None:
    run = sb.simulate(damped_slider(), 5.0, times=times, inputs={"F": 3e5})
    assert run.success
    assert any("sb.Stiff() integrates it" in note for note in run.notes)
    assert run.t[0] == 0.0 and run.t[-1] == 5.0 and (np.diff(run.t) > 0.0).all()
    if times is not None:
        assert (run.t == times).all()
    assert np.abs(run["x"] - slider_at(run.t, 3e5)).max() < GLOBAL
    inside = np.linspace(0.0, 5.0, 333)
    assert np.abs(run.at(inside).q[0] - slider_at(inside, 3e5)).max() < GLOBAL
    # Energy and work are of the size of the spring's energy, 5e5 J.
    balance = run["energy"] - run["work"]
    assert np.ptp(balance) < GLOBAL * 5e5


def test_motions_that_are_not_stiff_stay_explicit() -> None:
    run = sb.simulate(example("slider_crank"), 1.0)
    assert run.success and not any("Stiff" in note for note in run.notes)


def trembling_pendulum() -> sb.EquationSet:
    """A pendulum whose pivot hangs in springs without damping: rad/s in the hundred thousands."""
    arm = sb.Body("Arm", mass=2, inertia=(0, 0, 0.5), frames={"pivot": sb.Frame(at=(0, 1, 0))})
    spring = sb.Drive(stiffness=1e10)
    force = {"x": spring, "y": spring}
    mount = sb.Planar("mount", "ground", "Arm.pivot", coordinates=["x", "y", "theta"], force=force)
    return sb.form_equations(sb.Model("bushing", [arm, mount], gravity=(0, -9.81, 0), initial={"theta": 1.5}))


@pytest.mark.parametrize("event", [(), pytest.param(sb.Event("theta - 1.4"), marks=pytest.mark.exhaustive)])
def test_vibrations_without_damping_stay_explicit(event: sb.Event | tuple[()]) -> None:
    """Backward differentiation of higher order is unstable for them, and takes minutes."""
    eqs, options = trembling_pendulum(), {"events": event, "atol": 1e-8}
    run = sb.simulate(eqs, 0.5, **options)
    assert run.success and any("sb.Explicit() integrates the motion" in note for note in run.notes)
    explicit = sb.simulate(eqs, 0.5, **options, integrator=sb.Explicit())
    assert np.array_equal(run.t, explicit.t) and np.array_equal(run.q, explicit.q)
    assert len(run.events) == len(explicit.events) == (1 if event else 0)


def test_a_short_rest_is_left_to_explicit_steps() -> None:
    """0.05 s of the stiff slider are some 8,000 steps at the stability bound of 6 us."""
    run = sb.simulate(damped_slider(), 0.05)
    assert run.success and not any("Stiff" in note for note in run.notes)
    assert np.abs(run["x"] - slider_at(run.t)).max() < 1e-8


def test_the_jacobian_is_that_of_differences() -> None:
    eqs = example("slider_crank")
    inputs = {"F": "-20*s_dot"}
    wider = with_state_jacobian(eqs, inputs)
    task = SimulationProblem(wider, {}, input_laws(("F",), inputs, (0.0, 1.0)), Scales())
    rates, slopes = task.compile_outputs("xdot"), task.compile_outputs(STATE_JACOBIAN)
    start = sb.assemble(eqs, inputs=inputs)
    x = np.array([*start.u.values(), *start.q.values()])
    step = 1e-6
    found = slopes.of_state(0.0, x)
    for k, unit in enumerate(np.eye(x.size)):
        rise = rates.of_state(0.0, x + step * unit) - rates.of_state(0.0, x - step * unit)
        # Third derivatives, below 1e4 here, times step^2, and rounding of 1e3 over the step.
        assert np.abs(found[:, k] - rise / (2.0 * step)).max() < 1e-12 * 1e4 + 1e3 * 1e-15 / step * 10


def test_closed_loops_keep_closed() -> None:
    """The same motion as with explicit steps, the pin at most the tolerance open at every step."""
    pendulum = sb.simulate(held_pendulum(), 2.0, integrator=sb.Stiff())
    reference = sb.simulate(turning_pendulum(), 2.0, times=pendulum.t, rtol=1e-11)
    assert pendulum["constraint_violation"].max() <= 1e-10
    assert np.abs(pendulum["theta"] - reference["theta"]).max() < GLOBAL
    assert np.abs(pendulum["x"] - np.sin(reference["theta"])).max() < GLOBAL


def test_backwards_in_time() -> None:
    run = sb.simulate(turning_pendulum(), (1.0, 0.0), integrator=sb.Stiff())
    there = sb.simulate(turning_pendulum(), 1.0, rtol=1e-11)
    # Released at rest, the motion is even in time.
    assert run.success and run.t[-1] == 0.0
    assert abs(run["theta"][-1] - there["theta"][-1]) < GLOBAL


def test_quaternions_keep_their_norm() -> None:
    run = sb.simulate(example("projectile"), 1.0, integrator=sb.Stiff())
    assert run.success
    names = example("projectile").quaternions
    for four in names:
        assert np.abs(sum(run[name] ** 2 for name in four) - 1.0).max() <= 1e-9


def test_events_stop_and_change_the_motion() -> None:
    stop = sb.Event("theta", direction=-1, action="stop")
    run = sb.simulate(turning_pendulum(), 5.0, integrator=sb.Stiff(), events=stop)
    reference = sb.simulate(turning_pendulum(), 5.0, events=stop, rtol=1e-11)
    assert run.status is sb.Status.STOPPED
    assert abs(run.t[-1] - reference.t[-1]) < GLOBAL
    bounce = sb.Event("theta", direction=-1, action={"theta_dot": "-0.5*theta_dot"})
    run, reference = (
        sb.simulate(turning_pendulum(), 3.0, integrator=by, events=bounce, rtol=tolerance)
        for by, tolerance in ((sb.Stiff(), 1e-8), (sb.Explicit(), 1e-11))
    )
    assert len(run.events) == len(reference.events) > 1
    assert abs(run["theta"][-1] - reference["theta"][-1]) < GLOBAL
    assert np.ptp(run["energy"] - run["work"]) < GLOBAL * 20.0  # J: the weight's work


def test_inputs_that_are_functions() -> None:
    run = sb.simulate(turning_pendulum(), 1.0, integrator=sb.Stiff(), inputs={"T": lambda t, q, u: 0.0})
    assert run.success


def test_limits_and_interruptions() -> None:
    eqs = turning_pendulum()
    assert sb.simulate(eqs, 9.0, integrator=sb.Stiff(), max_steps=7).status is sb.Status.TOO_MANY_STEPS
    seen: list[float] = []

    def enough(share: float) -> bool:
        seen.append(share)
        return False

    run = sb.simulate(eqs, 1e5, integrator=sb.Stiff(), progress=enough)
    assert run.status is sb.Status.INTERRUPTED and len(seen) == 1 and 0.0 < seen[0] < 1.0


def test_motions_that_end_on_the_way_say_so(capfd: pytest.CaptureFixture[str]) -> None:
    """x'' = 6 x^2 with x = 1, x' = 2 is x = 1/(1 - t)^2; x'' = sqrt(x) - 9 is real until x < 0."""
    pole = pushed_mass("6*x^2", 1.0, 2.0)
    run = sb.simulate(pole, 2.0, integrator=sb.Stiff())
    assert run.status in (sb.Status.STEP_COLLAPSE, sb.Status.NOT_FINITE)
    assert 0.99 < run.t[-1] < 1.01 and any("known up to" in note for note in run.notes)
    root = pushed_mass("sqrt(x) - 9", 1.0, 0.0)
    run = sb.simulate(root, 2.0, integrator=sb.Stiff())
    assert run.status is sb.Status.NOT_FINITE
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("wrong", [{"max_order": 6}, {"max_order": 0}, {"max_step": 0.0}])
def test_options_that_make_no_sense(wrong: dict[str, float]) -> None:
    with pytest.raises(sb.UsageError):
        sb.Stiff(**wrong)


def test_longest_step() -> None:
    run = sb.simulate(damped_slider(), 1.0, integrator=sb.Stiff(max_order=2, max_step=0.01))
    assert np.diff(run.t).max() <= 0.01 * (1.0 + 1e-9)


def test_requests_are_checked() -> None:
    for wrong in ({"times": [1.0, 0.0]}, {"rtol": 1e-20}, {"atol": -1.0}):
        with pytest.raises(sb.UsageError):
            sb.simulate(turning_pendulum(), 1.0, integrator=sb.Stiff(), **wrong)


def test_ctrl_c_at_the_change_keeps_what_came_before(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(integration, "run_stiff", interrupted)
    run = sb.simulate(damped_slider(), 5.0)
    assert run.status is sb.Status.INTERRUPTED and 0.0 < run.t[-1] < 1.0
    assert "known up to" in run.notes[-1] and np.abs(run["x"] - slider_at(run.t)).max() < 1e-8


def pushed_oscillator() -> sb.EquationSet:
    body = sb.Body("Body", mass=1)
    drive = sb.Drive(applied="F", stiffness=10, damping=1)
    rail = sb.Prismatic("rail", "ground", "Body", coordinate="x", force=drive)
    return sb.form_equations(sb.Model("oscillator", [body, rail], inputs=["F"]))


def test_what_a_law_prints_is_seen(capsys: pytest.CaptureFixture[str]) -> None:
    eqs = pushed_oscillator()

    def law(t: float, q: object, u: object) -> float:
        if t == 0.0:
            print("said at the start")
        return 0.1

    usual = sys.stdout
    assert sb.simulate(eqs, 0.2, inputs={"F": law}, integrator=sb.Stiff()).success
    assert "said at the start" in capsys.readouterr().out and sys.stdout is usual


def test_laws_of_two_motions_may_wait_for_each_other() -> None:
    # One lock was held while a solver called the law, so that the other motion could not get there.
    eqs = pushed_oscillator()
    ends: list[float] = []
    meeting = threading.Barrier(2, timeout=60)

    def run() -> None:
        met: list[int] = []

        def law(t: float, q: object, u: object) -> float:
            if t > 0.01 and not met:
                met.append(meeting.wait())
            return 0.1

        ends.append(sb.simulate(eqs, 0.2, inputs={"F": law}, integrator=sb.Stiff())["x"][-1])

    usual, threads = sys.stdout, [threading.Thread(target=run) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ends) == 2 and ends[0] == ends[1] and sys.stdout is usual


def damped_on_a_table() -> sb.EquationSet:
    """A block that sticks and slips, with a light one on a strong damper: explicit steps take 6 microseconds."""
    block, light = sb.Body("Block", mass=1), sb.Body("Light", mass=1e-3)
    guide = sb.Prismatic(
        "guide", "ground", block, axis="x", coordinate="x", force=sb.Drive(applied="5*sin(t)"),
        friction=sb.Friction(force=2.0),
    )  # fmt: skip
    damper = sb.Prismatic(
        "damper", block, light, axis="x", coordinate="y", force=sb.Drive(stiffness=100, damping=1e3)
    )
    return sb.form_equations(sb.Model("damped", [guide, damper], initial={"y": 0.01}))


def test_a_stiff_motion_whose_joints_stick_goes_on_by_stiff() -> None:
    eqs = damped_on_a_table()
    run = sb.simulate(eqs, 4.5)
    reference = sb.simulate(eqs, 4.5, integrator=sb.Stiff(), rtol=1e-10)
    assert run.success and run.statistics.accepted < 10_000
    assert sum("sb.Stiff() integrates it" in note for note in run.notes) == 1
    assert [event.name for event in run.events] == [event.name for event in reference.events]
    assert len(run.events) == 2
    times = [[event.t for event in each.events] for each in (run, reference)]
    np.testing.assert_allclose(*times, rtol=0, atol=1e-5)
    assert run["x"][-1] == pytest.approx(reference["x"][-1], abs=1e-6)


def test_a_stiff_case_of_a_sweep_whose_joints_stick_is_that_of_simulate() -> None:
    eqs = damped_on_a_table()
    times = np.linspace(0.0, 4.5, 10)
    run = sb.simulate(eqs, 4.5, times=times, max_steps=20_000)
    cases = sb.sweep(eqs, 4.5, initial={"x": [0.0, 0.0]}, times=times, max_steps=20_000)
    assert cases.success
    for k in range(2):
        np.testing.assert_allclose(cases["x"][k], run["x"], rtol=0, atol=1e-12)
