"""Equilibria against closed forms, and questions that have no answer."""

from __future__ import annotations

import math

import numpy as np
import pytest

import symbody as sb
from tests.analysis.test_linearize import G, cart_pendulum, four_bar, hung_body, pendulum
from tests.problems.mechanisms import equations_of


def test_both_equilibria_of_the_pendulum_the_nearest_first() -> None:
    above = sb.find_equilibrium(pendulum(), {"theta": 2.0})
    assert above["theta"] == pytest.approx(math.pi) and above.stable is False
    assert [branch.q["theta"] for branch in above.branches] == pytest.approx([0.0], abs=1e-12)
    below = sb.find_equilibrium(pendulum(), {"theta": 1.0}, {"d": 0.1})
    assert below["theta"] == pytest.approx(0.0, abs=1e-12) and below.stable is True
    undamped = sb.find_equilibrium(pendulum(), {"theta": 1.0})
    assert undamped.verdict == "marginal" and undamped.stable is None


def test_a_constant_torque_and_the_torque_that_holds() -> None:
    held = sb.find_equilibrium(pendulum(), inputs={"T": 0.5})
    assert held["theta"] == pytest.approx(math.asin(0.5 / 0.981))
    assert [branch.q["theta"] for branch in held.branches] == pytest.approx(
        [math.pi - math.asin(0.5 / 0.981)]
    )
    found = sb.find_equilibrium(pendulum(), unknowns=["T"], fixed={"theta": 0.3})
    assert found.inputs["T"] == pytest.approx(0.981 * math.sin(0.3)) and found["theta"] == 0.3
    assert abs(found.udot["theta_ddot"]) < 1e-14


def test_torque_beyond_the_weight_has_no_equilibrium() -> None:
    with pytest.raises(
        sb.AssemblyError, match=r"equilibrium\.none.*along theta_dot, 0\.519 N m are not"
    ) as caught:
        sb.find_equilibrium(pendulum(), inputs={"T": 1.5})
    assert "theta = 1.571" in str(caught.value)


@pytest.mark.parametrize(
    ("gravity", "force", "said"), [(G, 0, "along B_vz, -19.62 N are"), (0, 3, "along B_vx, 3 N are")]
)
def test_free_bodies_under_constant_forces(gravity: float, force: float, said: str) -> None:
    body = sb.Body("B", mass=2, inertia=(1, 1, 1))
    push = sb.Force("push", "B", vector=("F", 0, 0))
    eqs = sb.form_equations(sb.Model("free", [body, push], gravity=(0, 0, -gravity), inputs=["F"]))
    with pytest.raises(sb.AssemblyError) as caught:
        sb.find_equilibrium(eqs, inputs={"F": force})
    assert caught.value.problems[0].code == "equilibrium.none" and said in str(caught.value)


def test_a_free_body_rests_anywhere() -> None:
    eqs = sb.form_equations(sb.Model("free", [sb.Body("B", mass=2, inertia=(1, 1, 1))]))
    found = sb.find_equilibrium(eqs, {"B_x": 0.7})
    assert found["B_x"] == 0.7 and "6 dimension(s)" in found.notes[0] and found.verdict == "drifting"


def test_cart_stays_where_it_was_guessed() -> None:
    found = sb.find_equilibrium(cart_pendulum(), {"x": 2.0, "phi": 0.4})
    assert found["x"] == pytest.approx(2.0, abs=1e-12) and found["phi"] == pytest.approx(0.0, abs=1e-12)
    assert "along x;" in found.notes[0] and found.stable is False


def truss() -> sb.EquationSet:
    """A mass on two inclined springs whose posts are 2 apart, sliding along y: von Mises' truss."""
    ground = {"l": sb.Frame(at=(-1, 0, 0)), "r": sb.Frame(at=(1, 0, 0))}
    node = sb.Body("Node", mass=1)
    slide = sb.Prismatic("slide", "ground", "Node", axis="y", coordinate="y", force=sb.Drive(damping=0.1))
    springs = [sb.SpringDamper(f"s{p}", f"ground.{p}", "Node", stiffness=100, free="l0") for p in "lr"]
    return sb.form_equations(
        sb.Model("truss", [node, slide, *springs], ground=ground, parameters={"l0": 1.2})
    )


def test_three_equilibria_of_the_von_mises_truss() -> None:
    found = sb.find_equilibrium(truss(), {"y": 0.5})
    height = math.sqrt(1.2**2 - 1)
    assert found["y"] == pytest.approx(height) and found.stable is True
    others = sorted((branch.q["y"], branch.linearization.verdict) for branch in found.branches)  # type: ignore[attr-defined]
    assert [y for y, _ in others] == pytest.approx([-height, 0.0], abs=1e-9)
    assert [verdict for _, verdict in others] == ["stable", "unstable"]


def test_slider_crank_balances_above_and_below_by_symmetry() -> None:
    """Without force the centre of mass of the linkage is highest and lowest; multipliers carry the weights."""
    eqs = equations_of("slider_crank")
    found = sb.find_equilibrium(eqs, {"theta": 1.0})
    assert found["theta"] == pytest.approx(math.pi / 2) and found.stable is False
    # On the pin half the rod's weight: 1.5 * 9.81 / 2; the other half is on the guide.
    assert found.multipliers["lambda_B_1"] == pytest.approx(7.3575)
    assert len(found.branches) == 3
    pushed = sb.find_equilibrium(eqs, {"theta": -1.0}, inputs={"F": 4.0})
    assert max(map(abs, pushed.udot.values())) < 1e-12
    held = sb.find_equilibrium(eqs, unknowns=["F"], fixed={"theta": 0.8})
    assert max(map(abs, held.udot.values())) < 1e-12 and held["theta"] == 0.8


def test_outputs_of_branches_are_computed_with_their_own_inputs() -> None:
    """The force that holds the slider differs from one assembly to the other; each forcing contains its own."""
    eqs = equations_of("slider_crank")
    held = sb.find_equilibrium(eqs, unknowns=["F"], fixed={"theta": 0.8})
    states = (held, *held.branches)
    forces = [float(state.inputs["F"]) for state in states]
    assert len(states) == 2 and abs(forces[0] - forces[1]) > 1.0
    slider = eqs.speed_names.index("s_dot")
    assert [np.asarray(state["forcing"])[slider] for state in states] == pytest.approx(forces, rel=1e-12)


@pytest.mark.exhaustive
def test_a_damped_motion_ends_in_a_stable_equilibrium() -> None:
    eqs = four_bar()
    run = sb.simulate(eqs, 60.0, {"q1": -0.8}, guess={"q2": 0.7, "q3": -1.4})
    end = {name: float(run[name][-1]) for name in eqs.coordinate_names}
    found = sb.find_equilibrium(eqs, end)
    assert found.stable and all(abs(found.q[name] - end[name]) < 1e-3 for name in end)


def test_singular_angles_are_no_equilibrium() -> None:
    """Along two coincident axes one force vanishes; the body is not at rest there."""
    found = sb.find_equilibrium(hung_body("323"), {"a": 0.3, "b": 0.4, "c": -0.3})
    assert abs(math.sin(found.q["b"])) > 1e-3 and np.abs(list(found.udot.values())).max() < 1e-11


def test_motions_in_time_leave_no_rest() -> None:
    body = sb.Body("B", mass=1, inertia=(0, 0, 1))
    joint = sb.Revolute("j", "ground", "B", coordinate="q", motion="2*t", as_constraint=True)
    eqs = sb.form_equations(sb.Model("driven", [body, joint], gravity=(0, -G, 0)))
    with pytest.raises(sb.AssemblyError, match=r"equilibrium\.moving"):
        sb.find_equilibrium(eqs)


def test_unknown_names() -> None:
    with pytest.raises(sb.AssemblyError) as caught:
        sb.find_equilibrium(pendulum(), unknowns=["TT"])
    assert caught.value.problems[0].code == "equilibrium.unknown_name" and "T" in str(caught.value)


def test_unreachable_closure() -> None:
    with pytest.raises(sb.AssemblyError, match=r"assembly\.(conflict|open)"):
        sb.find_equilibrium(equations_of("slider_crank"), fixed={"s": 5.0})


def test_a_body_without_a_joint_is_named_as_the_cause() -> None:
    held, lost = (sb.Body(name, mass=1, inertia=(1, 1, 1)) for name in ("Held", "Lost"))
    hinge = sb.Revolute("hinge", "ground", held, coordinate="phi", torque=sb.Drive(stiffness=1))
    eqs = sb.form_equations(sb.Model("loose", [lost, hinge], (0, 0, -9.81)))
    with pytest.raises(sb.AssemblyError, match="body Lost has no joint and moves freely"):
        sb.find_equilibrium(eqs)
