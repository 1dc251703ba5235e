"""Units of expressions and parameters: right where they are given, absent where a doubt is left."""

from __future__ import annotations

import pytest

from symbody import Body, Drive, Force, Frame, Friction, Model, Prismatic, Revolute, form_equations
from symbody.equations.outputs.dimensions import expression_unit, read_unit
from symbody.equations.outputs.units import Units, linear_names, symbol_units
from symbody.expr.language.formula import Formula

KNOWN = {
    "t": "s", "x": "m", "x_dot": "m/s", "x_ddot": "m/s^2", "theta": "rad", "theta_dot": "rad/s",
    "theta_ddot": "rad/s^2", "m": "kg", "l": "m", "I": "kg m^2", "g": "m/s^2", "k": "N/m", "d": "N s/m",
    "kt": "N m/rad", "F": "N", "T": "N m", "energy": "J", "power": "W",
    **{f"reaction A F{letter}": "N" for letter in "xyz"}, **{f"reaction A M{letter}": "N m" for letter in "xyz"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("expression", "unit"),
    [
        ("0.5*m*x_dot^2", "J"), ("0.5*I*theta_dot^2", "J"), ("k*x^2/2", "J"), ("kt*theta^2/2", "J"),
        ("m*x_ddot + d*x_dot + k*x", "N"), ("I*theta_ddot + m*l^2*theta_ddot/4", "N m"), ("kt*theta", "N m"),
        ("T*theta_dot", "W"), ("F*x_dot", "W"), ("energy/t", "W"), ("F*l", "N m"), ("2*T", "N m"), ("T*theta", "J"),
        ("sqrt('reaction A Fx'^2 + 'reaction A Fy'^2)", "N"), ("sqrt('reaction A Mx'^2 + 'reaction A My'^2)", "N m"),
        ("x/l", ""), ("sin(theta)", ""), ("l*cos(theta)", "m"), ("l*theta_dot", "m/s"), ("theta_dot^2", "rad^2/s^2"),
        ("atan2(x, l)", "rad"), ("180/pi*theta", "deg"), ("theta*180/pi - 90", "deg"), ("30/pi*theta_dot", "1/min"),
        ("x - 0.3", "m"), ("max(x, 0)", "m"), ("if(x > 0, x, -x)", "m"), ("abs(x)", "m"), ("sign(x)*F", "N"),
        ("sqrt(l/g)", "s"), ("x^2", "m^2"), ("1/x", "1/m"), ("theta - pi/2", "rad"), ("F/m", "m/s^2"),
        ("x/(l*t)", "1/s"), ("m/(x*t)", "kg/(m s)"),
    ],
)  # fmt: skip
def test_units_follow_from_the_names(expression: str, unit: str) -> None:
    assert expression_unit(expression, KNOWN.get) == unit
    assert Units(KNOWN)[expression] == unit


@pytest.mark.parametrize(
    "expression",
    [
        "9.81*m",  # a number that may be an acceleration
        "1000*x",  # millimetres, or a stiffness
        "x + theta", "x + t", "energy + F", "exp(x)", "sin(l)", "x^theta", "2^x", "x^0.3", "floor(x)", "unknown*x",
        "3", "theta_dot/(2*pi)", "if(x > 0, x, t)", "x +", "", "sqrt(-2*x)", "'reaction B Fx'*2", "x/0", "atan2(x, t)",
    ],
)  # fmt: skip
def test_no_unit_is_better_than_a_wrong_one(expression: str) -> None:
    assert expression_unit(expression, KNOWN.get) is None
    assert expression not in Units(KNOWN)
    with pytest.raises(KeyError):
        Units(KNOWN)[expression]


def test_units_are_read() -> None:
    torque, energy = read_unit("N m"), read_unit("J")
    assert torque is not None and energy is not None
    assert torque != energy and torque.without_angle == energy.without_angle
    assert read_unit("furlong") is None and read_unit("m^x") is None


def test_parameters_and_inputs_have_the_units_of_their_places() -> None:
    arm = Body(
        "Arm",
        mass="m",
        inertia=(0, 0, "I"),
        frames={"tip": Frame(at=("-l/2", "w", 0), rotate=[("z", "alpha")])},
    )
    block = Body("Block", mass="2*m", frames={"side": Frame(at=("0.001*l_mm", "a*b", "both"))})
    pin = Revolute(
        "pin", "ground", arm, coordinate="theta",
        torque=Drive(applied="T", stiffness="kt", damping="dt", free="theta_0"),
    )  # fmt: skip
    slider = Prismatic("slider", "ground", block, coordinate="x", force=Drive(stiffness="k", damping="both"))
    model = Model(
        "units", [pin, slider, Force("push", on=block, vector=("F + F_2", 0, 0))], gravity=(0, "-g", 0),
        inputs=["T", "F", "F_2"],
        parameters=dict.fromkeys("m I l w alpha l_mm a b both kt dt theta_0 k g".split(), 1.0),
    )  # fmt: skip
    assert symbol_units(model) == {
        "m": "kg", "I": "kg m^2", "l": "m", "w": "m", "alpha": "rad", "T": "N m", "kt": "N m/rad",
        "dt": "N m s/rad", "theta_0": "rad", "k": "N/m", "F": "N", "F_2": "N", "g": "m/s^2",
    }  # fmt: skip
    units = form_equations(model).units
    assert units["0.5*m*x_dot^2"] == "J" and units["x/l"] == ""
    assert "both*x" not in units  # a length, or a damping


def test_names_that_share_the_unit_of_a_formula() -> None:
    assert linear_names(Formula.from_value("-(a + 2*b)/3 - c")) == {"a", "b", "c"}
    assert (
        linear_names(Formula.from_value("a*b")) == linear_names(Formula.from_value("sin(a)")) == frozenset()
    )
    assert linear_names(Formula.from_value("3/4")) == frozenset()


def test_friction_has_the_unit_of_its_coordinate() -> None:
    block, wheel = Body("Block", mass=1), Body("Wheel", mass=1, inertia=(0, 0, 1))
    slide = Prismatic("slide", "ground", block, coordinate="x", friction=Friction(mu=0.3, v0=1e-3))
    pin = Revolute("pin", "ground", wheel, coordinate="phi", friction=Friction(mu=0.3, radius=0.1, v0=1e-3))
    units = form_equations(Model("rough", [slide, pin], gravity=(0, -9.81, 0))).units
    assert (units["friction slide"], units["friction pin"]) == ("N", "N m")
    assert units["friction_reserve pin"] == "N m"
    assert units["friction_normal pin"] == units["friction_normal slide"] == "N"
