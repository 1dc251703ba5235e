"""Tables of any length in the compiled loop: the same values as points between two of them, no Python."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb
from symbody.kernels import tables as kernel
from symbody.kernels.language import Reals
from symbody.simulation.inputs.input_laws import CallbackFunction

Floats = NDArray[np.float64]


@cache
def quarter_car() -> sb.EquationSet:
    """A wheel on a spring under a body, pushed by an input."""
    parts = [
        sb.Body("B", mass=1),
        sb.Prismatic("j", "ground", "B", coordinate="x", force=sb.Drive("k*(F - x)")),
    ]
    return sb.form_equations(sb.Model("car", parts, parameters={"k": 40.0}, inputs=["F"]))


def rough_table(points: int, kind: str, seed: int = 3) -> sb.Table:
    times = np.sort(np.random.default_rng(seed).uniform(0.0, 2.0, points))
    values = np.sin(7.0 * times) + 0.2 * np.random.default_rng(seed + 1).standard_normal(points)
    return sb.Table(times, values, kind)


@pytest.mark.parametrize("kind", ["linear", "pchip", "cubic"])
def test_the_kernel_reads_what_the_table_gives(kind: str) -> None:
    table = sb.Table([0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 5.0, 5.0], [9.0, 1.0, 3.0, 2.0, 5.0, 4.0, 6.0, 7.0], kind)
    numbers = Reals(table.numbers().tolist())
    times = np.random.default_rng(1).uniform(-1.0, 6.0, 200)
    for t in (*times, 0.0, 1.0, 2.0, np.nextafter(2.0, 0.0), 5.0, 5.5, -1.0, 3.0):
        assert kernel.read_table(numbers, float(t)) == float(table.at(np.array([t]))[0])


def test_python_is_not_called(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CallbackFunction, "__init__", None)
    table = rough_table(500, "linear")
    run = sb.simulate(quarter_car(), 2.0, inputs={"F": table}, events=sb.Event("x - F", name="met"))
    assert run.success and len(run.events) > 10
    for event in run.events[:20]:
        assert event.state["x"] == pytest.approx(float(table.at(np.array([event.t]))[0]), abs=1e-9)


@pytest.mark.parametrize("kind", ["linear", "pchip", "cubic"])
def test_a_long_table_against_pieces_integrated_one_by_one(kind: str) -> None:
    table = rough_table(150, kind)
    run = sb.simulate(quarter_car(), 2.0, inputs={"F": table}, times=[2.0], rtol=1e-12, atol=1e-13)
    f = sb.compile(quarter_car(), "xdot")
    x = np.zeros(2)
    ends = [0.0, *np.asarray(table.t), 2.0]
    for start, end in zip(ends[:-1], ends[1:], strict=True):

        def slope(t: float, y: Floats, end: float = end) -> Floats:
            return np.asarray(f.of_state(t, y, table.at(np.array([min(t, end)]))))

        x = solve_ivp(slope, (start, end), x, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    # speeds of 35 m/s, to 1e-11 in each of 150 pieces by the other integrator
    np.testing.assert_allclose([run["x_dot"][-1], run["x"][-1]], x, rtol=0, atol=1e-7)


@pytest.mark.parametrize("lanes", [False, True])
def test_sweeps_read_tables_in_their_loop(lanes: bool) -> None:
    table = rough_table(200, "linear")
    options = {"inputs": {"F": table}, "times": np.linspace(0.0, 2.0, 5), "rtol": 1e-11}
    sweep = sb.sweep(quarter_car(), 2.0, {"k": np.linspace(20.0, 60.0, 19)}, lanes=lanes, **options)
    assert not any("simulate" in note for note in sweep.notes)
    for k in (0, 7, 18):
        k_value = float(sweep.cases["k"][k])
        run = sb.simulate(quarter_car(), 2.0, parameters={"k": k_value}, **options)
        # the work, one state more in `simulate`, changes the steps, and kinks in them cost most
        np.testing.assert_allclose(sweep.trajectory(k).q, run.q, rtol=0, atol=1e-6)


@pytest.mark.parametrize("held", [[], ["G"]])
def test_steppers_read_tables_in_their_loop(held: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CallbackFunction, "__init__", None)
    parts = [
        sb.Body("B", mass=1),
        sb.Prismatic("j", "ground", "B", coordinate="x", force=sb.Drive("40*(F + G - x)")),
    ]
    eqs = sb.form_equations(sb.Model("pushed car", parts, inputs=["G", "F"]))
    table = rough_table(200, "cubic")
    laws = {"F": table} | ({} if held else {"G": 0.25})
    stepper = sb.Stepper(eqs, 0.01, inputs=laws, rtol=1e-10)
    for _ in range(100):
        stepper.step(**dict.fromkeys(held, 0.25))
    run = sb.simulate(eqs, 1.0, inputs={"F": table, "G": 0.25}, times=[1.0], rtol=1e-10)
    assert stepper["x"] == pytest.approx(float(run["x"][-1]), abs=1e-6)
    assert stepper["F"] == pytest.approx(float(table.at(np.array([1.0]))[0]), abs=1e-12)
