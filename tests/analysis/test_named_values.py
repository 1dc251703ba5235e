"""Values by name: angles in degrees, and what is no mapping."""

from __future__ import annotations

import math

import pytest

import symbody as sb

BODY = sb.Body("Bob", mass="m", frames={"top": sb.Frame(at=["0", "l", "0"])})
HINGE = sb.Revolute("hinge", "ground", "Bob.top", axis="z", coordinate="theta")
PENDULUM = sb.form_equations(sb.Model("pendulum", [BODY, HINGE], parameters={"m": 1, "l": 1}))


def test_angles_may_be_given_in_degrees_as_in_a_file() -> None:
    state = sb.assemble(PENDULUM, {"theta": "30 deg"})
    assert state.q["theta"] == pytest.approx(math.pi / 6, rel=4e-16)  # one product and one quotient, rounded
    within = sb.assemble(PENDULUM, guess={"theta": 7}, ranges={"theta": ("-90 deg", "90 deg")})
    assert within.q["theta"] == pytest.approx(7 - 2 * math.pi, rel=1e-14)


def test_a_rate_in_degrees_is_refused() -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        sb.assemble(PENDULUM, {"theta_dot": "30 deg"})
    assert "30*pi/180" in caught.value.problems[0].fix


@pytest.mark.parametrize("name", ["fixed", "guess"])
def test_what_is_no_mapping_is_named(name: str) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.assemble(PENDULUM, **{name: [0.5]})
    (problem,) = caught.value.problems
    assert problem.code == "assembly.not_a_mapping" and problem.where == name


def test_a_range_has_two_ends() -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.assemble(PENDULUM, ranges={"theta": 4})
    assert caught.value.problems[0].code == "assembly.not_a_range"


def test_a_single_unknown_is_a_name_not_letters() -> None:
    driven = sb.Revolute("hinge", "ground", "Bob.top", coordinate="theta", torque=sb.Drive(applied="Torque"))
    eqs = sb.form_equations(
        sb.Model("held", [BODY, driven], gravity=(0, -10, 0), parameters={"m": 1, "l": 1}, inputs=["Torque"])
    )
    rest = sb.find_equilibrium(eqs, unknowns="Torque", fixed={"theta": "30 deg"})
    assert rest.inputs["Torque"] == pytest.approx(5, rel=1e-12)  # m g l sin 30 deg


def test_a_robot_is_not_read_as_a_model_file() -> None:
    with pytest.raises(sb.FormatError, match="load_urdf"):
        sb.load_model("robot.urdf")
