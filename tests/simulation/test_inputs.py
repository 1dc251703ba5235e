"""Inputs as tables and functions, against the same laws as formulas."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

import symbody as sb
from symbody.errors import SimulationError, UsageError
from symbody.simulation.inputs.tables import MOST_IN_FORMULAS
from tests.mechanisms import cart
from tests.simulation.interruption import ctrl_c
from tests.tiers import cases

Floats = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def slider_crank() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))


@pytest.mark.parametrize(
    "count", cases([2, 3, 4, 17, MOST_IN_FORMULAS, MOST_IN_FORMULAS + 1], fast=[2, 3, MOST_IN_FORMULAS + 1])
)
@pytest.mark.parametrize("kind", ["linear", "pchip", "cubic"])
def test_tables_go_through_their_points_and_are_held_beyond(count: int, kind: str) -> None:
    times = np.linspace(0.5, 2.5, count) ** 1.5
    values = np.cos(3 * times)
    wanted = np.linspace(0.0, 5.0, 101)
    run = sb.simulate(cart(), 5.0, times=wanted, inputs={"F": sb.Table(times, values, kind)})
    held = np.clip(wanted, times[0], times[-1])
    curves = {"pchip": PchipInterpolator, "cubic": CubicSpline}
    exact = np.interp(held, times, values) if kind == "linear" else curves[kind](times, values)(held)
    np.testing.assert_allclose(run["F"], exact, rtol=0, atol=1e-13)
    np.testing.assert_allclose(run["x_ddot"], exact, rtol=0, atol=1e-13)
    assert not any("slow" in note for note in run.notes)


def test_a_polygon_is_integrated_to_tolerance() -> None:
    times, values = [0.0, 1.0, 2.0, 4.0], [0.0, 2.0, -1.0, 3.0]
    run = sb.simulate(cart(), 4.0, inputs={"F": (times, values)})
    # the area under the polygon; kinks cost steps, not accuracy: 1e-8 a step
    assert run["x_dot"][-1] == pytest.approx(1.0 + 0.5 + 2.0, abs=1e-8 * run.statistics.accepted * 4)


def test_a_function_moves_a_loop_as_its_formula_does() -> None:
    law = {"F": "3*sin(2*t) - s_dot"}
    times = np.linspace(0.0, 3.0, 301)
    formula = sb.simulate(slider_crank(), 3.0, inputs=law, times=times)
    speeds, seen = slider_crank().speed_names, []

    def asked(t: float, q: Floats, u: Floats) -> float:
        seen.append((q.shape, u.shape))
        return float(3 * np.sin(2 * t) - u[speeds.index("s_dot")])

    function = sb.simulate(slider_crank(), 3.0, inputs={"F": asked}, times=times)
    assert set(seen) == {((3,), (3,))}
    # Rounding of sin is all that differs, but error estimates are mostly rounding too, so steps end up to
    # 1e-9 s apart. At the same times 80 steps add up 1e-16 of at most 100 each, in states, and accelerations
    # make a hundred times that of it.
    assert abs(function.statistics.accepted - formula.statistics.accepted) <= 1
    for name in ("theta", "F", "effort D", "reaction A", "energy"):
        np.testing.assert_allclose(function[name], formula[name], rtol=0, atol=1e-10)
    assert function.energy_drift == pytest.approx(formula.energy_drift, abs=1e-10)
    assert any("Python function" in note for note in function.notes)


def test_events_see_what_functions_return() -> None:
    run = sb.simulate(cart(), 5.0, inputs={"F": lambda t, q, u: np.cos(t)}, events=sb.Event("F"))
    np.testing.assert_allclose([t for _, t, _ in run.events], np.pi * np.array([0.5, 1.5]), rtol=1e-14)


def test_faults_of_functions_name_the_input_and_the_time() -> None:
    def refused(law: object, words: str) -> None:
        with pytest.raises(SimulationError, match=words) as caught:
            sb.simulate(cart(), 5.0, inputs={"F": law})
        assert caught.value.problems[0].where == "input F"

    def late(t: float, q: Floats, u: Floats) -> float:
        if t > 1.0:
            raise ValueError("too late")
        return 1.0

    refused(late, r"at t = 1\.\d+ s the function raised ValueError: too late")
    refused(lambda t, q, u: [1.0, 2.0], r"returned an array of shape \(2,\)")
    refused(lambda t, q, u: "1", "returned '1'")
    refused(lambda t, q, u: None, "returned None")
    refused(lambda t, q, u: np.nan, "returned nan")
    refused(lambda t: 1.0, "raised TypeError")


def test_a_function_may_change_what_it_is_given() -> None:
    def greedy(t: float, q: Floats, u: Floats) -> float:
        q[:], u[:] = 7.0, 7.0
        return 1.0

    run = sb.simulate(cart(), 2.0, inputs={"F": greedy})
    assert run["x"][-1] == pytest.approx(2.0, rel=1e-12)


def test_faults_of_tables() -> None:
    with pytest.raises(UsageError, match="time 1 is followed by 0.5"):
        sb.Table([0, 1, 0.5], [0, 0, 0])
    with pytest.raises(UsageError, match="time 1 is listed three times"):
        sb.Table([0, 1, 1, 1, 2], [0, 0, 0, 0, 0])
    with pytest.raises(UsageError, match="all points have the time 1"):
        sb.Table([1, 1], [0, 1])
    with pytest.raises(UsageError, match="same length"):
        sb.Table([0, 1], [0, 0, 0])
    with pytest.raises(UsageError, match="not finite"):
        sb.Table([0, 1], [0, np.nan])
    with pytest.raises(UsageError, match="not numbers"):
        sb.Table([0, 1], ["a", 0])
    with pytest.raises(UsageError, match="not a valid choice"):
        sb.Table([0, 1], [0, 1], "quintic")
    short = sb.Table([0, 1], [0, 1], outside="error")
    assert sb.simulate(cart(), 1.0, inputs={"F": short}).success
    with pytest.raises(UsageError, match="table covers 0 to 1 s, the motion 0 to 2 s"):
        sb.simulate(cart(), 2.0, inputs={"F": short})


@pytest.mark.parametrize("asked", [False, True])
def test_ctrl_c_leaves_what_was_computed(asked: bool) -> None:
    law = (lambda t, q, u: float(np.sin(t))) if asked else "sin(t)"
    with ctrl_c() as press:
        run = sb.simulate(
            cart(),
            1e9,
            inputs={"F": law},
            events=sb.Event("x - 5"),
            times=np.linspace(0, 1e9, 11),
            max_steps=10**9,
            progress=press,
        )
    assert run.status is sb.Status.INTERRUPTED and not run.success
    assert "known up to" in run.notes[-1]
    assert run.t.tolist() == [0.0] and run.at(1.0)["x_dot"] == pytest.approx(1 - np.cos(1.0), abs=1e-6)


@pytest.mark.parametrize(
    "law",
    ["sin(t)", 2.0, ((0, 1), (0, 1)), sb.Table(np.arange(300.0), np.zeros(300)), lambda t, q, u: 0.0],
    ids=["formula", "number", "short table", "long table", "function"],
)
def test_a_law_of_an_input_that_is_not_there_is_refused_by_its_name(law: object) -> None:
    with pytest.raises(sb.CompileError) as caught:
        sb.simulate(cart(), 1.0, inputs={"G": law})
    problem = caught.value.problems[0]
    assert (problem.code, problem.where) == ("compile.unknown_input", "G")
    assert "F" in problem.fix
