"""Meetings of two things that happen to one motion: events, samples, jumps of rates, FMUs, sweeps, saved states.

Each case has its derivation. What is not right yet is marked as a strict failure, with what it should be.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.tiers import rows


def pulled(motion: str = "if(t < 1, t, 2*t - 1)") -> sb.EquationSet:
    """A slide that is moved as prescribed, and on it another one, free: it stays where it is in space.

    x' jumps from 1 to 2 at t = 1; y' = -(x' - 1) from rest in space, so y' jumps from 0 to -1.
    """
    elements = [
        sb.Body("A", mass=1),
        sb.Prismatic("J", "ground", "A", axis="x", coordinate="x", motion=motion),
        sb.Body("B", mass=1),
        sb.Prismatic("K", "A", "B", axis="x", coordinate="y"),
    ]
    return sb.form_equations(sb.Model("pulled", elements))


def oscillator(**more: Any) -> sb.EquationSet:
    """y'' = -k y."""
    drive = sb.Drive(stiffness="k", **more)
    elements = [
        sb.Body("B", mass=1),
        sb.Prismatic("K", "ground", "B", axis="x", coordinate="y", force=drive),
    ]
    return sb.form_equations(sb.Model("oscillator", elements, parameters={"k": 1}))


def hinge_cut() -> sb.EquationSet:
    """A body that turns in the plane; a cut joint measures its angle a."""
    elements = [
        sb.Body("D", mass=1, inertia=(1, 1, 1)),
        sb.Planar("F", "ground", "D", coordinates=["x", "y", "th"]),
        sb.Revolute("C", "ground", "D", axis="z", coordinate="a", tree=False),
    ]
    return sb.form_equations(sb.Model("hinge", elements))


def hinge_in_space() -> sb.EquationSet:
    """A body on a ball joint; a cut joint measures its angle a, within half a turn: no sum of angles is a."""
    elements = [
        sb.Body("D", mass=1, inertia=(1, 1, 1)),
        sb.Spherical("F", "ground", "D", coordinates=["x", "y", "th"], angles="xyz"),
        sb.Revolute("C", "ground", "D", axis="z", coordinate="a", tree=False),
    ]
    return sb.form_equations(sb.Model("hinge in space", elements))


HINGES = pytest.mark.parametrize("hinge", [hinge_cut, hinge_in_space])


@pytest.mark.parametrize("times", [np.arange(0.0, 2.01, 0.25), [0.0, 1.0, 1.5], [0.5]])
def test_a_stop_behind_a_jump_is_a_sample_at_its_own_time(times: Any) -> None:
    """x = 2 t - 1 passes 2.46 at t = 1.73."""
    run = sb.simulate(pulled(), 2, times=times, events=sb.Event("x - 2.46", action="stop"))
    assert run.t[-1] == pytest.approx(1.73, abs=1e-9) and run["x"][-1] == pytest.approx(2.46, abs=1e-9)
    np.testing.assert_array_equal(run.t[:-1], [t for t in times if t < 1.73])
    np.testing.assert_allclose(run["x"], np.where(run.t < 1, run.t, 2 * run.t - 1), atol=1e-12)


def test_an_event_inside_a_jump_of_rates_happens_behind_it() -> None:
    """x' - 1.5 and y' + 0.5 pass zero where x' jumps from 1 to 2 and y' from 0 to -1."""
    events = [
        sb.Event("x_dot - 1.5"),
        sb.Event("y_dot + 0.5", direction=-1),
        sb.Event("y_dot + 0.5", 1, name="no"),
    ]
    run = sb.simulate(pulled(), 2, events=events)
    assert [(event.name, round(event.t, 9)) for event in run.events] == [
        ("x_dot - 1.5", 1),
        ("y_dot + 0.5", 1),
    ]
    assert all(event.state["y_dot"] == pytest.approx(-1) for event in run.events)
    stopped = sb.simulate(pulled(), 2, events=sb.Event("y_dot + 0.5", action="stop"))
    assert stopped.t[-1] == pytest.approx(1.0) and stopped["y_dot"][-1] == pytest.approx(-1)
    bounced = sb.simulate(pulled(), 2, events=sb.Event("y_dot + 0.5", action={"y_dot": "3"}))
    assert bounced["y"][-1] == pytest.approx(3.0)


@pytest.mark.parametrize("dt", [0.1, 0.125, 0.15, 0.25, 0.3, 1.0])
def test_steps_that_end_at_a_jump_are_struck(dt: float) -> None:
    """Where the jump is in a step, or at its end, changes nothing; its event is seen in this step or the next."""
    stepper = sb.Stepper(pulled(), dt, events=[sb.Event("y_dot + 0.5")])
    seen = []
    while stepper.t < 1.5:
        stepper.step()
        seen += [event.t for event in stepper.events]
    assert stepper["y_dot"] == pytest.approx(-1.0) and seen == [pytest.approx(1.0)]
    assert stepper["y"] == pytest.approx(1.0 - stepper.t)


@pytest.mark.parametrize("times", [None, np.linspace(2, 0, 5), np.linspace(2, 0, 8)])
def test_a_motion_backwards_through_a_jump_has_its_work(times: Any) -> None:
    """T = (x'^2 + (x' + y')^2)/2 changes by the work alone: -1.5 J from t > 1 to t < 1."""
    run = sb.simulate(pulled(), (2, 0), {"y": -1.0, "y_dot": -1.0}, times=times)
    T = run["kinetic_energy"]
    np.testing.assert_allclose(T - T[0], run.work, atol=1e-12)
    assert run.work[-1] == pytest.approx(-1.5) and run["y"][-1] == pytest.approx(0.0, abs=1e-12)
    between = np.array([1.9, 1.1, 0.9, 0.1])
    np.testing.assert_allclose(run.at(between)["work"], [0, 0, -1.5, -1.5], atol=1e-12)


def test_a_sweep_backwards_stops_at_its_event() -> None:
    """y = cos(sqrt(k) (3 - t)) passes zero at t = 3 - pi/(2 sqrt(k))."""
    sweep = sb.sweep(
        oscillator(), (3, 0), {"k": [1.0, 2.0]}, initial={"y": 1.0}, events=sb.Event("y", action="stop"),
        times=np.linspace(3, 0, 4),
    )  # fmt: skip
    for case, k in enumerate((1.0, 2.0)):
        run = sweep.trajectory(case)
        assert run.t[-1] == pytest.approx(3 - math.pi / (2 * math.sqrt(k)), abs=1e-8)
        np.testing.assert_allclose(run["y"], np.cos(math.sqrt(k) * (3 - run.t)), atol=1e-8)


# In roundings of the time of a jump; conditions in x' are looked at 16 roundings of the span beside it.
ROUNDINGS = (-97, -33, -16, -3, -1, 0, 1, 3, 16, 33, 97)


@pytest.mark.parametrize("roundings", ROUNDINGS)
@pytest.mark.parametrize(
    ("jump", "motion"),
    rows(
        [(1.0, "if(t < 1, t, 2*t - 1)"), (0.3, "if(t < 3*0.1, t, 2*t - 0.3)")],
        fast=lambda jump, _: jump == 0.3,
    ),
)
def test_a_time_beside_a_jump_has_the_rates_of_one_side(jump: float, motion: str, roundings: int) -> None:
    """x' and y' are 1 and 0, from the jump on 2 and -1, by whatever has a time there, or ends or begins there."""
    eqs, t = pulled(motion), float(jump + roundings * np.spacing(jump))
    rates = [1.0, 0.0] if t < jump else [2.0, -1.0]
    stepper = sb.Stepper(eqs, t).step()
    sweep = sb.sweep(eqs, 2, {}, initial={"y": [0.0]}, times=[0, t, 2])
    back = {"y": jump - 2, "y_dot": -1.0}
    for found in (
        sb.simulate(eqs, 2, times=[0, t, 2]).outputs("x_dot", "y_dot").values(),
        sb.simulate(eqs, (2, 0), back, times=[2, t, 0]).outputs("x_dot", "y_dot").values(),
        ([sb.simulate(eqs, 2).at(t)[name]] * 2 for name in ("x_dot", "y_dot")),
        ([sb.simulate(eqs, (2, 0), back).at(t)[name]] * 2 for name in ("x_dot", "y_dot")),
        ([sb.simulate(eqs, t)[name][-1]] * 2 for name in ("x_dot", "y_dot")),
        ([sb.simulate(eqs, (2, t), back)[name][-1]] * 2 for name in ("x_dot", "y_dot")),
        ([sweep[name][0, 1]] * 2 for name in ("x_dot", "y_dot")),
        ([stepper[name]] * 2 for name in ("x_dot", "y_dot")),
    ):
        np.testing.assert_allclose([values[1] for values in found], rates, atol=1e-9)
    assert stepper.step()["y_dot"] == pytest.approx(-1.0)
    behind = sb.simulate(eqs, (t, 2), {"y_dot": rates[1]})
    assert behind["y_dot"][-1] == pytest.approx(-1.0) and behind.t[0] == t
    ended = sb.simulate(eqs, t)
    assert ended.t[-1] == t and ended.at(t)["work"] == pytest.approx(ended.work[-1]) == (
        0 if t < jump else 1.5
    )


@pytest.mark.parametrize("length", [1e-15, 1e-14, 1e-12, 1e-9, 1e-7])
def test_motions_may_be_short(length: float) -> None:
    """Where t = 1 times are 2.2e-16 apart; y'' = -y from y = 0 and y' = 1 moves y by the time that passes."""
    for eqs in (oscillator(), pulled()):
        run = sb.simulate(eqs, (1, 1 + length), {"y_dot": 1.0})
        assert run.success and run["y"][-1] == pytest.approx(run.t[-1] - 1, rel=1e-6)


def slide(law: Callable[..., float] | str, mu_static: float = 0.4, length: float = 3.0) -> sb.EquationSet:
    elements = [
        sb.Body("A", mass=1),
        sb.Prismatic("J", "ground", "A", axis="x", coordinate="x", force=sb.Drive(applied="F"),
                     friction=sb.Friction(mu=0.2, mu_static="mu_static")),
        sb.Distance("line", "ground", "A", "L", rope=True),
    ]  # fmt: skip
    values = {"mu_static": mu_static, "L": length}
    return sb.form_equations(
        sb.Model("slide", elements, parameters=values, inputs=["F"], gravity=[0, -9.81, 0])
    )


def refused(store: Path, eqs: sb.EquationSet, law: Any, **more: Any) -> bool:
    try:
        sb.sweep(eqs, 0.1, {}, initial={"x": [0.5, 0.6]}, inputs={"F": law}, times=[0.1], store=store, **more)
    except sb.UsageError as error:
        return error.problems[0].code == "sweep.store"
    return False


def test_a_store_serves_no_other_sweep(tmp_path: Path) -> None:
    """Each of these changes results, and no line of the code of x'."""
    weight = 1.0

    def pull(t: float, q: Any, u: Any) -> float:
        return weight * math.cos(t)

    def other(t: float, q: Any, u: Any) -> float:
        return weight * math.sin(t)

    assert not refused(tmp_path / "s", slide("F"), "2*t")
    assert not refused(tmp_path / "s", slide("F"), "2*t")
    assert refused(tmp_path / "s", slide("F", mu_static=0.9), "2*t")
    assert refused(tmp_path / "s", slide("F", length=2.0), "2*t")
    assert refused(tmp_path / "s", slide("F"), "3*t")
    assert not refused(tmp_path / "f", slide("F"), pull)
    assert not refused(tmp_path / "f", slide("F"), pull)
    assert refused(tmp_path / "f", slide("F"), other)
    weight = 2.0
    assert refused(tmp_path / "f", slide("F"), pull)
    stiff = {"integrator": sb.Stiff()}
    assert not refused(tmp_path / "i", slide("F"), "0", guess={"x": 0.1}, **stiff)
    assert refused(tmp_path / "i", slide("F"), "0", guess={"x": 0.2}, **stiff)


def test_a_store_refuses_a_law_without_content(tmp_path: Path) -> None:
    class Law:
        def __call__(self, t: float, q: Any, u: Any) -> float:
            return 1.0

    with pytest.raises(sb.UsageError, match="Law has no content that can be compared") as caught:
        sb.sweep(slide("F"), 0.1, {}, initial={"x": [0.5]}, inputs={"F": Law()}, store=tmp_path / "s")
    assert caught.value.problems[0].code == "sweep.store_function"
    assert "key=" in caught.value.problems[0].fix
    for key, is_refused in (("1", False), ("1", False), ("2", True)):
        assert refused(tmp_path / "s", slide("F"), Law(), key=key) == is_refused


def test_a_store_reads_no_module_of_a_user(tmp_path: Path) -> None:
    """What stands in it may change from call to call; libraries are known by their release."""
    gains = ModuleType("gains")
    law = eval("lambda t, q, u: gains.k * math.cos(t)", {"gains": gains, "math": math})
    gains.k = 2.0  # type: ignore[attr-defined]
    with pytest.raises(sb.UsageError, match="module gains has no content that can be compared"):
        sb.sweep(slide("F"), 0.1, {}, initial={"x": [0.5]}, inputs={"F": law}, store=tmp_path / "s")


def test_a_stepper_restores_no_foreign_bytes() -> None:
    """Tables that differ in the middle, where their texts are cut; functions of other code; not other lengths of steps."""
    t = np.linspace(0, 10, 3001)
    changed = np.sin(t) + np.where((t > 4) & (t < 5), 1.0, 0.0)
    laws: list[Any] = [sb.Table(t, np.sin(t)), sb.Table(t, changed), lambda t, q, u: 1.0, lambda t, q, u: 2.0]
    eqs = slide("F")
    saved = [sb.Stepper(eqs, 0.1, inputs={"F": law}).step().save() for law in laws]
    for k, law in enumerate(laws):
        for j, content in enumerate(saved):
            stepper = sb.Stepper(eqs, 0.1, inputs={"F": law})
            if j == k:
                stepper.restore(content)
                continue
            with pytest.raises(sb.UsageError, match="a different stepper"):
                stepper.restore(content)
    sb.Stepper(eqs, 0.2, inputs={"F": laws[0]}).restore(saved[0])


def test_an_event_that_jumps_is_seen_where_an_angle_is_a_letter_of_a_word() -> None:
    """max(s, 0.1) - 0.5 jumps at t = 1 with the table s; the a of max is not the angle a of the cut joint."""
    model = hinge_cut().model
    jump = sb.Lookup("s", points=[[0, 0.2], [1, 0.2], [1, 0.9], [2, 0.9]])
    eqs = sb.form_equations(sb.Model("hinge", [*model.elements, jump]))
    run = sb.simulate(eqs, 2, {"th_dot": 0.1}, events=sb.Event("max(s, 0.1) - 0.5"))
    assert [event.t for event in run.events] == [pytest.approx(1.0)]
    # The own jump of an angle from half a turn to minus half a turn is none.
    turning = sb.simulate(
        hinge_in_space(),
        2,
        {"th_dot": 2.0},
        events=[sb.Event("a - 3", name="a"), sb.Event("a + 0.5", name="b")],
    )
    assert [event.name for event in turning.events] == ["a"]


@HINGES
@pytest.mark.parametrize("count", [None, 2, 3, 7, 500])
def test_the_angle_of_a_cut_joint_counts_turns_whatever_the_samples(
    hinge: Callable[[], sb.EquationSet], count: int | None
) -> None:
    """th = 2.5 t, and a = th."""
    times = None if count is None else np.linspace(0, 10, count)
    run = sb.simulate(hinge(), 10, {"th_dot": 2.5}, times=times)
    np.testing.assert_allclose(run["a"], run["th"], atol=1e-9)
    np.testing.assert_allclose(run.outputs("a", "energy")["a"], run["th"], atol=1e-9)
    assert run.at(9.3)["a"] == pytest.approx(23.25) and run.at([3.7, 9.3])["a"][1] == pytest.approx(23.25)
    back = sb.simulate(hinge(), (10, 0), {"th_dot": 2.5})
    assert back["a"][-1] == pytest.approx(-25.0)


def test_a_sweep_counts_turns_or_says_that_it_cannot() -> None:
    fine = sb.sweep(hinge_in_space(), 10, {}, initial={"th_dot": [0.0, 2.5]})
    np.testing.assert_allclose(fine["a"], fine["th"], atol=1e-9)
    coarse = sb.sweep(hinge_in_space(), 10, {}, initial={"th_dot": [0.0, 2.5]}, times=[0.0, 5.0, 10.0])
    with pytest.raises(sb.UsageError, match="half a turn between samples") as caught:
        coarse["a"]
    assert caught.value.problems[0].code == "trajectory.turns"


def test_a_coarse_sweep_counts_turns() -> None:
    """a = th = 2.5 t, as `simulate` has it with the same times."""
    coarse = sb.sweep(hinge_cut(), 10, {}, initial={"th_dot": [2.5]}, times=[0.0, 5.0, 10.0])
    np.testing.assert_allclose(coarse["a"], coarse["th"], atol=1e-9)


def test_an_angle_that_the_tree_knows_counts_turns_at_the_first_state() -> None:
    """th = 20 at first is more than three turns; a difference of the angles of two arms is a, too."""
    eqs = hinge_cut()
    assert eqs.wrapped_angles == () and hinge_in_space().wrapped_angles == ("a",)
    assert sb.Stepper(eqs, 0.1, initial={"th": 20.0})["a"] == pytest.approx(20.0)
    pin = {"axis": "z", "tree": True}
    elements = [
        sb.Body("A", mass=1, inertia=(1, 1, 1)),
        sb.Body("B", mass=1, inertia=(1, 1, 1)),
        sb.Revolute("J", "ground", "A", coordinate="p", **pin),
        sb.Planar("K", "A", "B", coordinates=["x", "y", "r"]),
        sb.Revolute("C", "B", "ground", axis="z", coordinate="a", tree=False),
    ]
    both = sb.form_equations(sb.Model("arms", elements))
    run = sb.simulate(both, 5, {"p_dot": 3.0, "r_dot": 1.5})
    np.testing.assert_allclose(run["a"], -(run["p"] + run["r"]), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["a_dot"], -(run["p_dot"] + run["r_dot"]), rtol=1e-12, atol=1e-12)
    assert run["a"][-1] == pytest.approx(-22.5)


def test_cases_behind_the_loop_are_in_the_bar() -> None:
    """Two of three cases are stiff (y'' = -k y - 2 sqrt(k) y'), so the loop ends with a share below 1."""
    shares: list[float] = []
    eqs = oscillator(damping="2*sqrt(k)")
    sweep = sb.sweep(eqs, 10, {"k": [1.0, 1e10, 4e10]}, initial={"y": 1.0}, progress=shares.append)
    assert sweep.success and shares[-1] == 1.0
    assert all(share < 1.0 for share in shares[:-1])


class BrokenExecutor(Executor):
    """Takes nothing."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        raise BrokenProcessPool("a worker was killed")


class BreakingExecutor(Executor):
    """Computes one part, breaks with the second, takes no third."""

    def __init__(self) -> None:
        self.parts = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        task: Future[Any] = Future()
        self.parts += bool(args)
        if self.parts > 2:
            raise BrokenProcessPool("it is broken")
        if self.parts == 2 and args:
            task.set_exception(BrokenProcessPool("the worker ran out of memory"))
        else:
            task.set_result(fn(*args, **kwargs))
        return task


class LosingExecutor(ThreadPoolExecutor):
    """Its workers end with cases that `simulate` computes."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        if args and type(pickle.loads(args[0])).__name__ == "SweepJob":
            task: Future[Any] = Future()
            task.set_exception(ConnectionError("worker closed"))
            return task
        return super().submit(fn, *args, **kwargs)


class CountingExecutor(ThreadPoolExecutor):
    """Counts what is cancelled."""

    cancelled = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        task = super().submit(fn, *args, **kwargs)
        counter = self

        def cancel() -> bool:
            counter.cancelled += 1
            return Future.cancel(task)

        task.cancel = cancel  # type: ignore[method-assign]
        return task


def test_a_users_executor_is_never_replaced() -> None:
    """Whoever gives an executor has chosen where to compute: on machines with other memory, licences, limits."""
    with pytest.raises(sb.EnvironmentFault, match="sweep.no_worker") as fault:
        sb.sweep(oscillator(), 1, {"k": [1.0, 2.0]}, initial={"y": 1.0}, executor=BrokenExecutor())
    assert "a worker was killed" in str(fault.value)


def test_an_executor_that_breaks_on_the_way_costs_what_it_had_and_no_more(tmp_path: Path) -> None:
    """It computes one case, takes a second and breaks with it; the third it never sees."""
    call: dict[str, Any] = {"times": [0.5, 1.0], "part": 1, "store": tmp_path, "initial": {"y": 1.0}}
    springs = {"k": [1.0, 2.0, 3.0]}
    sweep = sb.sweep(oscillator(), 1, springs, executor=BreakingExecutor(), **call)
    statuses = [sb.Status.SUCCESS, sb.Status.WORKER_LOST, sb.Status.INTERRUPTED]
    assert list(sweep.status) == statuses and np.isfinite(sweep.x[0]).all()
    assert "the worker ran out of memory" in sweep.case_notes[1] and 2 not in sweep.case_notes
    assert any("the executor broke (BrokenProcessPool: the worker ran" in note for note in sweep.notes)
    rest = sb.sweep(oscillator(), 1, springs, **call)
    assert rest.success and rest.x[0].tobytes() == sweep.x[0].tobytes()


def test_a_case_behind_the_loop_that_ends_its_worker_costs_no_other() -> None:
    """The second case is stiff, so `simulate` is to compute it."""
    eqs = oscillator(damping="2*sqrt(k)")
    with LosingExecutor(1) as executor:
        sweep = sb.sweep(eqs, 10, {"k": [1.0, 1e10]}, initial={"y": 1.0}, executor=executor)
    assert list(sweep.status) == [sb.Status.SUCCESS, sb.Status.WORKER_LOST]
    assert "worker closed" in sweep.case_notes[1]


def test_no_call_that_is_over_is_cancelled() -> None:
    """Dask reports a cancelled call as an error when its client closes."""
    with CountingExecutor(2) as executor:
        sb.sweep(oscillator(), 1, {"k": [1.0, 2.0]}, initial={"y": 1.0}, executor=executor)
        assert executor.cancelled == 0


def test_times_within_rounding_of_an_end_are_that_end() -> None:
    """3*0.1 is 0.30000000000000004."""
    times = np.arange(4) * 0.1
    assert times[-1] > 0.3
    run = sb.simulate(oscillator(), 0.3, {"y": 1.0}, times=times)
    assert run.t[-1] == 0.3 and run.t.size == 4
    assert sb.sweep(oscillator(), 0.3, {}, initial={"y": [1.0]}, times=times).t[-1] == 0.3
    assert sb.simulate(oscillator(), (0.3, 0), {"y": 1.0}, times=times[::-1]).t[0] == 0.3
    with pytest.raises(sb.UsageError, match="outside the motion's span"):
        sb.simulate(oscillator(), 0.3, {"y": 1.0}, times=[0.0, 0.3 * (1 + 1e-12)])
