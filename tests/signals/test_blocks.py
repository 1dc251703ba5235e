"""Blocks: what they expand into, their answers, and their messages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats.python_script import model_to_script
from symbody.model.element import Element
from tests.faults.refusals import refused
from tests.signals.arm import arm

TIMES = np.linspace(0.0, 5.0, 51)


def answer(block: Element, output: str, force: str = "1") -> np.ndarray:
    """The answer of a block to a signal u from rest, on a cart that nothing moves."""
    cart = sb.Prismatic("slide", "ground", sb.Body("Cart", mass=1), coordinate="x")
    model = sb.Model("bench", [cart, sb.Signal("u", force), block])
    run = sb.simulate(sb.form_equations(model), 5.0, times=TIMES, rtol=1e-13, atol=1e-13)
    return np.asarray(run[output])


@pytest.mark.parametrize(
    ("block", "numerator", "denominator"),
    [
        (sb.TransferFunction("y", "u", [2], [1]), [2], [1]),
        (sb.TransferFunction("y", "u", [1, 2], [1, 3, 2]), [1, 2], [1, 3, 2]),
        (sb.TransferFunction("y", "u", [3, 1, 2], [2, 1, 4]), [3, 1, 2], [2, 1, 4]),
        (sb.FirstOrder("y", "u", 0.5, 3), [3], [0.5, 1]),
        (sb.StateSpace("y", ["u"], [[0, 1], [-2, -3]], [[0], [1]], [[2, 1]], [[0.5]]), [0.5, 2.5, 3], [1, 3, 2]),
        (sb.PID("y", "u", {"p": 2, "i": 3, "d": 0.5, "filter": 0.1}), [0.7, 2.3, 3], [0.1, 1, 0]),
    ],
)  # fmt: skip
def test_linear_blocks_answer_a_step_as_python_control(
    block: Element, numerator: list[float], denominator: list[float]
) -> None:
    control = pytest.importorskip("control")
    _, wanted = control.step_response(control.tf(numerator, denominator), TIMES)
    np.testing.assert_allclose(answer(block, "y"), wanted, atol=1e-10, rtol=1e-10)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_delays_are_those_of_pade(order: int) -> None:
    control = pytest.importorskip("control")
    _, wanted = control.step_response(control.tf(*control.pade(0.7, order)), TIMES)
    np.testing.assert_allclose(answer(sb.Delay("y", "u", 0.7, order), "y"), wanted, atol=1e-9)


def test_a_delayed_wave_is_the_wave_before() -> None:
    found = answer(sb.Delay("y", "u", 0.5, 6), "y", "t - sin(t)")[20:]
    late = TIMES[20:] - 0.5
    np.testing.assert_allclose(found, late - np.sin(late), atol=1e-6)


def test_rate_limit_follows_no_faster() -> None:
    found = answer(sb.RateLimit("y", "u", 0.5, 0.001), "y")
    np.testing.assert_allclose(found, np.minimum(0.5 * TIMES, 1.0), atol=1e-3)


def test_dc_motor_is_its_formulas() -> None:
    block = sb.DCMotor("drive", "V", "theta_dot", "R", "L", "km", 2)
    by_hand = sb.Signal("i", rate="(V - R*i - km*theta_dot)/L", initial=2)
    one = sb.compile(sb.form_equations(arm(block, torque="drive", inputs=["V"])), "xdot")
    two = sb.compile(sb.form_equations(arm(by_hand, torque="km*i", inputs=["V"])), "xdot")
    np.testing.assert_array_equal(one(0, [0.4], [0.7], [3.0], s=[2.0]), two(0, [0.4], [0.7], [3.0], s=[2.0]))


def test_pid_is_its_three_formulas_bit_for_bit() -> None:
    gains = {"p": 40, "i": 20, "d": 5, "filter": "0.01"}
    block = sb.PID("y", "0.3 - theta", gains, limits=(-8, 8))
    raw = "40*e + y_integral + 5*(e - y_filtered)/0.01"
    by_hand = [
        sb.Signal("e", "0.3 - theta"),
        sb.Signal("y_integral", rate="20*e + (y - y_unlimited)*20/40"),
        sb.Signal("y_filtered", rate="(e - y_filtered)/0.01"),
        sb.Signal("y_unlimited", raw),
        sb.Signal("y", "min(8, max(-8, y_unlimited))"),
    ]
    one, two = (sb.form_equations(arm(*parts, torque="y")) for parts in ([block], by_hand))
    assert sb.generate_code(one, "xdot", "c") == sb.generate_code(two, "xdot", "c")


def test_limits_hold_and_the_integral_is_led_back() -> None:
    gains = {"p": 2, "i": 1}
    with_limits = sb.PID("y", "0.5 - theta", gains, limits=(-3, 3))
    run = sb.simulate(sb.form_equations(arm(with_limits, torque="y")), 20.0)
    assert np.abs(run["y"]).max() <= 3
    free = sb.simulate(sb.form_equations(arm(sb.PID("y", "0.5 - theta", gains), torque="y")), 20.0)
    assert np.abs(run["y_integral"]).max() < np.abs(free["y_integral"]).max()


def test_mechanism_and_controller_are_the_interconnection_of_python_control() -> None:
    control = pytest.importorskip("control")
    gains = {"p": 40, "i": 20, "d": 5, "filter": 0.05}
    reference = 0.3
    closed = sb.form_equations(arm(sb.PID("y", f"{reference} + r - theta", gains), torque="y", inputs=["r"]))
    rest = sb.find_equilibrium(closed)
    here = sb.linearize(closed, rest, outputs="theta")
    plant = sb.form_equations(arm(torque="T", inputs=["T"]))
    open_loop = sb.linearize(plant, {"theta": reference}, inputs={"T": rest["y"]}, outputs="theta")
    controller = control.tf([40 * 0.05 + 5, 40 + 20 * 0.05, 20], [0.05, 1, 0])
    wanted = control.feedback(control.series(control.ss(controller), open_loop.to_control()), 1)
    frequencies = 1j * np.array([0.1, 1.0, 5.0, 30.0])
    np.testing.assert_allclose(here.to_control()(frequencies), wanted(frequencies), rtol=1e-9)


def test_blocks_are_written_and_read(tmp_path: Path) -> None:
    blocks = [
        sb.PID("servo", "0.3 - theta", {"p": 4, "d": 1, "filter": "0.01"}, limits=("-R", "R")),
        sb.TransferFunction("filtered", "servo", [1], ["L", 1]),
        sb.StateSpace("two", ["servo", "t"], [["R"]], [[1, 2]], [[1], [3]], initial=[2]),
        sb.Delay("late", "servo", "L", 4),
        sb.FirstOrder("lag", "servo", "L"),
        sb.RateLimit("slow", "servo", 1, 0.1, fall=2),
        sb.DCMotor("drive", "slow", "theta_dot", "R", "L", "km"),
    ]
    model = arm(*blocks, torque="drive")
    sb.save_model(model, tmp_path / "arm.toml")
    assert sb.load_model(tmp_path / "arm.toml") == model
    space: dict[str, object] = {}
    exec(model_to_script(model), space)  # our own text
    assert space["model"] == model
    assert sb.form_equations(model).signal_state_names == tuple(s.name for s in model.signals if s.is_state)


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda: sb.PID("y", "u", {"p": 1, "d": 1}), "block.derivative"),
        (lambda: sb.PID("y", "u", {"i": 1}, limits=(0, 1)), "block.tracking"),
        (lambda: sb.PID("y", "u", {"k": 1}), "block.unknown_gain"),
        (lambda: sb.PID("y", "u", {"p": 1}, limits=(1,)), "model.wrong_number"),
        (lambda: sb.TransferFunction("y", "u", [1, 0, 0], [1, 1]), "block.improper"),
        (lambda: sb.TransferFunction("y", "u", [1], [0, 1]), "block.no_polynomial"),
        (lambda: sb.StateSpace("y", ["u"], [[1, 2]], [[1]], [[1]]), "block.matrix"),
        (lambda: sb.StateSpace("y", ["u"], [[1]], [[1]], [[1]], initial=[1, 2]), "block.matrix"),
        (lambda: sb.Delay("y", "u", 1, order=0.5), "block.order"),
        (lambda: sb.Delay("y", "u", 1, order=11), "block.order"),
    ],
    ids=range(10),
)  # fmt: skip
def test_misuse_has_its_message(make: Callable[[], object], code: str) -> None:
    assert code in [found for found, _ in refused(make)]


def test_names_of_blocks_are_symbols_of_the_model() -> None:
    found = refused(lambda: arm(sb.PID("theta", "t", {"p": 1}), torque="0"))
    assert found[0][0] == "names.duplicate"
    found = refused(lambda: arm(sb.PID("y", "nothing", {"p": 1}), torque="0"))
    assert found[0] == ("names.unknown", "block y, input, column 1")
