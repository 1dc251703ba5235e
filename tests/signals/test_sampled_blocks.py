"""Sampled blocks against python-control and SciPy, and their messages."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import dlsim

import symbody as sb
from symbody.model.element import Element
from tests.faults.refusals import refused

DT = 0.05
TIMES = DT * np.arange(41)
WAVE = np.sin(3 * TIMES) + TIMES**2


def answer(block: Element, output: str = "y", *, moves: bool = True) -> np.ndarray:
    """The samples of a block that reads a wave, on a cart that it pushes or leaves alone."""
    force = sb.Drive(applied=output if moves else 0)
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x", force=force)
    model = sb.Model("bench", [cart, sb.Signal("w", "sin(3*t) + t^2"), block])
    run = sb.simulate(sb.form_equations(model), float(TIMES[-1]), times=TIMES)
    return np.asarray(run[output])


@pytest.mark.parametrize(
    ("numerator", "denominator"),
    [([2], [1]), ([1], [1, -0.5]), ([0.2, 0.1], [1, -1.2, 0.5]), ([1, 2, 3], [2, -0.4, 0.3]), ([1], [1, 0, 0])],
)  # fmt: skip
@pytest.mark.parametrize("moves", [True, False])
def test_a_sampled_transfer_function_is_one_in_z(
    numerator: list[float], denominator: list[float], moves: bool
) -> None:
    control = pytest.importorskip("control")
    found = answer(sb.TransferFunction("y", "w", numerator, denominator, sample=DT), moves=moves)
    _, wanted = control.forced_response(control.tf(numerator, denominator, DT), TIMES, WAVE)
    np.testing.assert_allclose(found, np.ravel(wanted), atol=1e-10, rtol=1e-12)
    np.testing.assert_allclose(
        found, dlsim((numerator, denominator, DT), WAVE)[1][:, 0], atol=1e-10, rtol=1e-12
    )


def test_a_sampled_state_space_is_a_difference_equation() -> None:
    A, B, C, D = [[0.9, 0.2], [-0.1, 0.7]], [[0.3], [0.5]], [[1, -2]], [[0.4]]
    found = answer(sb.StateSpace("y", ["w"], A, B, C, D, initial=[1, -1], sample=DT))
    wanted = dlsim((A, B, C, D, DT), WAVE, x0=[1, -1])[1][:, 0]
    np.testing.assert_allclose(found, wanted, atol=1e-10, rtol=1e-12)


def test_a_sampled_delay_is_exact() -> None:
    found = answer(sb.Delay("y", "w", 3 * DT, sample=DT))
    np.testing.assert_array_equal(found[:3], 0.0)
    np.testing.assert_allclose(found[3:], WAVE[:-3], atol=1e-14)
    np.testing.assert_allclose(answer(sb.Delay("y", "w", 0, sample=DT)), WAVE, atol=1e-14)


def test_a_sampled_pid_is_the_sum_of_its_transfer_functions() -> None:
    p, i, d, T = 2.0, 3.0, 0.5, 0.1
    found = answer(sb.PID("y", "w", {"p": p, "i": i, "d": d, "filter": T}, sample=DT))
    integral = dlsim(([i * DT], [1, -1], DT), WAVE)[1][:, 0]
    derivative = dlsim(([d, -d], [T + DT, -T], DT), WAVE)[1][:, 0]
    np.testing.assert_allclose(found, p * WAVE + integral + derivative, atol=1e-10, rtol=1e-12)


def test_a_sampled_rate_limit_takes_steps() -> None:
    found = answer(sb.RateLimit("y", "if(t < 1, 1, -1)", 1, fall=4, sample=DT))
    wanted, y = [], 0.0
    for t in TIMES:
        y += min(DT, max(-4 * DT, (1.0 if t < 1 else -1.0) - y))
        wanted.append(y)
    np.testing.assert_allclose(found, wanted, atol=1e-13)


def test_hysteresis_switches_beyond_its_thresholds() -> None:
    found = answer(sb.Hysteresis("y", "sin(6*t)", -0.5, 0.5, DT, low=-2, high=3, initial=-2))
    wanted, y = [], -2.0
    for t in TIMES:
        y = 3.0 if np.sin(6 * t) > 0.5 else -2.0 if np.sin(6 * t) < -0.5 else y
        wanted.append(y)
    np.testing.assert_array_equal(found, wanted)
    assert len(set(wanted)) == 2


def test_a_held_value_is_a_zero_order_hold() -> None:
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x")
    eqs = sb.form_equations(sb.Model("bench", [cart, sb.Signal("w", "t^2", sample=0.1)]))
    run = sb.simulate(eqs, 0.35, times=[0.0, 0.05, 0.1, 0.19, 0.3, 0.35])
    np.testing.assert_allclose(run["w"], [0.0, 0.0, 0.01, 0.01, 0.09, 0.09], atol=1e-15)
    assert run.at(0.25)["w"] == pytest.approx(0.04)
    assert run.at(0.25)["10*w + x"] == pytest.approx(0.4)


def test_tustin_leads_back_to_the_continuous_filter() -> None:
    control = pytest.importorskip("control")
    digital = control.sample_system(control.tf([1, 2], [1, 3, 4]), 0.1, "tustin")
    numerator, denominator = digital.num[0][0].tolist(), digital.den[0][0].tolist()
    block = sb.TransferFunction("y", "w", numerator, denominator, sample=0.1)
    model = sb.Model("filter", [sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x"),
                                sb.Signal("w", "sin(t)"), block])  # fmt: skip
    plain = sb.without_sampling(model)
    run = sb.simulate(sb.form_equations(plain), 3.0, times=np.linspace(0, 3, 31), rtol=1e-12, atol=1e-13)
    _, wanted = control.forced_response(control.tf([1, 2], [1, 3, 4]), np.linspace(0, 3, 3001),
                                        np.sin(np.linspace(0, 3, 3001)))  # fmt: skip
    np.testing.assert_allclose(run["y"], wanted[::100], atol=1e-6)


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: sb.Signal("z", "t", sample=0), "signal.sample", "seconds"),
        (lambda: sb.Signal("z", "t", sample=-0.1), "signal.sample", "is -0.1"),
        (lambda: sb.Signal("z", rate="1", sample=0.1), "signal.sampled_rate", "z + 0.1*(1)"),
        (lambda: sb.PID("z", "t", {"p": 1}, sample=0), "signal.sample", "block z"),
        (lambda: sb.Delay("z", "t", 0.015, sample=0.01), "block.delay_samples", "multiple"),
        (lambda: sb.Delay("z", "t", "T", sample=0.01), "block.delay_samples", "as numbers"),
        (lambda: sb.Delay("z", "t", 50, sample=0.01), "block.delay_samples", "1000 at most"),
        (lambda: sb.RateLimit("z", "t", 1), "block.time", "sample"),
        (lambda: sb.RateLimit("z", "t", 1, 0.1, sample=0.1), "block.time", "remove time"),
        (lambda: sb.Hysteresis("z", "t", 1, -1, 0.1), "block.thresholds", "swap"),
    ],
)  # fmt: skip
def test_wrong_samples_are_refused(make, code: str, words: str) -> None:  # type: ignore[no-untyped-def]
    assert [found for found, _ in refused(make, words=words)] == [code]


def test_a_derivative_without_a_filter_is_a_plain_quotient() -> None:
    """No term times 0, no 0 added, in what people read."""
    block = sb.PID("servo", "x", gains={"d": "D"}, sample=0.01)
    part = {each.name: each.value for each in block.signals}["servo_derivative"]
    assert str(part) == "D*(x - servo_error)/0.01"
