"""States of signals are computed to digits of their own size, which follows from what goes into them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.tolerances import CLOSED

LAG = 0.1
RATE = 2.0  # sqrt(stiffness/mass), 1/s


def bench(*signals: Any, **parameters: float) -> sb.EquationSet:
    """A mass of 1 kg on a spring of free length L, with signals."""
    drive = sb.Drive(stiffness=RATE**2, free="L")
    cart = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=drive)
    return sb.form_equations(
        sb.Model("bench", [cart, *signals], parameters={"L": 1.0, **parameters}, inputs=["r"])
    )


def sizes(eqs: sb.EquationSet, length: float = 1.0, time: float = 1.0) -> dict[str, float]:
    scales = mechanism_scales(eqs, {"L": length}, {"time": time})
    tolerances = scales.tolerances(eqs, np.zeros(len(eqs.state_names)))
    return dict(zip(eqs.state_names, (tolerances / CLOSED).tolist(), strict=True))


@pytest.fixture(scope="module")
def filtered() -> sb.EquationSet:
    return bench(
        sb.Delay("d", "x", "T", order=4), sb.FirstOrder("f", "x", LAG),
        sb.PID("c", "L - x", {"p": 2, "i": 3, "d": 1, "filter": 0.01}, limits=("-4*L", "4*L")), T=0.05,
    )  # fmt: skip


def motion(eqs: sb.EquationSet, length: float) -> sb.Trajectory:
    return sb.simulate(
        eqs, 3, {"x": 1.5 * length}, parameters={"L": length}, times=np.linspace(0, 3, 31), inputs={"r": 0}
    )


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_a_signal_has_the_same_digits_in_any_unit(filtered: sb.EquationSet, length: float) -> None:
    """x = L + L/2 cos(w t) through ``LAG f' = x - f``, f(0) = 0, solved in closed form."""
    run = motion(filtered, length)
    wave = (np.cos(RATE * run.t) + LAG * RATE * np.sin(RATE * run.t)) / (1 + (LAG * RATE) ** 2) / 2
    expected = 1 + wave - (1 + wave[0]) * np.exp(-run.t / LAG)
    # simulate's rtol of 1e-8 and absolute tolerance of 1e-10 of L hold for each of some hundred steps
    np.testing.assert_allclose(run["f"] / length, expected, rtol=0, atol=100 * (1e-8 * 1.5 + CLOSED))
    one = motion(filtered, 1.0)
    for name in filtered.signal_state_names:
        np.testing.assert_allclose(run[name] / length, one[name], rtol=0, atol=2e-6)
    steps = run.statistics.accepted / one.statistics.accepted
    assert 0.9 < steps < 1.1


@pytest.mark.parametrize("length", [2.0**-20, 2.0**20])
def test_powers_of_two_change_no_bit(filtered: sb.EquationSet, length: float) -> None:
    run, one = motion(filtered, length), motion(filtered, 1.0)
    for name in filtered.state_names:
        np.testing.assert_array_equal(run[name] / length, one[name])


@pytest.mark.parametrize("length", [1.0, 1e-6, 1e6])
def test_a_sweep_has_the_tolerances_of_simulate(filtered: sb.EquationSet, length: float) -> None:
    table = sb.sweep(
        filtered, 3, {"L": [length, 2 * length]}, initial={"x": 1.5 * length}, times=np.linspace(0, 3, 31),
        inputs={"r": 0},
    )  # fmt: skip
    run = motion(filtered, length)
    for name in filtered.signal_state_names:
        np.testing.assert_allclose(table[name][0], run[name], rtol=0, atol=2e-6 * length)


def test_sizes_follow_from_rates() -> None:
    """Responses at ``s = 1/T + i w`` of T = 1: a lag of 1/c has 1/(1 + c), an integrator 1; in powers of 2."""
    eqs = bench(
        sb.Signal("integral", rate="3*x"), sb.FirstOrder("lag", "1e6*x", "1/7"),
        sb.FirstOrder("of_speed", "x_dot", "1/7"), sb.Signal("force", output="effort j"),
        sb.FirstOrder("of_force", "force", "1/7"), sb.FirstOrder("of_wave", "1000*sin(t)", "1/7"),
        sb.RateLimit("limited", "x", 1e9, time="1/7"), sb.Signal("oscillator", rate="7*other"),
        sb.Signal("other", rate="x - 7*oscillator"),
    )  # fmt: skip
    found = sizes(eqs)
    assert found["integral"] == 4  # 3 through 1/|1 + i/8|, upwards
    assert found["lag"] == 2.0**20  # 7e6/8
    assert found["of_speed"] == found["of_force"] == found["limited"] == 1
    assert found["of_wave"] == 1024
    # 7/|s^2 + 49|, s = 1 + i w: near w = 7, 7/|s - 7i| |s + 7i| is 1/2; of a grid of octaves 8 is the nearest
    assert 0.25 <= found["oscillator"] <= 0.5
    assert sizes(eqs, 8.0)["lag"] == 8 * found["lag"]
    assert sizes(eqs, time=2.0**-10)["of_speed"] == 2.0**10 * 2.0**-7  # 1024 m/s in 7/(7 + 1024)


@pytest.mark.parametrize("rate", ["r", "x - y^2", "x*y", "exp(x)", "if(x < 0, y, -2*y)", "x/0", "y + y_2"])
def test_what_decides_no_size_leaves_the_first_value(rate: str) -> None:
    """An input, what is not linear in states, and what reads such a state; "x/0" is no number at all."""
    if rate == "x/0":
        rate = "x/zero"
    eqs = bench(sb.Signal("y", rate=rate), sb.Signal("y_2", rate="r - y_2"), zero=0.0)
    scales = mechanism_scales(eqs, {}, {"time": 1.0})
    for first, size in ((0.0, 1.0), (-5.0, 5.0)):
        x = np.zeros(len(eqs.state_names))
        x[list(eqs.state_names).index("y")] = first
        y = scales.tolerances(eqs, x)[list(eqs.state_names).index("y")]
        assert y == pytest.approx(CLOSED * size)


def test_a_reference_is_taken_as_large_as_what_is_compared_with_it() -> None:
    eqs = bench(sb.FirstOrder("y", "r - x", "1/7"))
    assert sizes(eqs, 2.0**-20)["y"] == 2.0**-20


def test_a_large_first_value_is_resolved_to_its_rounding() -> None:
    eqs = bench(sb.FirstOrder("y", "x", "1/7"))
    x = np.zeros(len(eqs.state_names))
    x[-1] = 1e9
    assert mechanism_scales(eqs, {}, {"time": 1.0}).tolerances(eqs, x)[-1] == CLOSED * 1e5


def test_a_chosen_size_is_taken() -> None:
    eqs = bench(sb.FirstOrder("y", "x", "1/7"))
    scales = mechanism_scales(eqs, {}, {"y": 3.0})
    assert scales.tolerances(eqs, np.zeros(len(eqs.state_names)))[-1] == CLOSED * 3.0
