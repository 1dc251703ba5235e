"""Sweeps over motions with events, ropes, friction and jumps: each case is the one of `simulate`."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.sweeps import compute, sweep_job
from tests.simulation.test_events import EXAMPLES, slider_crank
from tests.simulation.test_friction import dragged
from tests.simulation.test_impulses import cart_with_pendulum
from tests.simulation.test_rope import ball
from tests.tiers import cases

# Outputs of a sweep take parameters as arguments, those of `simulate` as constants: sums of some ten terms
# round otherwise. States of cases that are not computed in the loop come from `simulate` itself, to the bit.
ROUNDING = 1e-12


@cache
def bouncing() -> sb.EquationSet:
    body = sb.Body("Ball", "m")
    fall = sb.Prismatic("fall", "ground", body, axis="z", coordinate="z")
    return sb.form_equations(
        sb.Model("bouncing", [body, fall], gravity=(0, 0, "-g"), parameters={"m": 1.0, "g": 9.81, "e": 0.8})
    )


@cache
def ropes() -> sb.EquationSet:
    return sb.form_equations(ball())


@cache
def friction() -> sb.EquationSet:
    return sb.form_equations(dragged())


@cache
def struck() -> sb.EquationSet:
    """A block on a spring and a table, pulled by what is given, and a rope that ends its way."""
    block = sb.Body("Block", "m")
    pull = sb.Drive(applied="F - k*x")
    guide = sb.Prismatic("guide", "ground", block, axis="x", coordinate="x", force=pull,
                         friction=sb.Friction(mu="mu", mu_static="mus"))  # fmt: skip
    line = sb.Distance("line", "ground", block, "L", rope=True)
    numbers = {"m": 1.5, "g": 9.81, "k": 20.0, "mu": 0.4, "mus": 0.5, "L": 0.6, "e": 0.5}
    model = sb.Model("struck", [block, guide, line], gravity=(0, 0, "-g"), parameters=numbers, inputs=["F"])
    return sb.form_equations(model)


@cache
def rubbing_loop() -> sb.EquationSet:
    """A slider-crank whose piston sticks and slips."""
    model = sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml")
    rubbing = sb.Friction(mu=0.2, mu_static=0.3)
    joints = [replace(each, friction=rubbing) if each.name == "D" else each for each in model.joints]
    return sb.form_equations(sb.Model("rubbing", [*model.bodies, *joints], gravity=(0, "-G", 0),
                                      parameters=model.parameters, inputs=["F"]))  # fmt: skip


@cache
def jerk() -> sb.EquationSet:
    return cart_with_pendulum("if(t < 1, 0, 1.5*(t - 1))", True)


BOUNCE = [sb.Event("z", -1, {"z_dot": "-e*z_dot"}, "floor"), sb.Event("z_dot", -1, name="top")]
KINDS: dict[str, tuple[Callable[[], sb.EquationSet], float, dict[str, Any], dict[str, Any], list[str]]] = {
    "events": (bouncing, 2.0, {"e": [0.5, 0.8]}, {"initial": {"z": 1.0}, "events": BOUNCE}, ["reaction fall"]),
    "stops": (bouncing, 2.0, {"g": [9.0, 12.0]},
              {"initial": {"z": 3.0}, "events": sb.Event("z - 1", action="stop")}, ["z_ddot"]),
    "loop": (slider_crank, 1.0, {"m2": [0.5, 1.0, 2.0]},
             {"initial": {"theta": 0.3, "theta_dot": 4.0},
              "events": [sb.Event("theta - 2", action={"theta_dot": "-0.5*theta_dot"}, name="back"),
                         sb.Event("s_dot", name="turns"), sb.Event("tan(4*t)", name="pole")]},
             ["reaction D"]),
    "ropes": (ropes, 0.8, {"L": [0.7, 0.8, 0.9]}, {"initial": {"x": 0.1, "y": 0.0, "x_dot": 1.5, "y_dot": 4.0}},
              ["rope_tension rope", "reaction rope", "lambda_rope_1", "y_ddot"]),
    "rope and stop": (ropes, 0.8, {"m": [0.7, 1.4]},
                      {"initial": {"x": 0.1, "y": 0.0, "x_dot": 1.5, "y_dot": 4.0},
                       "events": sb.Event("y + 0.3", action="stop")}, ["rope_tension rope"]),
    "friction": (friction, 2.0, {"k": [30.0, 40.0, 50.0]}, {}, ["friction guide", "reaction guide", "x_ddot"]),
    "struck": (struck, 3.0, {"k": [5.0, 20.0, 60.0], "e": [0.3, 0.6]},
               {"inputs": {"F": sb.Table([0.0, 0.7, 1.5, 3.0], [0.0, 18.0, -18.0, 12.0])},
                "events": [sb.Event("x - 0.2", action={"x_dot": "-e*x_dot"}, name="buffer"),
                           sb.Event("x_dot", name="turns")]},
               ["friction guide", "rope_tension line"]),
    "rubbing loop": (rubbing_loop, 2.0, {"m2": [0.5, 1.0]}, {"initial": {"theta": 0.4, "theta_dot": 1.0}},
                     ["friction D", "reaction D"]),
    "rubbing loop by Baumgarte": (rubbing_loop, 1.0, {"m2": [0.5, 1.0]},
                                  {"initial": {"theta": 0.4, "theta_dot": 1.0}, "constraints": sb.Baumgarte()},
                                  ["friction D"]),
    "fixed steps": (friction, 1.0, {"k": [30.0, 50.0]}, {"integrator": sb.FixedStep(1e-3)}, ["friction guide"]),
    "jumps": (jerk, 1.5, {}, {"initial": {"th": [0.4, 0.5]}}, ["reaction pin"]),
    "partition": (jerk, 0.5, {}, {"initial": {"th": [0.4, 0.5]}, "constraints": sb.Partition()}, ["reaction pin"]),
}  # fmt: skip

IN_LOOP = sorted({*KINDS} - {"jumps", "partition"})


def swept(kind: str, **more: Any) -> sb.Sweep:
    made, end, parameters, options, _ = KINDS[kind]
    return sb.sweep(made(), end, parameters, times=np.linspace(0.0, end, 9), **options, **more)


def alone(kind: str, case: dict[str, float]) -> sb.Trajectory:
    made, end, parameters, options, _ = KINDS[kind]
    initial = {name: case.get(name, value) for name, value in options.get("initial", {}).items()}
    own = {name: case[name] for name in parameters}
    options = {**options, "initial": initial, "parameters": own}
    return sb.simulate(made(), end, times=np.linspace(0.0, end, 9), **options)


@pytest.mark.parametrize(
    "kind",
    cases(IN_LOOP, fast=lambda kind: kind not in ("fixed steps", "ropes", "rubbing loop by Baumgarte")),
)
def test_a_case_with_events_is_that_of_simulate(kind: str) -> None:
    """In the compiled loop what varies stays an argument: rounding differs, and with it the steps."""
    sweep = swept(kind)  # e = 0.5 ends by chattering, in both
    assert not any("one after the other" in note for note in sweep.notes)
    for k in range(len(sweep)):
        case = sweep.trajectory(k)
        run = alone(kind, {name: float(column[k]) for name, column in sweep.cases.items()})
        assert case.status is run.status
        np.testing.assert_allclose(case.t, run.t, rtol=1e-7)
        for ours, theirs in ((case.q, run.q), (case.u, run.u), (case.work, run.work)):
            np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-7)
        assert np.isnan(sweep.x[k, :, run.t.size :]).all()
        assert [note for note in run.notes if "impact" in note and note not in sweep.case_notes[k]] == []
        assert [event.name for event in case.events] == [event.name for event in run.events]
        np.testing.assert_allclose(
            [event.t for event in case.events], [event.t for event in run.events], rtol=1e-9
        )
        for ours, theirs in zip(case.events, run.events, strict=True):
            assert ours.state == pytest.approx(theirs.state, rel=1e-6, abs=1e-6)
        ending = sweep.case_notes.get(k, "").partition("; there ")[2]
        assert (run.status is sb.Status.CHATTERING) == bool(ending)
        assert any(ending in note for note in run.notes) or not ending
        for name in ("energy", "constraint_violation", *KINDS[kind][-1]):
            size = float(np.abs(run[name]).max(initial=1.0))
            np.testing.assert_allclose(sweep[name][k][..., : run.t.size], run[name], rtol=0, atol=1e-6 * size)


@pytest.mark.parametrize("kind", sorted(set(KINDS) - set(IN_LOOP)))
def test_a_case_is_that_of_simulate(kind: str) -> None:
    sweep = swept(kind)
    for k in range(len(sweep)):
        run, case = (
            alone(kind, {name: float(column[k]) for name, column in sweep.cases.items()}),
            sweep.trajectory(k),
        )
        samples = run.t.size
        assert case.q.tobytes() == run.q.tobytes() and case.u.tobytes() == run.u.tobytes()
        assert np.isnan(sweep.x[k, :, samples:]).all()
        assert case.status is run.status
        assert case.events == run.events
        assert all(note in sweep.case_notes[k] for note in run.notes)
        assert case.work.tobytes() == run.work.tobytes()
        for name in ("energy", "constraint_violation", *KINDS[kind][-1]):
            expected, size = run[name], float(np.abs(run[name]).max(initial=1.0))
            for values in (case[name], sweep[name][k][..., :samples]):
                np.testing.assert_allclose(values, expected, rtol=0, atol=ROUNDING * size)


def test_the_work_of_all_cases() -> None:
    sweep = swept("stops")
    for k in range(len(sweep)):
        work = sweep.trajectory(k).work
        assert sweep["work"][k, : work.size].tobytes() == work.tobytes()
        assert np.isnan(sweep["work"][k, work.size :]).all()


def test_multipliers_of_idle_rows_are_zero() -> None:
    """A rope that is slack has none; whatever the modes, there are as many."""
    sweep = swept("ropes")
    for k in range(len(sweep)):
        run = sweep.trajectory(k)
        assert sweep["lambda"][k].shape == (run["lambda"].shape[0], sweep.t.size)
        slack = run["rope_tension rope"] == 0.0
        assert slack.any() and (run["lambda_rope_1"][slack] == 0.0).all()


def same(a: sb.Sweep, b: sb.Sweep) -> bool:
    return (
        a.x.tobytes() == b.x.tobytes()
        and a.status == b.status
        and a.counts.tobytes() == b.counts.tobytes()
        and a.case_notes == b.case_notes
        and all(a.trajectory(k).events == b.trajectory(k).events for k in range(len(a)))
    )


@pytest.mark.parametrize("kind", ["ropes", "jumps"])
@pytest.mark.parametrize("part", [None, 2])
def test_workers_compute_the_same(part: int | None, kind: str) -> None:
    usual = swept(kind)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        by_workers = swept(kind, executor=pool, part=part)
    assert same(usual, by_workers)
    if kind == "jumps":
        assert "by the workers" in by_workers.notes[0] and "in this process" in usual.notes[0]


@pytest.mark.parametrize("kind", ["ropes", "struck"])
def test_a_case_does_not_depend_on_room(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = swept(kind)
    for where, name in ((compute, "_STEPS"), (compute, "_HAPPENED"), (compute, "_ROWS")):
        monkeypatch.setattr(where, name, 4)
    assert same(usual, swept(kind))


def test_a_case_that_leaves_a_rope_too_long_ends_as_in_simulate() -> None:
    eqs, start = ropes(), {"x": 0.1, "y": 0.0, "x_dot": 1.5, "y_dot": 1.0}
    sweep = sb.sweep(eqs, 0.6, {"L": [0.7, 1.5]}, initial={**start}, times=[0.0, 0.6], events=throw_by(0.8))
    runs = [
        sb.simulate(eqs, 0.6, start, guess={}, parameters={"L": length}, events=throw_by(0.8))
        for length in (0.7, 1.5)
    ]
    assert list(sweep.status) == [run.status for run in runs] == [sb.Status.UNMET_ACTION, sb.Status.SUCCESS]
    assert "than the rope is long" in sweep.case_notes[0]


def throw_by(distance: float) -> sb.Event:
    """Return an event that moves the ball down."""
    return sb.Event("y + 0.2", -1, {"y": -distance}, "throw")


def test_sweeps_of_friction_run_forwards() -> None:
    with pytest.raises(sb.UsageError, match="simulation.stick_slip_backwards"):
        sb.sweep(friction(), (1.0, 0.0), {"k": [30.0]})


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", KINDS)
def test_processes_compute_the_same(kind: str) -> None:
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        assert same(swept(kind), swept(kind, executor=pool))


class Counting(concurrent.futures.Executor):
    """Computes at once what it is given, and loses the first time what holds a case."""

    def __init__(self, lost: int = -1) -> None:
        self.cases: list[tuple[int, int]] = []
        self._lost = lost

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        task: concurrent.futures.Future[object] = concurrent.futures.Future()
        if len(arguments) < 3:  # the call that shows whether there is a worker
            task.set_result(function(*arguments, **named))
            return task
        chunk = arguments[1]
        is_new = (chunk.first, chunk.count) not in self.cases
        self.cases.append((chunk.first, chunk.count))
        if is_new and chunk.first <= self._lost < chunk.first + chunk.count:
            task.set_exception(ConnectionError("worker closed"))
        else:
            task.set_result(function(*arguments, **named))
        return task


def test_a_lost_chunk_is_submitted_again() -> None:
    executor = Counting(1)
    assert same(swept("friction"), swept("friction", executor=executor))
    assert sorted(executor.cases) == [(0, 1), (1, 1), (1, 1), (2, 1)]


def test_functions_that_cannot_be_sent_stay_in_this_process() -> None:
    eqs = sb.form_equations(
        sb.Model("pushed", [sb.Body("B", 1), sb.Prismatic("s", "ground", "B", axis="x", coordinate="x",
                 force=sb.Drive(applied="F", stiffness="k"))], parameters={"k": 1.0}, inputs=["F"])
    )  # fmt: skip
    executor = Counting()
    sweep = sb.sweep(eqs, 1.0, {"k": [1.0, 2.0]}, inputs={"F": lambda t, q, u: t}, executor=executor)
    assert sweep.success and not executor.cases
    assert "in this process" in sweep.notes[0]
    # x'' + k x = t from rest: x = (t - sin(w t) / w) / k; local errors of 1e-8 over some ten steps.
    for k, column in zip((1.0, 2.0), sweep["x"], strict=True):
        np.testing.assert_allclose(
            column, (sweep.t - np.sin(np.sqrt(k) * sweep.t) / np.sqrt(k)) / k, atol=1e-6
        )


def test_a_store_keeps_events_and_notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = swept("ropes", store=tmp_path)
    monkeypatch.setattr(sweep_job, "simulate", None)  # nothing is left to compute
    again = swept("ropes", store=tmp_path)
    assert same(usual, again)
    assert again["rope_tension rope"].tobytes() == usual["rope_tension rope"].tobytes()
    assert again["work"].tobytes() == usual["work"].tobytes()


def test_one_case_that_cannot_start_spoils_no_other() -> None:
    start = {"x": 0.1, "y": [0.0, 5.0], "x_dot": 1.5, "y_dot": 4.0}  # longer than the rope: no such state
    sweep = sb.sweep(ropes(), 0.2, initial=start, times=[0.0, 0.2])
    assert sweep.status[0].success and sweep.status[1] is sb.Status.NOT_STARTED
    assert "rope" in sweep.case_notes[1]
