"""The fault checklist, H: simulation, rows 77 to 90."""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from multiprocessing import get_all_start_methods, get_context

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.errors import SimulationError, SymbodyError, UsageError
from symbody.simulation.native import run as native_run
from tests.faults.refusals import refused
from tests.mechanisms import pendulum
from tests.simulation.test_stop_note import slider_crank

Floats = NDArray[np.float64]


@cache
def cart() -> sb.EquationSet:
    """A mass m on a line under the force F."""
    joint = sb.Prismatic("j", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    model = sb.Model("cart", [sb.Body("B", mass="m"), joint], parameters={"m": 1}, inputs=["F"])
    return sb.form_equations(model)


def refused_run(problem: str, **call: object) -> None:
    arguments = {"t_end": 1.0, **call}
    codes = refused(lambda: sb.simulate(cart(), **arguments), UsageError)
    assert [code for code, _ in codes] == [f"simulation.{problem}"]


def test_row_77_a_collapse_names_the_state_and_the_time() -> None:
    # x'' = x^2, which at x = v sqrt(3/2) ... is infinite in finite time
    run = sb.simulate(cart(), 10.0, initial={"x": 2.0, "x_dot": 2.0}, inputs={"F": "x^2"})
    assert run.status is sb.Status.STEP_COLLAPSE and not run.success
    assert f"known up to t = {run.t[-1]:.9g} s; there x" in run.notes[-1]


def test_row_77_what_is_not_finite_is_told_with_its_state() -> None:
    run = sb.simulate(cart(), 10.0, initial={"x": 1.0, "x_dot": -1.0}, inputs={"F": "0*sqrt(x)"})
    assert run.success  # exactly zero times anything is zero, and folds
    run = sb.simulate(cart(), 10.0, initial={"x": 1.0, "x_dot": -1.0}, inputs={"F": "1e-9*sqrt(x)"})
    assert run.status is sb.Status.NOT_FINITE
    assert "x_dot has no finite derivative" in run.notes[-1]
    assert run.t[-1] == pytest.approx(1.0, abs=1e-6)  # where x passes zero


def test_row_78_a_singular_mass_matrix_ends_the_run_there() -> None:
    with pytest.raises(SymbodyError, match="mass matrix|divided by the constant 0"):
        sb.simulate(cart(), 1.0, parameters={"m": 0})


def test_row_78_what_no_mass_resists_is_named() -> None:
    for attempt in (
        lambda: sb.simulate(cart(), 1.0, parameters={"m": 0}),
        lambda: sb.compile(cart(), "udot", {"m": 0}),
    ):
        assert refused(attempt, words="the motion of x has no mass or inertia") == [
            ("compile.singular_mass", "x")
        ]
    # A massless body between two slides: x and y move against each other, z has a mass.
    joints = [
        sb.Prismatic("a", "ground", "A", axis="x", coordinate="x"),
        sb.Prismatic("b", "A", "B", axis="x", coordinate="y", force=sb.Drive("F")),
        sb.Prismatic("c", "B", "C", axis="z", coordinate="z"),
    ]
    bodies = [sb.Body("A", mass="m"), sb.Body("B", mass=1), sb.Body("C", mass=1)]
    eqs = sb.form_equations(sb.Model("slides", [*bodies, *joints], parameters={"m": 1}, inputs=["F"]))
    assert refused(lambda: sb.simulate(eqs, 1.0, parameters={"m": 0}, inputs={"F": 1})) == [
        ("compile.singular_mass", "x, y")
    ]
    assert sb.simulate(eqs, 1.0).success
    # What is divided by zero without a singular mass matrix is told with the output.
    assert refused(lambda: sb.compile(cart(), "F/(m - 1)")) == [
        ("expression.division_by_zero", "output F/(m - 1)")
    ]


def test_row_78_a_mass_matrix_that_becomes_singular_on_the_way() -> None:
    """A slider on a massless crank and rod: at the dead centre, at rest, it does not resist their motion."""
    from_side = {"theta": 0.5, "s_dot": 1.0}
    run = sb.simulate(slider_crank(0.0), 3.0, from_side, guess={"s": 3.8})
    assert run.status is sb.Status.SINGULAR and not run.success
    assert f"known up to t = {run.t[-1]:.9g} s; there the mass matrix is singular" in run.notes[-1]
    assert (
        "the motion of theta, beta has no mass" in run.notes[-1] and "give what moves there" in run.notes[-1]
    )
    # Without force the slider goes at 1 m/s from where it starts to 1 m + 3 m.
    start = np.cos(0.5) + np.sqrt(9 - np.sin(0.5) ** 2)
    assert run.t[-1] == pytest.approx(4.0 - start, abs=1e-6)
    assert run["s"] == pytest.approx(start + run.t, abs=1e-7)


def test_row_78_a_pole_at_which_a_point_mass_does_not_resist_a_turn() -> None:
    parts = [
        *(sb.Body("Arm"), sb.Body("Bob", mass=1, frames={"pin": sb.Frame(at=(-1, 0, 0))})),
        sb.Revolute("yaw", "ground", "Arm", axis="z", coordinate="a"),
        sb.Revolute("pitch", "Arm", "Bob.pin", axis="y", coordinate="b"),
    ]
    run = sb.simulate(sb.form_equations(sb.Model("m", parts)), 3.0, {"b": np.pi / 2, "b_dot": 1.0})
    assert not run.success and run.t.tolist() == [0.0]
    assert "the motion of a has no mass or inertia" in run.notes[-1]


def test_row_79_a_stiff_motion_is_told_what_to_use() -> None:
    law = {"F": "-1e8*(x - cos(t)) - 1e6*x_dot"}
    run = sb.simulate(cart(), 100.0, inputs=law, max_steps=5_000, integrator=sb.Explicit())
    assert run.status is sb.Status.TOO_MANY_STEPS
    assert "sb.Stiff()" in run.status.value


def test_row_79_without_a_choice_a_stiff_motion_changes_over() -> None:
    law = {"F": "-1e8*(x - cos(t)) - 1e6*x_dot"}
    run = sb.simulate(cart(), 100.0, {"x": 1.0}, inputs=law, max_steps=50_000)
    assert run.success and any(
        "the motion is stiff and sb.Stiff() integrates it" in note for note in run.notes
    )
    # x follows cos(t) behind by d/k = 0.01 s: a stationary motion of amplitude 1 within 1e-4.
    assert run["x"][-1] == pytest.approx(np.cos(100.0 - 0.01), abs=1e-4)


def test_row_80_blow_up_in_finite_time_ends_close_before_it() -> None:
    # x' = 6/(1 - t)^2 times a power: x = 6/(1 - t)^2 solves x'' = x^2
    run = sb.simulate(cart(), 2.0, initial={"x": 6.0, "x_dot": 12.0}, inputs={"F": "x^2"})
    assert run.status is sb.Status.STEP_COLLAPSE
    # a relative error of 1e-8 a step in x moves the pole by about as much
    assert run.t[-1] == pytest.approx(1.0, abs=1e-5)
    half = run.at(0.5)
    assert half["x"] == pytest.approx(24.0, rel=1e-6)


def test_row_81_spans_and_tolerances() -> None:
    still = sb.simulate(cart(), 0.0, initial={"x": 1.0})
    assert still.success and still.t.tolist() == [0.0] and still["x"].tolist() == [1.0]
    back = sb.simulate(cart(), -1.0, initial={"x_dot": 1.0})
    assert back.success and back["x"][-1] == pytest.approx(-1.0, abs=1e-14)
    assert sb.simulate(cart(), 1.0, times=[]).t.size == 0
    assert sb.simulate(cart(), 1.0, times=[0.25]).t.tolist() == [0.25]
    assert sb.simulate(cart(), 1.0, rtol=0.0).success  # atol alone
    refused_run("rtol", rtol=-1e-8)
    refused_run("rtol", rtol=1e-17)
    refused_run("atol", atol=0.0)
    refused_run("atol", atol=-1.0)
    refused_run("t_span", t_end=np.inf)
    refused_run("times", times=[0.5, 0.2])
    refused_run("times", times=[0.5, 2.0])


def test_row_82_defaults_are_tight_and_the_drift_is_known() -> None:
    run = sb.simulate(pendulum(), 100.0, initial={"theta": 2.0})
    swing = np.ptp(run["kinetic_energy"])
    assert run.energy_drift < 1e-6 * swing
    loose = sb.simulate(pendulum(), 100.0, initial={"theta": 2.0}, rtol=1e-3, atol=1e-6)
    assert loose.energy_drift > 1e-3 * swing  # and says so


def test_row_83_friction_that_jumps_comes_to_an_end() -> None:
    law = {"F": "-2*sign(x_dot) + sin(t)"}
    run = sb.simulate(cart(), 5.0, initial={"x_dot": 1.0}, inputs=law, max_steps=20_000)
    assert run.status in (sb.Status.TOO_MANY_STEPS, sb.Status.STEP_COLLAPSE)
    assert run.statistics.evaluations <= 20_000 * 16  # 12 stages a step, 4 for its polynomial
    # and a law for it: the block rests once it has stopped, for |sin t| < 2 cannot move it
    stop = sb.Event("x_dot", -1, "stop", "rest")
    caught = sb.simulate(cart(), 5.0, initial={"x_dot": 1.0}, inputs=law, events=stop)
    assert caught.status is sb.Status.STOPPED
    t = caught.t[-1]
    # the speed there, of errors of 1e-8 a step relative to it
    assert 1.0 - 2.0 * t + 1.0 - np.cos(t) == pytest.approx(0.0, abs=1e-8 * caught.statistics.accepted)


@pytest.mark.parametrize("scale", [None, 1e-3], ids=["sticking", "smooth"])
def test_row_83_friction_of_a_joint_needs_few_steps(scale: float | None) -> None:
    """The same block with its friction in the joint: it stops, and rests since |sin t| < 2."""
    friction = sb.Friction(force=2.0, v0=scale)
    joint = sb.Prismatic("j", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"), friction=friction)
    eqs = sb.form_equations(sb.Model("block", [sb.Body("B", mass=1), joint], inputs=["F"]))
    run = sb.simulate(eqs, 5.0, initial={"x_dot": 1.0}, inputs={"F": "sin(t)"})
    # Explicit steps of about v0 / (2 N/kg) for the smooth law, where a jump took millions of evaluations.
    assert run.success and run.statistics.evaluations < (2_000 if scale is None else 40_000)
    if scale is None:
        (event,) = run.events
        assert event.name == "j sticks"
        # v = 1 - 2 t + 1 - cos(t)
        assert 2.0 - 2.0 * event.t - np.cos(event.t) == pytest.approx(0.0, abs=1e-7)
    late = run.at(np.linspace(2.0, 5.0, 7))["x_dot"]
    assert np.abs(late).max() <= (0.0 if scale is None else 1e-3)  # smooth it creeps at v0 and less


def test_row_84_events_between_long_steps() -> None:
    run = sb.simulate(cart(), 100.0, events=[sb.Event("sin(t)"), sb.Event("sin(t) - 1", name="graze")])
    assert run.statistics.accepted < 31
    names = [name for name, _, _ in run.events]
    assert names.count("sin(t)") == 31 and names.count("graze") == 16


def test_row_85_events_at_the_start_together_and_inside_a_step() -> None:
    events = [
        sb.Event("x - 1", name="b"),
        sb.Event("x - 1", name="a"),
        sb.Event("x", name="start"),
        sb.Event("x - 2", 1, {"x": "0"}, name="again"),
        sb.Event("t - 5", 0, "stop", name="end"),
    ]
    run = sb.simulate(cart(), 100.0, initial={"x_dot": 1.0}, events=events)
    assert [(name, round(t, 9)) for name, t, _ in run.events] == [
        ("b", 1), ("a", 1), ("again", 2), ("b", 3), ("a", 3), ("again", 4), ("b", 5), ("a", 5), ("end", 5),
    ]  # fmt: skip
    assert run.t[-1] == pytest.approx(5.0, rel=1e-14) and run["x"][-1] == pytest.approx(1.0, abs=1e-13)


def test_row_86_functions_that_fail() -> None:
    for law in (lambda t, q, u: 1 / 0, lambda t, q, u: [0.0], lambda t, q, u: "F", lambda t, q, u: np.nan):
        codes = refused(
            lambda law=law: sb.simulate(cart(), 1.0, inputs={"F": law}), SimulationError, "t = 0 s"
        )
        assert codes == [("simulation.input", "input F")]


def test_row_87_tables_that_are_none() -> None:
    for times in ([0, 2, 1], [0, 1, 1, 1], [0], [[0, 1]], [0, np.inf, 2]):
        refused(lambda times=times: sb.Table(times, np.zeros(np.shape(times))), UsageError)
    held = sb.simulate(cart(), 4.0, inputs={"F": ([1, 2], [3.0, 5.0])})
    assert held["F"][0] == 3.0 and held["F"][-1] == 5.0
    strict = sb.Table([1, 2], [3, 5], outside="error")
    refused_run("table_range", inputs={"F": strict})


def test_row_88_samples_beyond_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native_run, "memory_limit", lambda: 24_000)
    times = np.linspace(0, 1, 1001)
    codes = refused(lambda: sb.simulate(cart(), 1.0, times=times), SimulationError, "memory")
    assert codes == [("simulation.memory", "times")]


def test_row_89_a_cancelled_run_is_a_partial_result() -> None:
    shares: list[float] = []

    def watch(share: float) -> bool:
        shares.append(share)
        return len(shares) < 3

    run = sb.simulate(pendulum(), 1e7, initial={"theta": 2.0}, progress=watch, max_steps=10**9)
    assert run.status is sb.Status.INTERRUPTED and not run.success
    assert 0.0 < run.t[-1] < 1e7
    assert run["theta"].size == run.t.size and "known up to" in run.notes[-1]


def test_row_89_a_limit_on_the_time_of_the_clock() -> None:
    """By progress, which is called every twentieth of a second."""
    end = time.monotonic() + 0.3
    run = sb.simulate(
        pendulum(), 1e7, {"theta": 2.0}, progress=lambda share: time.monotonic() < end, max_steps=10**9
    )
    assert run.status is sb.Status.INTERRUPTED and 0.0 < run.t[-1] < 1e7
    assert "known up to" in run.notes[-1]


def end_of(start: float) -> float | str:
    """One case of a sweep: where it ends, or why it does not."""
    try:
        return float(sb.simulate(pendulum(), 2.0, initial={"theta": start})["theta"][-1])
    except SymbodyError as error:
        return error.problems[0].code


def test_row_90_a_sweep_does_not_depend_on_who_computes_it() -> None:
    starts = [0.5, 1.0, float("nan"), 1.5]
    alone = [end_of(start) for start in starts]
    assert isinstance(alone[2], str) and all(isinstance(alone[k], float) for k in (0, 1, 3))
    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(end_of, starts)) == alone


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", get_all_start_methods())
def test_row_90_in_other_processes(method: str) -> None:
    starts = [0.5, 1.0, float("nan"), 1.5]
    with ProcessPoolExecutor(2, get_context(method)) as processes:
        assert list(processes.map(end_of, starts)) == [end_of(start) for start in starts]
