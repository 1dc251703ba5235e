"""Slices, interruption, progress and memory of a run."""

from __future__ import annotations

import numpy as np
import pytest

from symbody.errors import SimulationError
from symbody.simulation.methods.explicit import RawRun
from symbody.simulation.native import run as native_run
from symbody.simulation.status import Status
from tests.simulation.interruption import ctrl_c
from tests.simulation.right_hand_sides import pendulum, run


def long_run(**options: object) -> RawRun:
    """Ends by itself only after 1e8 steps, about a minute, and then not with INTERRUPTED."""
    settings = {"times": [0.0, 1.0, 1e9], "dense": False, "max_steps": 10**8, **options}
    return run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1e9), **settings)


def test_ctrl_c_ends_a_run_and_keeps_what_there_is() -> None:
    with ctrl_c() as press:
        result = long_run(progress=press)
    assert result.status is Status.INTERRUPTED
    assert result.t.tolist() == [0.0, 1.0]
    assert 1.0 < result.reached < 1e9
    # slices of a twentieth of a second: the interruption is seen within a few of them
    assert result.statistics.loop_seconds < 2.0


def test_progress_rises_and_can_end_the_run() -> None:
    shares: list[float] = []

    def watch(share: float) -> bool:
        shares.append(share)
        return len(shares) < 8

    result = long_run(progress=watch)
    assert result.status is Status.INTERRUPTED
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(result.reached / 1e9, rel=1e-12)


def test_an_error_in_progress_is_not_swallowed() -> None:
    def fail(share: float) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        long_run(progress=fail)


def test_storage_grows_beyond_its_first_size() -> None:
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 2000.0))
    assert result.t.size > 8 * native_run.FIRST_CAPACITY
    assert result.dense_output is not None
    # the samples at the ends of the steps are the polynomials' beginnings, through every growth
    np.testing.assert_array_equal(result.dense_output.pieces[:, 0].T, result.x[:, :-1])
    np.testing.assert_array_equal(result.dense_output.breaks, result.t)


def test_a_run_stops_before_it_fills_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native_run, "memory_limit", lambda: 500_000)
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1e6))
    assert result.status is Status.OUT_OF_MEMORY
    assert result.t.size == result.statistics.accepted + 1 > native_run.FIRST_CAPACITY


def test_too_many_times_are_refused_before_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native_run, "memory_limit", lambda: 24_000)
    assert run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0), times=np.linspace(0, 1, 1000)).t.size == 1000
    with pytest.raises(
        SimulationError, match="1001 samples of 2 states take 2.4e-05 GB.*\n.*at most 1000 times"
    ):
        run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0), times=np.linspace(0, 1, 1001))


def test_the_memory_limit_is_half_of_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 2**28 < native_run.memory_limit() < 2**50
    monkeypatch.setattr(native_run, "memory_size", lambda: None)  # where no system tells it
    assert native_run.memory_limit() == native_run.ASSUMED_MEMORY // 2
