"""Sweeps with events in the compiled loop: who computes, how much happens, what fails."""

from __future__ import annotations

import concurrent.futures
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.sweeps import sweep_job
from tests.simulation.test_events import BOUNCE, at_rest, ball

HEIGHTS = np.linspace(0.5, 1.5, 7)


def bounces(**more: Any) -> sb.Sweep:
    top = sb.Event("y_dot", -1, name="top")
    given = {"initial": {"y": HEIGHTS}, "parameters": {"e": 0.8}, "times": np.linspace(0.0, 2.0, 5), **more}
    return sb.sweep(ball(), 2.0, events=[BOUNCE, top], **given)


def same(a: sb.Sweep, b: sb.Sweep) -> bool:
    return (
        a.x.tobytes() == b.x.tobytes()
        and a.status == b.status
        and a.counts.tobytes() == b.counts.tobytes()
        and a["work"].tobytes() == b["work"].tobytes()
        and all(a.trajectory(k).events == b.trajectory(k).events for k in range(len(a)))
    )


def test_bounces_are_those_of_the_formula() -> None:
    """From the height h the first hit is at sqrt(2 h/g), each flight takes 0.8 of the one before."""
    sweep = bounces()
    assert sweep.success and not any("one after the other" in note for note in sweep.notes)
    for k, height in enumerate(HEIGHTS):
        fall = np.sqrt(2.0 * height / 9.81)
        hits = fall * (1.0 + 2.0 * np.cumsum(0.8 ** np.arange(0, 20)) - 2.0)
        events = sweep.trajectory(k).events
        assert [e.t for e in events if e.name == "hit"] == pytest.approx(hits[hits <= 2.0], rel=1e-9)
        tops = fall * (1.0 + 2.0 * np.cumsum(0.8 ** np.arange(0, 20)) - 2.0 + 0.8 ** np.arange(1, 21))
        assert [e.t for e in events if e.name == "top"] == pytest.approx(tops[tops <= 2.0], rel=1e-9)


def test_who_computes_does_not_matter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = bounces()
    assert same(usual, bounces(threads=2, part=2))
    assert same(usual, bounces(lanes=True))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        assert same(usual, bounces(executor=pool, part=3, threads=2))
    assert same(usual, bounces(store=tmp_path, part=2))
    monkeypatch.setattr("symbody.simulation.sweeps.workers.compute_in_loop", None)  # nothing is left
    assert same(usual, bounces(store=tmp_path))
    with pytest.raises(sb.UsageError, match="another sweep"):
        bounces(store=tmp_path, parameters={"e": 0.7})


def test_more_happens_than_there_is_room_for_at_first() -> None:
    """Zeros of sin(1000 t), in more steps than fit at first, too."""
    watched = [sb.Event("sin(1000*t)", name="fast"), sb.Event("cos(w*t)", name="own")]
    method = sb.Explicit(max_step=1e-3)
    sweep = sb.sweep(at_rest(), 2.0, {"m": [1, 2]}, events=watched[:1], times=[2.0], integrator=method)
    for k in range(2):
        times = [event.t for event in sweep.trajectory(k).events]
        np.testing.assert_allclose(times, np.pi * np.arange(1, 637) / 1000.0, rtol=1e-13)


def test_times_of_events_may_follow_from_what_varies() -> None:
    """A short pulse of each case's own is not stepped over."""
    pulse = sb.Event("exp(-((t - m)/1e-4)**2) - 0.5", name="pulse")
    sweep = sb.sweep(at_rest(), 5.0, {"m": [1.5, 3.25]}, events=pulse, times=[5.0])
    half = 1e-4 * np.sqrt(np.log(2.0))
    for k, middle in enumerate((1.5, 3.25)):
        times = [event.t for event in sweep.trajectory(k).events]
        assert times == pytest.approx([middle - half, middle + half], rel=1e-12)


@pytest.mark.parametrize("times", [[0.1], [0.1, 0.2], [0.1, 0.2, 1.2], [0.0, 0.3, 0.6, 0.9, 1.2]])
@pytest.mark.parametrize("integrator", [None, sb.Stiff()])
def test_a_stop_is_the_last_sample_where_there_is_room(times: list[float], integrator: object) -> None:
    stop = sb.Event("y - 0.5", action="stop")
    given = {"events": stop, "times": times, "integrator": integrator}
    sweep = sb.sweep(ball(), 1.2, initial={"y": [1.0, 2.0]}, **given)
    for k, height in enumerate((1.0, 2.0)):
        run = sb.simulate(ball(), 1.2, {"y": height}, **given)
        case = sweep.trajectory(k)
        assert case.status is sb.Status.STOPPED
        assert sweep.reached[k] == pytest.approx(np.sqrt(2.0 * (height - 0.5) / 9.81), rel=1e-6)
        count = min(len(times), run.t.size)
        np.testing.assert_allclose(case.t, run.t[:count], rtol=1e-6)
        np.testing.assert_allclose(case["y"], run["y"][:count], rtol=1e-5)
        np.testing.assert_allclose(case.work, run.work[:count], atol=1e-9)


def test_chattering_and_values_without_numbers_stand_in_the_notes_of_their_case() -> None:
    watched = [BOUNCE, sb.Event("sqrt(y - 0.3)", name="root")]
    sweep = sb.sweep(
        ball(), 3.0, {"e": [0.0, 0.3, 0.9]}, initial={"y": 1.0}, events=watched, times=[0.0, 3.0]
    )
    assert [status.name for status in sweep.status] == ["SUCCESS", "CHATTERING", "SUCCESS"]
    assert all("event 'root': its value is not a number" in note for note in sweep.case_notes.values())
    assert "event 'hit' happens again and again" in sweep.case_notes[1]
    alone = sb.simulate(ball(), 3.0, {"y": 1.0}, parameters={"e": 0.3}, events=watched, times=[0.0, 3.0])
    assert sweep.reached[1] == pytest.approx(alone.t[-1], rel=1e-9)


def test_stiff_cases_are_those_of_simulate(monkeypatch: pytest.MonkeyPatch) -> None:
    """A spring of 1e9 N/m on a damper of 1e6 N s/m: the explicit method gives up, `simulate` goes on."""
    force = sb.Drive("-k*x - k/1000*x_dot")
    slide = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=force)
    eqs = sb.form_equations(sb.Model("stiff", [slide], parameters={"k": 1.0}))
    event = sb.Event("x - 0.5", name="half")
    sweep = sb.sweep(eqs, 2.0, {"k": [10.0, 1e9]}, initial={"x": 1.0}, events=event, times=[0.0, 2.0])
    assert sweep.success
    run = sb.simulate(eqs, 2.0, {"x": 1.0}, parameters={"k": 1e9}, events=event, times=[0.0, 2.0])
    assert sweep.trajectory(1).events == run.events
    called: list[int] = []
    monkeypatch.setattr(sweep_job, "simulate", lambda *a, **k: called.append(1))
    assert sb.sweep(eqs, 2.0, {"k": [10.0, 20.0]}, initial={"x": 1.0}, events=event).success
    assert not called


def test_events_that_watch_no_number_are_refused() -> None:
    with pytest.raises(sb.UsageError, match="shape"):
        sb.sweep(ball(), 1.0, {"m": [1, 2]}, events=sb.Event("reaction j"))
    with pytest.raises(sb.UsageError, match="shape"):
        sb.sweep(ball(), 1.0, {"m": [1, 2]}, events=sb.Event("y", action={"y": "reaction j"}))
