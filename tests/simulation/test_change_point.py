"""When `Partition` takes over from `Projection`, and when not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.scales import mechanism_scales
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.closed_loops.passages import Passages
from symbody.simulation.methods.integration import Integration, end_run
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import RawRun, Statistics
from symbody.simulation.simulation_problem import SimulationProblem
from tests.faults.test_constraint_rows import parallelogram, shaft, slider_crank
from tests.problems.mechanisms import model_of
from tests.problems.test_bennett import GUESS, linkage
from tests.tiers import cases


def overconstrained(eqs: sb.EquationSet, fixed: dict[str, float], guess: dict[str, float]) -> bool:
    problem = SimulationProblem(
        eqs, {}, input_laws(eqs.input_names, {}, (0.0, 1.0)), mechanism_scales(eqs, {})
    )
    first = assemble(eqs, fixed, guess)
    return is_overconstrained(problem, 0.0, np.array([*first.u.values(), *first.q.values()]))


def test_bennett_is_overconstrained() -> None:
    assert overconstrained(linkage(), {"t1": 1.0}, GUESS)


def test_neither_duplicates_nor_planes_nor_flat_starts_are() -> None:
    """Rows that follow from others in every state do no harm; a change point at the start is none for long."""
    assert not overconstrained(shaft(), {"a": 0.3}, {})
    absolute = sb.form_equations(model_of("slider_crank"), tree="absolute")
    assert not overconstrained(absolute, {"theta": 0.5}, {})
    flat = {"a": 0.0, "a_dot": 8.0, "d_dot": 8.0}
    assert not overconstrained(parallelogram(), flat, {})


@pytest.mark.parametrize(("crank", "passes"), [(2.0, False), (3.0, True)])
def test_change_points_of_a_slider_crank(crank: float, passes: bool) -> None:
    """With a rod of 3 m and a crank of 3 m the slider passes the pivot; with a shorter one it turns back."""
    run = sb.simulate(slider_crank(crank), 2.0, {"theta": 0.5, "theta_dot": 4.0})
    assert run.success
    assert any("change point" in note for note in run.notes) == passes
    if passes:
        # The branch of the start: beta = -2 theta, and the slider goes to and fro through the pivot.
        assert np.abs(run["beta"] + 2 * run["theta"]).max() < 1e-8
        assert run["s"].min() < -5.0


@pytest.mark.exhaustive
def test_a_limit_on_steps_is_neither_a_lock_nor_a_change_point() -> None:
    """Steps that grow, or stay as they are, end because they are few."""
    for constraints in (sb.GGL(), sb.Projection()):
        run = sb.simulate(
            linkage(), 2.0, {"t1": 1.0, "t1_dot": 3.0}, guess=GUESS, constraints=constraints, max_steps=3
        )
        assert run.status is sb.Status.TOO_MANY_STEPS
        assert not any("locked" in note or "change point" in note for note in run.notes), run.notes


def test_times_beside_a_change_point_stay_within_the_motion() -> None:
    """The sum at + (end - at) is rounded to beyond the end for one in ten of these."""
    branch: Any = None
    loops: Any = SimpleNamespace(places=slice(0, 1), singular_values=lambda t, q: np.zeros((t.size, 1)))
    for at, end in np.sort(np.random.default_rng(0).uniform(0.1, 1.0, (100, 2))).tolist():
        dense = DenseOutput(np.array([0.0, end]), np.zeros((1, 4, 1)))
        assert Passages(loops, dense, branch, 1, 1.0, np.zeros(2)).jump(at, []) is None


def test_explicit_choices_stand() -> None:
    start, guess = {"a": 1.0, "a_dot": 8.0}, {"b": -1.0, "d": 1.0}
    for constraints in (sb.Projection(), sb.Baumgarte()):
        run = sb.simulate(parallelogram(), 0.5, start, guess=guess, constraints=constraints)
        assert not any("sb.Partition() integrates" in note for note in run.notes)
    run = sb.simulate(parallelogram(), 0.5, start, guess=guess, integrator=sb.Explicit(order=5))
    assert any("sb.Partition() integrates" in note for note in run.notes)


@pytest.mark.parametrize("constraints", [None, sb.Projection(), sb.Partition()])
def test_a_flat_start_goes_on_along_its_branch(constraints: sb.Projection | sb.Partition | None) -> None:
    start, guess = {"a": 0.0, "a_dot": 8.0, "d_dot": 8.0}, {"b": 0.0, "d": 0.0}
    run = sb.simulate(parallelogram(), 1.5, start, guess=guess, constraints=constraints)
    assert run.success
    # Equal angles all the way, to the tolerance of the constraints, past three more flat poses.
    assert np.abs(run["a"] - run["d"]).max() < 1e-8 and np.ptp(run["energy"] - run["work"]) < 1e-5
    assert run["a"].max() > 3.0 * np.pi


@pytest.mark.parametrize("speeds", [(0.0, 0.0), (8.0, 2.0)])
def test_what_leaves_the_branch_open_is_no_start(speeds: tuple[float, float]) -> None:
    """At rest both branches are open; with cranks of 1 m only equal and opposite speeds belong to one."""
    start = {"a": 0.0, "d": 0.0, "a_dot": speeds[0], "d_dot": speeds[1]}
    try:
        run = sb.simulate(parallelogram(), 0.2, start, guess={"b": 0.0}, constraints=sb.Partition())
    except sb.AssemblyError as error:
        assert "the position is singular" in str(error)
        return
    assert run.status is sb.Status.SINGULAR
    assert any("along several branches" in note for note in run.notes)


def test_sweeps_stay_on_the_branches_of_their_motions() -> None:
    """Equal angles in every case: the loop over many cases passes flat poses on either branch."""
    found = sb.sweep(
        parallelogram(), 2.0, initial={"a": [1.0, 1.1, 1.2], "a_dot": [6.0, 8.0]}, guess={"b": -1.0, "d": 1.0},
        times=[0.0, 1.0, 2.0],
    )  # fmt: skip
    assert found.success and any("change point" in note for note in found.notes)
    names = list(found.state_names)
    assert np.abs(found.x[..., names.index("a"), :] - found.x[..., names.index("d"), :]).max() < 1e-8


def test_baumgarte_stops_where_it_leaves_the_branch() -> None:
    """A rod as long as the crank: the slider at 2 r cos a passes the pivot, where the rod could turn along."""
    run = sb.simulate(slider_crank(3.0), 2.0, {"theta": 0.5, "theta_dot": 4.0}, constraints=sb.Baumgarte())
    assert run.status is sb.Status.SINGULAR
    assert any("change point" in note and "sb.Baumgarte() leaves" in note for note in run.notes)
    # The rod is turned by -theta as long as the motion is known, to what Baumgarte's terms leave open.
    assert np.abs(run["beta"] + 2 * run["theta"]).max() < 1e-4


def wheels_on_a_rod(posts: list[float]) -> sb.EquationSet:
    count = len(posts)
    wheels = [
        sb.Body(f"W{k}", mass=1, inertia=(0.1, 0.1, 0.1), frames={"tip": sb.Frame(at=(0.5, 0, 0))})
        for k in range(count)
    ]
    pins = {f"p{k}": sb.Frame(at=(x, 0, 0)) for k, x in enumerate(posts)}
    rod = sb.Body("Rod", mass=2, inertia=(0.2, 0.2, 0.2), frames=pins)
    joints = [sb.Revolute(f"A{k}", f"ground.p{k}", f"W{k}", coordinate=f"a{k}") for k in range(count)]
    joints += [sb.Revolute(f"B{k}", f"W{k}.tip", f"Rod.p{k}", coordinate=f"b{k}") for k in range(count)]
    return sb.form_equations(sb.Model("locomotive", [*wheels, rod, *joints], ground=pins))


@pytest.mark.parametrize("constraints", [None, sb.Projection(), sb.Partition()])
def test_three_wheels_on_a_rod(constraints: sb.Projection | sb.Partition | None) -> None:
    """Constraints that follow from others are no change point, whoever looks for them where.

    All wheels turn alike: (3 I + m r^2) a'' = 0 without gravity, so that the speed of 9 rad/s stays.
    """
    eqs = wheels_on_a_rod([0.0, 1.0, 2.5])
    angles = {"a0": 1.0, "a1": 1.0, "a2": 1.0, "b0": -1.0, "a0_dot": 9.0}
    run = sb.simulate(eqs, 2.0, angles, guess={"a1_dot": 9.0, "a2_dot": 9.0}, constraints=constraints)
    assert run.success, run.notes
    assert not any("start is a change point" in note for note in run.notes)
    for k in range(3):  # some thirty steps with 1e-8 of 19 rad each
        assert np.abs(run[f"a{k}"] - 1.0 - 9.0 * run.t).max() < 1e-5


@pytest.mark.parametrize(
    "way",
    cases(
        [{"integrator": sb.FixedStep(0.01)}, {"constraints": sb.Baumgarte()}, {"integrator": sb.Stiff()}],
        fast=[{"integrator": sb.FixedStep(0.01)}],
    ),
)
def test_constraints_that_follow_do_not_hold_the_mechanism(way: dict[str, Any]) -> None:
    """Stages and samples of Bennett's linkage are a little open, where its constraints are independent."""
    eqs, times = linkage(), np.linspace(0.0, 1.0, 41)
    start = {"t1": 1.0, "t1_dot": 3.0}
    exact = sb.simulate(eqs, 1.0, start, guess=GUESS, times=times, rtol=1e-10)
    run = sb.simulate(eqs, 1.0, start, guess=GUESS, times=times, **way)
    assert exact.success and run.t.size > 10
    if not run.success:
        assert any("are redundant only where all loops are closed" in note for note in run.notes)
    for name in eqs.coordinate_names:  # a hundredth of the tolerance of 1e-8 for each of some thousand steps
        assert np.abs(run[name] - exact[name][: run.t.size]).max() < 1e-5


@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
def test_samples_of_an_explicit_choice_are_on_the_branch(rtol: float) -> None:
    """All wheels turn alike past their flat poses, wherever in a step they are looked at."""
    posts = [0.0, 1.0, 2.5]
    run = sb.simulate(
        wheels_on_a_rod(posts), 1.5, {"a0": 1.0, "a1": 1.0, "a2": 1.0, "b0": -1.0, "a0_dot": 9.0},
        guess={"a1_dot": 9.0, "a2_dot": 9.0}, constraints=sb.Projection(), times=np.linspace(0.0, 1.5, 301), rtol=rtol,
    )  # fmt: skip
    assert run.success and any("sb.Projection() would block" in note for note in run.notes)
    for motion in (run, run.at(run.t)):
        for k in range(len(posts)):
            assert np.abs(motion[f"a{k}"] - 1.0 - 9.0 * run.t).max() < 1e3 * rtol


def test_a_run_may_end_where_it_starts() -> None:
    """The first step already leaves the branch: only the start is returned."""
    raw = RawRun(
        np.array([0.0, 1.0]), np.zeros((1, 2)), sb.Status.SUCCESS, Statistics(1, 0, 1, 0.0), 1.0, None, None,
        DenseOutput(np.array([0.0, 1.0]), np.ones((1, 4, 1))),
    )  # fmt: skip
    run = end_run(Integration(raw, (), None), 0.0, "left")
    assert run.raw.status is sb.Status.SINGULAR and run.raw.t.tolist() == [0.0] and run.notes == ("left",)
    assert run.raw.dense_output is not None and run.raw.dense_output(0.0).tolist() == [1.0]
