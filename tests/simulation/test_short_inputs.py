"""What depends on time alone bounds the steps: pulses are seen, jumps begin anew, tables may jump."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.analysis.scales import Scales
from symbody.simulation.inputs.breakpoints import find_breakpoints
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.inputs.time_functions import time_functions
from symbody.simulation.simulation_problem import SimulationProblem
from tests.mechanisms import cart
from tests.tiers import cases, rows

Floats = NDArray[np.float64]


@cache
def quarter_car() -> sb.EquationSet:
    """A mass of 1 kg on a spring and a damper under a wheel force: omega = 10 rad/s, zeta = 0.1."""
    drive = sb.Drive("F", stiffness=100, damping=2)
    joint = sb.Prismatic("j", "ground", "B", axis="x", coordinate="x", force=drive)
    return sb.form_equations(sb.Model("car", [sb.Body("B", mass=1), joint], inputs=["F"]))


# An area of 1 N s in 50 ms, at 5 s, from rest: the cart goes with 1 m/s afterwards.
AREAS = {
    "window": "if(t > 5 and t < 5.05, 20, 0)",
    "bell": "exp(-((t - 5.2)/0.01)^2)/0.01/sqrt(pi)",
    "steep bell": "exp(-((t - 5.2)/1e-6)^2)*1e6/sqrt(pi)",
    "power": "if(abs(t - 5.2) < 0.1, cos(10*(t - 5.2))^60*10/0.32177, 0)",
    "hump": "max(0, (t - 5)*(5.05 - t))*6/0.05^3",
    "triangle": "interp1(t, 5, 0, 5.02, 40, 5.05, 0)",
    "steps": "smoothstep(t, 5, 5.01)*20 - smoothstep(t, 5.05, 5.06)*20",
    "periodic": "if(mod(t, 5) > 4.95, 20/2, 0)",
    "narrow arcs": "if(sin(2*pi*t/10) < -0.9999, 1, 0)*pi/(10*acos(0.9999))",
}
# The power: the integral of cos^60 over one arch is pi*binomial(60, 30)/2^60 = 0.3217...; given to 5 digits.
EXACT = dict.fromkeys(AREAS, 1.0) | {"power": np.pi * 118264581564861424 / 2**60 / 0.32177}


def end(law: object, **way: object) -> float:
    run = sb.simulate(cart(), 10.0, inputs={"F": law}, **way)  # type: ignore[dict-item, arg-type]
    assert run.success
    return float(run["x_dot"][-1])


@pytest.mark.parametrize(
    ("way", "name"),
    rows(product(["explicit", "order 5", "stiff", "final value"], AREAS),
         fast=lambda way, name: way == "explicit" or (way == "stiff" and name in ("window", "bell", "periodic"))),
)  # fmt: skip
def test_short_forces_after_a_rest_change_the_speed_by_their_area(name: str, way: str) -> None:
    chosen: dict[str, dict[str, object]] = {
        "explicit": {},
        "order 5": {"integrator": sb.Explicit(order=5)},
        "stiff": {"integrator": sb.Stiff()},
        "final value": {"times": [10.0]},
    }
    # A few hundred steps of a relative error of 1e-8 each; backward differentiation is less exact.
    assert end(AREAS[name], **chosen[way]) == pytest.approx(EXACT[name], rel=1e-4 if way == "stiff" else 1e-5)


@pytest.mark.parametrize("count", cases([28, 200], fast=[28]))
def test_a_road_bump_of_50_ms_is_felt(count: int) -> None:
    """Half a sine in a table of 28 points, and in one that Python reads.

    Trapezoids of a sine of height 1 between n + 1 points have the area 0.05/n / tan(pi/(2 n)).
    """
    times = np.linspace(5.0, 5.05, count)
    area = 0.05 / (count - 1) / np.tan(np.pi / (2 * (count - 1)))
    values = np.sin(np.pi * np.arange(count) / (count - 1)) / area
    values[[0, -1]] = 0.0
    assert end(sb.Table(times, values)) == pytest.approx(1.0, rel=1e-6)
    assert end(sb.Table(times, values), integrator=sb.Stiff()) == pytest.approx(1.0, rel=1e-4)
    assert end(sb.Table(times, values), times=[10.0]) == pytest.approx(1.0, rel=1e-6)


def test_pulses_are_seen_backwards_in_time() -> None:
    run = sb.simulate(cart(), (10.0, 0.0), inputs={"F": AREAS["window"]})
    assert run["x_dot"][-1] == pytest.approx(-1.0, rel=1e-6)


def test_events_on_an_input_see_its_pulse() -> None:
    for law in ("window", "bell", "triangle"):
        run = sb.simulate(cart(), 10.0, inputs={"F": AREAS[law]}, events=sb.Event("F - 10", name="on"))
        times = [event.t for event in run.events]
        assert len(times) == 2
        assert 5.0 <= times[0] < times[1] < 5.3


def test_events_see_pulses_that_move_nothing() -> None:
    pulse = sb.Event("exp(-((t - 7.3)/1e-4)^2) - 0.5", name="pulse")
    run = sb.simulate(cart(), 10.0, events=pulse)
    # at 7.3 s and 1e-4 s times the root of log 2
    half = 1e-4 * np.sqrt(np.log(2.0))
    np.testing.assert_allclose(
        [event.t for event in run.events], [7.3 - half, 7.3 + half], rtol=0, atol=1e-12
    )


def test_a_step_ends_at_a_jump_and_the_next_begins_behind_it() -> None:
    run = sb.simulate(quarter_car(), 10.0, inputs={"F": "if(t < 5, 0, 100)"})
    assert 5.0 in run.t
    # x = 1 - exp(-s) (cos w s + s sin ...): the step response, zeta = 0.1, omega = 10
    s = run.t[run.t > 5.0] - 5.0
    w = 10.0 * np.sqrt(0.99)
    exact = 1.0 - np.exp(-s) * (np.cos(w * s) + np.sin(w * s) / w)
    np.testing.assert_allclose(run["x"][run.t > 5.0], exact, rtol=0, atol=1e-6)
    # the step behind is no search for the jump, which would end a ten thousandth of a second behind it
    assert np.diff(run.t[run.t >= 5.0])[0] > 1e-3


def test_points_of_a_smooth_table_do_not_bound_the_steps() -> None:
    times = np.linspace(0.0, 10.0, 10_001)
    functions = time_functions(_sequence("F"), {0: sb.Table(times, np.sin(times))})
    assert functions is not None
    (found,) = find_breakpoints(functions, (0.0, 10.0))
    assert found.longest.min() > 1.0
    values = np.sin(times)
    values[5300:5306] += 1.0
    functions = time_functions(_sequence("F"), {0: sb.Table(times, values)})
    assert functions is not None
    (found,) = find_breakpoints(functions, (0.0, 10.0))
    places = np.flatnonzero(found.longest < 0.05)
    assert (np.abs(found.times[np.clip(places, 0, found.times.size - 1)] - 5.3) < 0.1).all()
    assert found.longest.max() > 0.5


def _sequence(law: str):  # type: ignore[no-untyped-def]
    laws = input_laws(["F"], {} if law == "F" else {"F": law}, (0.0, 10.0))
    formulas = {} if law == "F" else laws.formulas
    task = SimulationProblem(cart(), {}, type(laws)(formulas, {}, (), {}), Scales())
    return task.compile_outputs(("xdot", "power")).sequence


@pytest.mark.parametrize("kind", ["linear", "cubic"])
@pytest.mark.parametrize("is_long", [False, True])
def test_a_time_given_twice_is_a_jump(kind: str, is_long: bool) -> None:
    """The later value holds at the jump; on both sides the table is what its points there say."""
    count = 40 if is_long else 4
    left, right = np.linspace(0.0, 1.0, count), np.linspace(1.0, 2.0, count)
    table = sb.Table([*left, *right], [*left**2, *(5.0 - right)], kind)  # type: ignore[arg-type]
    wanted = np.array([-1.0, 0.5, 1.0 - 1e-12, 1.0, 1.5, 3.0])
    run = sb.simulate(cart(), (-1.0, 3.0), inputs={"F": table}, times=wanted)
    rough = 0.0 if kind == "cubic" else (1.0 / (count - 1)) ** 2
    np.testing.assert_allclose(run["F"], [0.0, 0.25, 1.0, 4.0, 3.5, 3.0], rtol=0, atol=rough + 1e-9)
    area = (1.0 / 3.0 if kind == "cubic" else np.trapezoid(left**2, left)) + 3.5 + 3.0
    assert run["x_dot"][-1] == pytest.approx(area, rel=1e-7)


def test_jumps_at_the_ends_of_a_table() -> None:
    table = sb.Table([1.0, 1.0, 2.0, 2.0], [0.0, 3.0, 3.0, 0.0])
    run = sb.simulate(cart(), 4.0, inputs={"F": table}, times=[0.5, 1.0, 1.5, 2.0, 4.0])
    np.testing.assert_allclose(run["F"], [0.0, 3.0, 3.0, 0.0, 0.0])
    assert run["x_dot"][-1] == pytest.approx(3.0, rel=1e-7)


def test_steps_of_one_length_and_python_functions_say_what_they_may_miss() -> None:
    run = sb.simulate(cart(), 10.0, inputs={"F": AREAS["window"]}, integrator=sb.FixedStep(0.1))
    assert any("within 0.05 s near t = 5 s" in note for note in run.notes)
    run = sb.simulate(cart(), 10.0, inputs={"F": AREAS["window"]}, integrator=sb.FixedStep(0.01))
    assert not any("may miss" in note for note in run.notes)
    run = sb.simulate(cart(), 1.0, inputs={"F": lambda t, q, u: 0.0})
    assert any("max_step=" in note for note in run.notes)
    run = sb.simulate(cart(), 1000.0, inputs={"F": "sin(1000*t)^60"}, times=[1.0], max_steps=100)
    assert any("change too often" in note for note in run.notes)


def test_what_does_not_depend_on_time_costs_no_step() -> None:
    free = sb.simulate(quarter_car(), 3.0, {"x": 1.0})
    also = sb.simulate(quarter_car(), 3.0, {"x": 1.0}, inputs={"F": "0*x"})
    smooth = sb.simulate(quarter_car(), 3.0, {"x": 1.0}, inputs={"F": "1e-9*t"})
    assert free.statistics == also.statistics or free.statistics.accepted == also.statistics.accepted
    assert abs(smooth.statistics.accepted - free.statistics.accepted) <= 2
