"""States of signals: in equations, compiled functions, motions, files, analyses and source text."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.signals.arm import arm, dc_motor_arm
from tests.tiers import cases

P = {"m": 1.0, "J": 0.01, "l": 0.3, "g": 9.81, "km": 0.1, "b": 0.01, "R": 1.0, "L": 0.5}


def rates_by_hand(t: float, x: np.ndarray) -> list[float]:
    speed, angle, current = x
    moment = P["km"] * current - P["b"] * speed - P["m"] * P["g"] * P["l"] * np.cos(angle)
    voltage = 2 * np.sin(t)
    return [
        moment / (P["J"] + P["m"] * P["l"] ** 2),
        speed,
        (voltage - P["R"] * current - P["km"] * speed) / P["L"],
    ]


def test_states_stand_last() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    assert eqs.state_names == ("theta_dot", "theta", "i")
    assert eqs.signal_state_names == ("i",)
    assert [str(state) for state in eqs.signal_states] == ["i(t)"]
    assert eqs.A.shape == (3, 3) and eqs.states[-1] == eqs.signal_states[0]


def test_compiled_functions_take_s() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    f = sb.compile(eqs, "xdot")
    wanted = rates_by_hand(0.7, np.array([0.2, 0.1, 2.0]))
    r = [2 * np.sin(0.7)]
    np.testing.assert_allclose(f(0.7, [0.1], [0.2], r, s=[2.0]), wanted, rtol=1e-14)
    np.testing.assert_array_equal(f.of_state(0.7, [0.2, 0.1, 2.0], r), f(0.7, [0.1], [0.2], r, s=[2.0]))
    np.testing.assert_array_equal(f(0.7, [0.1, 2.0], [0.2], r), f(0.7, [0.1], [0.2], r, s=[2.0]))
    many = f(0.7, [0.1], [0.2], r, s=[[2.0], [3.0]])
    np.testing.assert_array_equal(many[0], f(0.7, [0.1], [0.2], r, s=[2.0]))
    copy = pickle.loads(pickle.dumps(f))
    np.testing.assert_array_equal(copy(0.7, [0.1], [0.2], r, s=[2.0]), many[0])
    np.testing.assert_array_equal(f.bind(())(0.7, [0.1], [0.2], r, s=[2.0]), many[0])


def test_what_reads_no_state_needs_none() -> None:
    mass = sb.compile(sb.form_equations(dc_motor_arm()), "mass_matrix")
    np.testing.assert_array_equal(mass(0.0, [0.1], [0.2], [0.0]), mass(0.0, [0.1], [0.2], [0.0], s=[5.0]))


def test_missing_or_needless_states_are_refused() -> None:
    f = sb.compile(sb.form_equations(dc_motor_arm()), "xdot")
    with pytest.raises(sb.SymbodyError, match=r"states of signals.*\n.*\(i\)"):
        f(0.0, [0.1], [0.2], [0.0])
    plain = sb.compile(sb.form_equations(arm(torque="0")), "xdot")
    with pytest.raises(sb.SymbodyError, match="states of signals"):
        plain(0.0, [0.1], [0.2], s=[1.0])
    for function in (f, plain):
        with pytest.raises(sb.SymbodyError, match="states of signals are of type list"):
            function(0.0, [0.1], [0.2], [0.0], s=[[1.0, 2.0], [3.0]])


@pytest.mark.parametrize("integrator", [None, sb.Explicit(order=5), sb.Stiff(), sb.FixedStep(1e-3)])
def test_motion_is_that_of_an_independent_integrator(integrator: object) -> None:
    eqs = sb.form_equations(dc_motor_arm())
    run = sb.simulate(eqs, 2.0, {"theta": 0.3, "i": 1.5}, inputs={"V": "2*sin(t)"}, integrator=integrator,
                      rtol=1e-9)  # fmt: skip
    exact = solve_ivp(rates_by_hand, (0, 2), [0, 0.3, 1.5], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    np.testing.assert_allclose([run.u[0, -1], run.q[0, -1], run.s[0, -1]], exact, rtol=2e-6)
    np.testing.assert_array_equal(run["i"], run.s[0])
    np.testing.assert_allclose(run["i_dot"][-1], rates_by_hand(2.0, exact)[2], atol=2e-5)
    np.testing.assert_allclose(run.at(1.0)["i"], run.at([1.0])["i"][0])


def test_trajectory_and_model_are_saved(tmp_path: Path) -> None:
    model = dc_motor_arm()
    run = sb.simulate(sb.form_equations(model), 1.0, inputs={"V": 1}, times=np.linspace(0, 1, 5))
    run.save(tmp_path / "run.npz")
    read = sb.Trajectory.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(read.s, run.s)
    np.testing.assert_array_equal(read["i_dot"], run["i_dot"])
    assert read.names == run.names
    sb.save_model(model, tmp_path / "arm.toml")
    assert sb.load_model(tmp_path / "arm.toml") == model


def test_events_read_and_change_states() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    watched = [sb.Event("i - 1", action={"i": "i/2"}), sb.Event("i - 0.3", action="stop")]
    run = sb.simulate(eqs, 3.0, events=watched)
    assert [event.name for event in run.events] == ["i - 1", "i - 0.3"]
    np.testing.assert_allclose(run.s[0, -1], 0.3, atol=1e-8)


def test_states_are_assembled_stepped_and_swept() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    state = sb.assemble(eqs, {"i": "2*L"})
    assert state.s == {"i": 1.0} and state["i"] == 1.0
    np.testing.assert_allclose(state["i_dot"], -2.0)
    stepper = sb.Stepper(eqs, 0.1, inputs={"V": 1})
    for _ in range(5):
        stepper.step()
    run = sb.simulate(eqs, 0.5, inputs={"V": 1})
    np.testing.assert_allclose(stepper.s, run.s[:, -1], rtol=1e-6)
    assert stepper["i"] == stepper.s[0] and stepper.q.size == 1
    cases = sb.sweep(eqs, 0.5, times=[0.0, 0.5], initial={"i": [2.0, 3.0]}, inputs={"V": 1})
    np.testing.assert_allclose(cases["i"][0, -1], run["i"][-1], rtol=1e-6)
    np.testing.assert_array_equal(cases.trajectory(1).s[0], cases["i"][1])


def test_tolerances_follow_from_first_values_or_scales() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    few = sb.simulate(eqs, 1.0, rtol=0.0, inputs={"V": "sin(30*t)"}, scales={"i": 1e6})
    many = sb.simulate(eqs, 1.0, rtol=0.0, inputs={"V": "sin(30*t)"}, scales={"i": 1e-4})
    assert many.statistics.evaluations > few.statistics.evaluations
    with pytest.raises(sb.SymbodyError, match="positive"):
        sb.simulate(eqs, 1.0, scales={"i": 0})
    for initial in ({"i": [0.0, 1.0]}, {"i": [0.0, 1.0], "theta": 0.0}):
        apart = [sb.sweep(eqs, 1.0, initial=initial, rtol=0.0, inputs={"V": "sin(30*t)"}, scales={"i": size})
                 for size in (1e6, 1e-4)]  # fmt: skip
        assert np.all(apart[0]["i"][:, -1] != apart[1]["i"][:, -1])
    with pytest.raises(sb.SymbodyError, match="positive"):
        sb.sweep(eqs, 1.0, initial={"i": [0.0, 1.0]}, scales={"i": 0})


def test_dc_motor_has_the_poles_and_gain_of_the_tutorial() -> None:
    rotor = sb.Body("Rotor", inertia=(0, 0, "0.01"))
    drive = sb.Drive(applied="K*i", damping="0.1")
    shaft = sb.Revolute("shaft", "ground", rotor, coordinate="theta", torque=drive)
    current = sb.Signal("i", rate="(V - i - K*theta_dot)/0.5")
    model = sb.Model("motor", [shaft, current], parameters={"K": "0.01"}, inputs=["V"])
    lin = sb.linearize(sb.form_equations(model), outputs="theta_dot", cyclic=["theta"])
    assert lin.state_names == ("theta_dot", "i")
    np.testing.assert_allclose(lin.eigenvalues.real, [-2.00250078, -9.99749922], rtol=1e-8)
    np.testing.assert_allclose(lin.C @ np.linalg.solve(-lin.A, lin.B), [[0.0999001]], rtol=1e-6)


def test_linear_equations_are_those_of_differences() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    lin = sb.linearize(eqs, {"theta": 0.3, "theta_dot": 0.5})
    f, x, h = sb.compile(eqs, "xdot"), np.array([0.5, 0.3, 2.0]), 1e-6
    columns = [(f.of_state(0, x + h * e, [0]) - f.of_state(0, x - h * e, [0])) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(lin.A, np.array(columns).T, atol=1e-7)


def test_equilibrium_lets_signals_rest() -> None:
    loop = [sb.Signal("error", "0.3 - theta"), sb.Signal("sum", rate="error")]
    eqs = sb.form_equations(arm(*loop, torque="40*error + 20*sum - 2*theta_dot"))
    rest = sb.find_equilibrium(eqs)
    np.testing.assert_allclose(rest.q["theta"], 0.3, rtol=1e-9)
    np.testing.assert_allclose(rest.s["sum"], 9.81 * 0.3 * np.cos(0.3) / 20, rtol=1e-9)
    assert rest.verdict == "stable"
    with pytest.raises(sb.SymbodyError, match="the rate of signal x does not vanish"):
        sb.find_equilibrium(sb.form_equations(arm(sb.Signal("x", rate="1"), torque="0")))


@pytest.mark.parametrize(
    ("language", "last"),
    [("c", "const double *s)"), ("python", "s=())"), ("matlab", "p, s)"), ("julia", "s = ())"), ("rust", "s: &[f64; 1]"),
     ("javascript", "s = []"), ("fortran", "p, s, xdot"), ("jax", "s=())"), ("casadi", "'s']")],
)  # fmt: skip
def test_texts_have_a_last_argument_only_where_there_are_states(language: str, last: str) -> None:
    assert last in sb.generate_code(sb.form_equations(dc_motor_arm()), "xdot", language, parameters={})
    assert last not in sb.generate_code(sb.form_equations(arm(torque="0")), "xdot", language, parameters={})


def test_python_text_computes_the_same() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    space: dict[str, object] = {}
    exec(sb.generate_code(eqs, "xdot", "python", parameters={}), space)  # our own text
    values = space["f"](0.0, [0.1], [0.2], [3.0], (), [2.0])
    np.testing.assert_allclose(values, sb.compile(eqs, "xdot")(0.0, [0.1], [0.2], [3.0], s=[2.0]), rtol=1e-15)


def test_equations_show_signals() -> None:
    text = str(sb.form_equations(dc_motor_arm()))
    assert "signals:" in text and "i' = " in text
    assert r"\dot{i}" in sb.form_equations(dc_motor_arm()).latex()


def test_ways_without_states_say_so() -> None:
    eqs = sb.form_equations(dc_motor_arm())
    with pytest.raises(sb.SymbodyError, match="inverse.signals"):
        sb.inverse_dynamics(eqs, {"theta": "sin(t)"}, "V", [0.0, 1.0])


def test_sticking_and_loops_go_with_signals() -> None:
    drive, dry = sb.Drive(applied="F"), sb.Friction(mu="0.5", mu_static="0.6")
    slide = sb.Prismatic("slide", "ground", sb.Body("B", mass=1), coordinate="x", force=drive, friction=dry)
    parts = [slide, sb.Signal("F", rate=1), sb.Signal("late", rate="(x - late)/0.5")]
    eqs = sb.form_equations(sb.Model("stick", parts, gravity=(0, -10, 0)))
    run = sb.simulate(eqs, 8.0)
    np.testing.assert_allclose([run["F"][-1], run["x"][-1]], [8.0, 2**2 / 2 + 2**3 / 6], rtol=1e-8)
    assert run["late"][-1] < run["x"][-1]


@pytest.mark.parametrize("way", cases([sb.Baumgarte(), sb.GGL(), sb.Partition()], fast=[sb.Baumgarte()]))
def test_methods_of_closed_loops_carry_signals_along(way: object) -> None:
    """A motor's current drives a crank and feels it; a filter follows a reaction, which needs accelerations."""
    crank = sb.Body("Crank", mass=1, inertia=(0, 0, 1), frames={"P": sb.Frame(at=(1, 0, 0))})
    parts = [
        sb.Revolute("turn", "ground", crank, coordinate="a", torque=sb.Drive(applied="2*i")),
        sb.Prismatic("slide", "ground", sb.Body("Slider", mass=1), coordinate="x"),
        sb.Distance("rod", "Crank.P", "Slider", 3),
        sb.Signal("i", rate="V - 3*i - 2*a_dot", initial=1),
        sb.Signal("N", output="reaction slide Fy"),
        sb.Signal("slow", rate="(N - slow)/0.2"),
    ]
    eqs = sb.form_equations(sb.Model("crank", parts, inputs=("V",), initial={"x": 4}))
    laws = {"V": lambda t, q, u: 4 + np.sin(3 * t)}  # a function in Python, which has no derivative
    given = {"initial": {"a": 0.2, "a_dot": 1}, "rtol": 1e-9, "times": np.linspace(0, 2, 21)}
    usual = sb.simulate(eqs, 2.0, inputs={"V": "4 + sin(3*t)"}, **given)
    for inputs in ({"V": "4 + sin(3*t)"}, laws):
        run = sb.simulate(eqs, 2.0, inputs=inputs, constraints=way, **given)
        # Backward differentiation and stabilization are less exact than steps of high order.
        for name in ("a", "x", "i", "slow", "work"):
            np.testing.assert_allclose(run[name], usual[name], rtol=2e-5, atol=2e-5)


def test_work_is_that_of_forces_beside_a_state_of_this_name() -> None:
    eqs = sb.form_equations(arm(sb.Signal("work", rate="7"), torque="0.5"))
    run = sb.simulate(eqs, 1.0)
    np.testing.assert_allclose(run["work"][-1], 7.0)
    assert run.work[-1] < 1.0 and run.energy_drift < 1e-5
    stepper = sb.Stepper(eqs, 0.1).step()
    np.testing.assert_allclose(stepper["work"], 0.7)
