"""The choices and arguments of an explicit run, and what comes back."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from symbody.errors import UsageError
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.status import Status
from tests.simulation.right_hand_sides import (
    blow_up,
    damped,
    every_group,
    never_finite,
    nothing,
    oscillator,
    pendulum,
    rational,
    run,
    singular,
    walled,
)

ORDERS = (5, 8)
Floats = NDArray[np.float64]


def circle(t: Any) -> Floats:
    """States of `oscillator` from (0, 1)."""
    return np.array([-np.sin(t), np.cos(t)])


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"order": 4}, "simulation.order"),
        ({"max_step": 0.0}, "simulation.max_step"),
        ({"max_step": math.nan}, "simulation.max_step"),
        ({"first_step": -1.0}, "simulation.first_step"),
    ],
)
def test_a_method_that_does_not_exist_is_refused(options: dict[str, Any], code: str) -> None:
    with pytest.raises(UsageError) as caught:
        Explicit(**options)
    (problem,) = caught.value.problems
    assert problem.code == code
    assert problem.fix


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"x0": [1.0]}, r"shape \(1,\), not \(2,\)"),
        ({"x0": [1.0, math.nan]}, "not finite: state 1"),
        ({"span": (0.0, math.inf)}, "from 0.0 to inf"),
        ({"rtol": -1.0}, "rtol = -1.0 cannot be achieved"),
        ({"rtol": 1e-17}, "rtol = 1e-17 cannot be achieved"),
        ({"rtol": math.nan}, "rtol = nan"),
        ({"atol": 0.0}, "atol = 0.0 is not positive"),
        ({"atol": [1e-8] * 3}, r"atol has shape \(3,\)"),
        ({"times": [0.0, 2.0, 1.0]}, "do not increase"),
        ({"times": [0.0, 0.0, 1.0]}, "do not increase"),
        ({"times": [0.0, 1.0], "span": (1.0, 0.0)}, "do not decrease"),
        ({"times": [0.0, 5.0]}, "lie outside the motion's span 0 to 1"),
        ({"times": [-1.0, 0.5]}, "lie outside the motion's span 0 to 1"),
        ({"times": [0.0, math.nan]}, "not a list of finite numbers"),
        ({"times": [[0.0], [1.0]]}, "not a list of finite numbers"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(arguments: dict[str, Any], words: str) -> None:
    usual: dict[str, Any] = {"x0": [0.0, 1.0], "span": (0.0, 1.0)}
    with pytest.raises(UsageError, match=words) as caught:
        run(oscillator, 1, 1, **{**usual, **arguments})
    assert all(problem.fix for problem in caught.value.problems)


def test_each_group_arrives_at_its_place() -> None:
    groups = {"inputs": (1.0, 2.0), "parameters": (3.0,), "constants": (4.0,)}
    result = run(every_group, 2, 1, [0.3, 0.2, 0.1], (1.0, 3.0), **groups)

    def same(t: float, x: Floats) -> list[float]:
        return [1.0 + 2.0 * 2.0 + 3.0 * 3.0 + 5.0 * 4.0, 7.0 * t - x[2], x[0] + 0.1 * x[1]]

    theirs = solve_ivp(same, (1.0, 3.0), [0.3, 0.2, 0.1], method="DOP853", rtol=1e-12, atol=1e-12)
    # a linear system without fast growth: some tens of local errors of 1e-8
    np.testing.assert_allclose(result.x[:, -1], theirs.y[:, -1], rtol=1e-6)


@pytest.mark.parametrize("order", ORDERS)
def test_the_error_is_proportional_to_the_tolerance(order: int) -> None:
    tolerances = 10.0 ** -np.arange(4, 12)
    ends = [
        run(oscillator, 1, 1, circle(0.0), (0.0, 10.0), order, rtol=e, atol=e).x[:, -1] for e in tolerances
    ]
    errors = np.linalg.norm(np.array(ends) - circle(10.0), axis=1)
    # over 10 s the local errors of some tens of steps add up; neither far more nor far less than asked
    assert (errors < 30.0 * tolerances).all()
    assert (errors > 0.001 * tolerances).all()
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("order", "name"), [(5, "RK45"), (8, "DOP853")])
def test_steps_and_states_are_scipys(order: int, name: str) -> None:
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 20.0), order, rtol=1e-9, atol=1e-9)
    theirs = solve_ivp(
        lambda t, x: [-math.sin(x[1]), x[0]], (0.0, 20.0), [0.0, 2.0], method=name, rtol=1e-9, atol=1e-9
    )
    # both err by some tolerances, which a pendulum lets grow linearly with time
    np.testing.assert_allclose(result.x[:, -1], theirs.y[:, -1], rtol=0.0, atol=20.0 * 20.0 * 1e-9)
    # the same estimate and nearly the same control: as many steps within a tenth
    assert result.t.size == pytest.approx(theirs.t.size, rel=0.1)


@pytest.mark.parametrize("order", ORDERS)
def test_samples_are_exactly_the_times_asked_for(order: int) -> None:
    times = np.array([0.0, 0.1, 1.0 / 3.0, 2.0, 2.0 + 1e-12, 9.99, 10.0])
    result = run(oscillator, 1, 1, circle(0.0), (0.0, 10.0), order, times=times)
    assert result.t.tolist() == times.tolist()
    assert result.x.shape == (2, 7)
    assert result.status is Status.SUCCESS
    np.testing.assert_allclose(result.x, circle(times), rtol=0.0, atol=30.0 * 1e-8)
    dense = result.dense_output
    assert dense is not None
    # the loop's interpolation and NumPy's are the same operations; ends of steps are stored, not formed
    np.testing.assert_array_equal(result.x[:, 1:-1], dense(times)[:, 1:-1])
    assert result.x[:, 0].tolist() == circle(0.0).tolist()


@pytest.mark.parametrize("order", ORDERS)
def test_times_do_not_change_the_motion(order: int) -> None:
    every = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 10.0), order)
    some = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 10.0), order, times=[0.0, 1.0, 10.0], dense=False)
    assert some.x[:, -1].tolist() == every.x[:, -1].tolist()
    assert some.dense_output is None
    assert some.statistics.accepted == every.statistics.accepted == every.t.size - 1


def test_a_run_without_wanted_times_stores_nothing() -> None:
    result = run(oscillator, 1, 1, circle(0.0), (0.0, 1.0), times=[])
    assert (result.t.shape, result.x.shape, result.status) == ((0,), (2, 0), Status.SUCCESS)


@pytest.mark.parametrize("order", ORDERS)
def test_time_runs_backwards(order: int) -> None:
    result = run(oscillator, 1, 1, circle(3.0), (3.0, -2.0), order)
    assert (np.diff(result.t) < 0.0).all()
    np.testing.assert_allclose(result.x, circle(result.t), rtol=0.0, atol=30.0 * 1e-8)
    times = [3.0, 1.5, -2.0]
    chosen = run(oscillator, 1, 1, circle(3.0), (3.0, -2.0), order, times=times)
    assert chosen.t.tolist() == times
    dense = result.dense_output
    assert dense is not None
    np.testing.assert_allclose(dense([2.9, -1.9]), circle(np.array([2.9, -1.9])), rtol=0.0, atol=30.0 * 1e-8)


def test_no_time_at_all_is_one_sample() -> None:
    result = run(oscillator, 1, 1, [1.0, 2.0], (4.0, 4.0))
    assert result.t.tolist() == [4.0]
    assert result.x.tolist() == [[1.0], [2.0]]
    assert (result.status, result.statistics.evaluations) == (Status.SUCCESS, 0)
    dense = result.dense_output
    assert dense is not None
    assert dense(4.0).tolist() == [1.0, 2.0]


def test_a_mechanism_without_freedom_runs_along_the_times() -> None:
    result = run(nothing, 0, 0, [], (0.0, 10.0), times=[0.0, 5.0, 10.0])
    assert (result.t.tolist(), result.x.shape, result.status) == ([0.0, 5.0, 10.0], (0, 3), Status.SUCCESS)


@pytest.mark.parametrize("order", ORDERS)
def test_a_motion_to_infinity_ends_with_a_collapse(order: int) -> None:
    result = run(blow_up, 1, 1, [0.0, 1.0], (0.0, 2.0), order)
    assert result.status is Status.STEP_COLLAPSE
    assert result.stop_note(("v", "q")).endswith("there q changes too fast")
    # q = 1 / (1 - t): local errors of 1e-8 q shift the pole by about that much
    assert result.reached == pytest.approx(1.0, abs=1e-6)
    early = result.t < 0.9
    np.testing.assert_allclose(result.x[1, early], 1.0 / (1.0 - result.t[early]), rtol=1e-6)


def test_a_derivative_that_stops_being_finite_ends_the_run_there() -> None:
    result = run(walled, 1, 1, [0.0, 1.0], (0.0, 2.0))
    assert (result.status, result.state) == (Status.NOT_FINITE, 1)
    assert result.reached == pytest.approx(0.5, abs=1e-12)
    assert result.stop_note(("v", "q")).endswith("up to t = 0.5 s; there q has no finite derivative")
    np.testing.assert_allclose(result.x[1], 1.0 - result.t, rtol=0.0, atol=1e-14)


def test_a_derivative_that_is_never_finite_leaves_the_first_sample() -> None:
    result = run(never_finite, 1, 1, [3.0, 4.0], (0.0, 1.0))
    assert (result.status, result.state, result.reached) == (Status.NOT_FINITE, 1, 0.0)
    assert result.x.tolist() == [[3.0], [4.0]]


def test_a_kernel_that_fails_is_named() -> None:
    result = run(singular, 1, 1, [0.0, 0.0], (0.0, 2.0))
    assert (result.status, result.kernel, result.state) == (Status.SINGULAR, 2, None)
    assert result.reached == pytest.approx(1.0, abs=1e-12)
    assert "linear system 3 of the accelerations is singular" in result.stop_note(("v", "q"))


def test_the_number_of_steps_is_bounded_and_the_start_is_kept() -> None:
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1e6), max_steps=100)
    assert result.status is Status.TOO_MANY_STEPS
    assert result.statistics.accepted + result.statistics.rejected == 100
    assert result.t.size == result.statistics.accepted + 1
    assert result.reached == result.t[-1]
    assert result.stop_note(("v", "q")) == f"the motion is known up to t = {result.reached:.9g} s"


@pytest.mark.parametrize("order", ORDERS)
def test_steps_limited_by_stability_are_found(order: int) -> None:
    options = {"rtol": 1e-4, "atol": 1e-4, "stop_when_stiff": True}
    result = run(damped, 1, 0, [1.0], (0.0, 10.0), order, **options)
    assert result.status is Status.STIFF
    assert result.statistics.accepted < 2100
    assert run(pendulum, 1, 1, [0.0, 2.0], (0.0, 2e3), order, **options).status is Status.SUCCESS


def test_no_step_is_longer_than_allowed() -> None:
    result = run(rational, 1, 0, [1.0], (0.0, 5.0), method=Explicit(max_step=0.3), rtol=1e-2, atol=1e-2)
    assert np.diff(result.t).max() <= 0.3 * (1.0 + 1e-9)
    assert result.t[-1] == 5.0
    assert result.stop_note(("v",)) == ""


def test_runs_in_threads_do_not_disturb_each_other() -> None:
    def end(speed: float) -> list[float]:
        return [float(value) for value in run(pendulum, 1, 1, [speed, 0.0], (0.0, 200.0)).x[:, -1]]

    speeds = [0.1 * k for k in range(1, 17)]
    with ThreadPoolExecutor(4) as executor:
        assert list(executor.map(end, speeds)) == [end(speed) for speed in speeds]
