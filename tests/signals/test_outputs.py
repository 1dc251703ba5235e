"""Signals that name outputs of the mechanism, and the laws that hold for all signals."""

from __future__ import annotations

import random

import numpy as np
import pytest

import symbody as sb
from tests.laws.building import build_model
from tests.laws.mechanisms import random_mechanism
from tests.signals.arm import arm
from tests.tiers import cases

HEIGHT = "frame r Arm.tip ground ground y"


def test_loads_read_places_and_energies() -> None:
    by_signal = arm(sb.Signal("h", output=HEIGHT), sb.Signal("F", "-3*h"), torque="F*cos(theta)")
    by_hand = arm(torque="-3*(2*l*sin(theta))*cos(theta)")
    f, g = (sb.compile(sb.form_equations(model), "udot") for model in (by_signal, by_hand))
    np.testing.assert_allclose(f(0, [0.4], [0.7]), g(0, [0.4], [0.7]), rtol=1e-14)
    energetic = sb.form_equations(arm(sb.Signal("T", output="kinetic_energy"), torque="-T*theta_dot"))
    moment = 0.01 + 0.09
    wanted = -(0.5 * moment * 0.49 * 0.7 + 0.01 * 0.7 + 9.81 * 0.3 * np.cos(0.4)) / moment
    np.testing.assert_allclose(sb.compile(energetic, "udot")(0, [0.4], [0.7]), [wanted], rtol=1e-13)


def test_lengths_of_springs_are_read() -> None:
    spring = sb.SpringDamper("S", "ground", "Arm.tip", stiffness=2, free="0.1")
    eqs = sb.form_equations(arm(spring, sb.Signal("d", output="length S"), torque="d"))
    np.testing.assert_allclose(sb.assemble(eqs, {"theta": 0.3})["d"], 0.6, rtol=1e-14)


def test_reactions_feed_rates_but_no_loads() -> None:
    parts = [sb.Signal("N", output="reaction motor Fx"), sb.Signal("f", rate="(N - f)/0.1")]
    eqs = sb.form_equations(arm(*parts, torque="-0.01*f"))
    state = sb.assemble(eqs, {"theta": 0.4, "theta_dot": 1, "f": 2})
    np.testing.assert_allclose(state["f_dot"], 10 * (state["reaction motor Fx"] - 2), rtol=1e-13)
    np.testing.assert_allclose(state["N"], state["reaction motor Fx"], rtol=1e-15)
    with pytest.raises(sb.SymbodyError, match=r"signal.algebraic.*joint motor -> F -> N") as caught:
        sb.form_equations(arm(parts[0], sb.Signal("F", "2*N"), torque="F"))
    assert "first-order filter" in caught.value.problems[0].fix


@pytest.mark.parametrize("output", ["theta_ddot", "frame vdot Arm.tip ground ground x", "reaction motor Fy"])
def test_what_needs_accelerations_feeds_no_load(output: str) -> None:
    with pytest.raises(sb.SymbodyError, match="signal.algebraic"):
        sb.form_equations(arm(sb.Signal("a", output=output), torque="a"))


def test_rings_through_outputs_are_found() -> None:
    ring = [sb.Signal("a", output="effort motor")]
    with pytest.raises(sb.SymbodyError, match="signal.loop"):
        sb.form_equations(arm(*ring, torque="2*a"))
    late = [sb.Signal("a", output="2*c + theta_ddot"), sb.Signal("c", output="a/3")]
    with pytest.raises(sb.SymbodyError, match="signal.loop"):
        sb.form_equations(arm(*late, torque="0")).roots("a")


@pytest.mark.parametrize(
    ("output", "code"),
    [("reaction nobody Fx", "equations.unknown_joint"), ("nothing", "equations.unknown_output"),
     ("reaction motor", "signal.no_number")],
)  # fmt: skip
def test_outputs_that_are_no_number_are_refused(output: str, code: str) -> None:
    model = arm(sb.Signal("a", output=output), sb.Signal("f", rate="a - f"), torque="0")
    with pytest.raises(sb.SymbodyError) as caught:
        sb.form_equations(model).roots("xdot")
    assert caught.value.problems[0].code == code
    assert caught.value.problems[0].where == "signal a, output"


def test_splitting_a_formula_changes_no_bit() -> None:
    whole = arm(torque="km*(sin(theta) + (theta_dot - 2*theta)*km)/(1 + theta^2)", inputs=[])
    parts = [
        sb.Signal("d", "1 + theta^2"),
        sb.Signal("n", "sin(theta) + e*km"),
        sb.Signal("e", "theta_dot - 2*theta"),
    ]
    split = arm(*parts, torque="km*n/d")
    one, two = (
        sb.generate_code(sb.form_equations(model), ["xdot", "energy"], "c") for model in (whole, split)
    )
    assert one == two


def test_order_and_names_of_signals_do_not_matter() -> None:
    parts = [
        sb.Signal("e", "0.3 - theta"),
        sb.Signal("s1", rate="e - s1"),
        sb.Signal("s2", rate="s1*theta_dot"),
        sb.Signal("h", output=HEIGHT),
    ]
    renamed = [
        sb.Signal("zz", output=HEIGHT),
        sb.Signal("y2", rate="y1*theta_dot"),
        sb.Signal("y1", rate="x - y1"),
        sb.Signal("x", "0.3 - theta"),
    ]
    one = sb.form_equations(arm(*parts, torque="e + s1 - s2 + h"))
    two = sb.form_equations(arm(*renamed, torque="x + y1 - y2 + zz"))
    f, g = sb.compile(one, "xdot"), sb.compile(two, "xdot")
    assert f.operations == g.operations
    first, second = f(0, [0.4], [0.7], s=[0.2, 0.5]), g(0, [0.4], [0.7], s=[0.5, 0.2])
    np.testing.assert_array_equal(first, second[[0, 1, 3, 2]])


def signals_of(model: sb.Model, rng: random.Random) -> list[sb.Signal]:
    """Signals that read a mechanism and act on nothing."""
    names = [name for joint in model.joints for name in joint.coordinates if joint.quaternion is None]
    read = rng.choice(names) if names else "t"
    return [
        sb.Signal("law_value", f"sin({read}) + t"),
        sb.Signal("law_energy", output="kinetic_energy"),
        sb.Signal("law_state", rate=f"law_value - law_state*{rng.randint(1, 5)}", initial=1),
        sb.Signal("law_late", rate="law_energy - law_state"),
    ]


@pytest.mark.parametrize("seed", cases(range(12), fast=[0, 1, 3]))
def test_signals_that_act_on_nothing_change_nothing(seed: int) -> None:
    model = build_model(random_mechanism(seed))
    wider = sb.Model(
        model.name, [*model.elements, *signals_of(model, random.Random(seed))], model.gravity, model.parameters,
        model.inputs, model.initial, model.ground,
    )  # fmt: skip
    one, two = sb.form_equations(model), sb.form_equations(wider)
    if one.coordinate_names != two.coordinate_names:  # a signal reads a cut angle, which becomes a coordinate
        pytest.skip("other coordinates")
    f, g = sb.compile(one, ["udot", "qdot"]), sb.compile(two, ["udot", "qdot", "signal_rates"])
    rng = np.random.default_rng(seed)
    q, u = rng.normal(size=len(one.coordinate_names)), rng.normal(size=len(one.speed_names))
    r = rng.normal(size=len(one.input_names))
    try:
        plain = f(0.3, q, u, r)
    except sb.SymbodyError:
        pytest.skip("no accelerations exist at this state")
    found = g(0.3, q, u, r, s=[1.0, 2.0])
    np.testing.assert_array_equal(plain.udot, found.udot)
    np.testing.assert_array_equal(plain.qdot, found.qdot)


def test_inputs_read_signals_that_follow_from_no_input() -> None:
    parts = [
        sb.Signal("h", output=HEIGHT),
        sb.Signal("N", output="reaction motor Fx"),
        sb.Signal("f", rate="N - f"),
    ]
    eqs = sb.form_equations(arm(*parts, torque="T", inputs=["T"]))
    by_hand = sb.form_equations(arm(torque="-4*l*sin(theta)"))
    run, same = sb.simulate(eqs, 1.0, inputs={"T": "-2*h"}), sb.simulate(by_hand, 1.0)
    np.testing.assert_allclose(run.q[0, -1], same.q[0, -1], rtol=1e-7)
    lin = sb.linearize(eqs, inputs={"T": "-2*h - f"})
    np.testing.assert_allclose(lin.A[0, 1:], np.array([-4 * 0.3, -1]) / 0.1, rtol=1e-12)
    with pytest.raises(sb.SymbodyError, match="equations.input_loop"):
        sb.simulate(eqs, 1.0, inputs={"T": "N"})


@pytest.mark.parametrize("formulation", [sb.Lagrange(), sb.NewtonEuler(), sb.VirtualWork(), sb.Recursive()])
def test_formulations_agree(formulation: object) -> None:
    parts = [
        sb.Signal("h", output=HEIGHT),
        sb.Signal("E", output="energy"),
        sb.Signal("N", output="reaction motor Fx"),
        sb.Signal("f", rate="N - f"),
    ]
    model = arm(*parts, torque="h - 0.1*f + 0.01*E")
    one, two = (sb.compile(sb.form_equations(model, way), "xdot") for way in (None, formulation))
    np.testing.assert_allclose(one(0, [0.1], [0.2], s=[1]), two(0, [0.1], [0.2], s=[1]), rtol=1e-12)


def test_loads_read_the_rate_of_a_state() -> None:
    parts = [sb.Signal("i", rate="2*height + 1"), sb.Signal("height", output="frame r Arm.tip ground ground y"),
             sb.Signal("change", output="i_dot")]  # fmt: skip
    eqs, by_hand = (
        sb.form_equations(arm(*parts, torque=torque)) for torque in ("3*change", "3*(2*height + 1)")
    )
    x = (0.0, [0.1], [0.2], ())
    np.testing.assert_allclose(
        sb.compile(eqs, "xdot")(*x, s=[5.0]), sb.compile(by_hand, "xdot")(*x, s=[5.0]), rtol=1e-14
    )
    loop = [sb.Signal("i", rate="turn"), sb.Signal("turn", output="theta_ddot"), parts[2]]
    with pytest.raises(sb.SymbodyError, match="needs accelerations or reactions"):
        sb.form_equations(arm(*loop, torque="3*change"))
