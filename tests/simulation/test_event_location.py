"""The kernels that find events: the language's own meaning, room for what happens, many at a time."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.kernels.events import event_watch
from symbody.kernels.events.event_monitor import ENDS, RECORDS, STOPS, EventMonitor
from symbody.kernels.language import Reals
from symbody.simulation.events.watch_arrays import WatchedEvent, WatchNumbers, make_watch_block
from tests.simulation.test_events import at_rest, times_of


def test_more_events_than_there_is_room_for_at_first() -> None:
    run = sb.simulate(at_rest(), 10.0, events=sb.Event("sin(1000*t)", name="fast"))
    count = int(10.0 * 1000.0 / np.pi)
    # zeros at k pi / 1000; the argument is rounded to an ulp of 10,000
    np.testing.assert_allclose(
        times_of(run, "fast"), np.pi * np.arange(1, count + 1) / 1000.0, rtol=0, atol=1e-14
    )


def test_events_of_many_kinds_happen_in_order() -> None:
    events = [sb.Event(f"t - {k}/16", name=f"e{k}") for k in range(40, 0, -1)]
    run = sb.simulate(at_rest(), 2.0, events=[*events, sb.Event("t - 2.25", action="stop")])
    assert [event.name for event in run.events] == [f"e{k}" for k in range(1, 33)]


@pytest.mark.parametrize("integrator", [None, sb.Stiff(), sb.FixedStep(0.01)])
def test_all_integrators_share_one_search(integrator: object) -> None:
    watched = {"up": ("cos(t)", 1), "down": ("cos(t)", -1), "top": ("sin(t) - 1", 0)}
    run = sb.simulate(
        at_rest(),
        10.0,
        integrator=integrator,
        events=[sb.Event(text, way, name=name) for name, (text, way) in watched.items()],
    )
    np.testing.assert_allclose(times_of(run, "up"), [1.5 * np.pi], rtol=1e-14)
    np.testing.assert_allclose(times_of(run, "down"), np.pi * np.array([0.5, 2.5]), rtol=1e-14)
    np.testing.assert_allclose(times_of(run, "top"), np.pi * np.array([0.5, 2.5]), rtol=0, atol=1e-10)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_python_runs_the_search(direction: float) -> None:
    """A straight motion x = t in two steps; values (x^2 - 2) (x - 1/2)^2 and x - 2.5, found by Python alone."""
    numbers = WatchNumbers(2, 1, np.zeros(32), np.zeros(0), np.zeros(0))
    events = [WatchedEvent(0, RECORDS, False, ()), WatchedEvent(0, STOPS, False, ())]
    block = make_watch_block(events, numbers)
    monitor = EventMonitor(block.tolist())
    monitor.direction, monitor.span, monitor.piece_rows, monitor.happened_room = direction, 3.0, 4, 32
    breaks = np.array([0.0, 1.25, 3.0]) if direction > 0.0 else np.array([3.0, 1.25, 0.0])
    pieces = np.zeros((2, 4, 2))
    pieces[:, 0], pieces[:, 1] = breaks[:-1, np.newaxis], np.diff(breaks)[:, np.newaxis]

    def values(t: Reals, q: Reals, u: Reals, r: Reals, p: Reals, c: Reals, out: Reals, work: Reals) -> int:
        out[0] = (u[0] * u[0] - 2.0) * (u[0] - 0.5) * (u[0] - 0.5)
        out[1] = u[0] - 2.5
        return 0

    happened = Reals.zeros(32 * 4)
    code = event_watch.look(
        values,
        values,
        values,
        monitor,
        Reals(breaks.tolist()),
        Reals(pieces.ravel().tolist()),
        happened,
        2,
        1,
    )
    assert code == ENDS
    found = [(int(happened[4 * k]), happened[4 * k + 1]) for k in range(monitor.happened)]
    if direction > 0.0:
        assert [place for place, _ in found] == [0, 0, 1]
        assert [t for _, t in found] == pytest.approx([0.5, np.sqrt(2.0), 2.5], abs=1e-12)
    else:  # the stop comes first
        assert found == [(1, 2.5)]
    recording, stopping = monitor.events
    assert recording.most > stopping.most


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(0.1), sb.Stiff()])
@pytest.mark.parametrize("direction", [0, 1])
def test_an_action_that_resets_its_own_value_is_no_chattering(integrator: object, direction: int) -> None:
    """A value that an action moves off zero counts from there on: a ramp that begins again at its top."""
    parts = [sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive(applied=1))]
    eqs = sb.form_equations(sb.Model("ramp", parts))
    for low, end in ((0.0, 3.5), (0.999, 1.0105), (0.9999, 1.00555)):
        reset = sb.Event("x_dot - 1", direction, {"x_dot": low})
        run = sb.simulate(eqs, end, events=reset, integrator=integrator)
        assert run.success
        times = 1 + (1 - low) * np.arange(1 + int((end - 1) / (1 - low)))
        np.testing.assert_allclose([event.t for event in run.events], times, atol=1e-8)


@pytest.mark.parametrize("end", [0.1, 0.3, 0.7, 1.3])
@pytest.mark.parametrize("integrator", [None, sb.FixedStep(0.01), sb.Stiff()])
def test_a_motion_may_end_at_an_event_that_acts(end: float, integrator: object) -> None:
    """What is left of the motion behind the event is less than rounding of its times."""
    parts = [sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive(applied=1))]
    eqs = sb.form_equations(sb.Model("ramp", parts))
    kick = sb.Event(f"x_dot - {end}", action={"x_dot": 5})
    run = sb.simulate(eqs, end, events=kick, integrator=integrator)
    assert run.success and run.t[-1] == end


@pytest.mark.parametrize("integrator", [None, sb.FixedStep(1e-3)])
def test_many_zeros_within_the_moment_of_a_late_time_all_wait(integrator: object) -> None:
    """At 1e9 s a moment is a millisecond long: it holds more zeros than may wait."""
    begin, length, rate = 1e9, 0.02, 1e5
    watched = [sb.Event(f"{function}({rate}*y)", name=function) for function in ("sin", "cos")]
    given = {"initial": {"y_dot": 1}, "integrator": integrator, "events": watched}
    run = sb.simulate(at_rest(), (begin, begin + length), **given)
    assert run.status is sb.Status.SUCCESS
    count = int(rate * length / np.pi)
    assert abs(len(times_of(run, "sin")) - count) <= 1
    assert abs(len(times_of(run, "cos")) - count) <= 1
