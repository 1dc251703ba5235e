"""Multipliers are outputs by their names, and factors that vanish are named, whatever computes them."""

from __future__ import annotations

from typing import Any

import pytest

import symbody as sb


def wheels(ratio: float, name: str) -> sb.Model:
    elements: list[Any] = []
    for wheel in "xy":
        elements.append(sb.Body(f"B{wheel}", mass=1, inertia=[1, 1, 1]))
        torque = sb.Drive(stiffness=2 if wheel == "y" else 0)
        elements.append(
            sb.Revolute(f"J{wheel}", "ground", f"B{wheel}", axis="z", coordinate=wheel, torque=torque)
        )
    tie = sb.Constraint(name, ["r*y - 2*s*x"])
    return sb.Model("m", [*elements, tie], parameters={"r": ratio, "s": 1}, gravity=[0, 0, 0])


@pytest.mark.parametrize("substitute", [True, False])
def test_a_constraint_with_a_space_in_its_name_has_its_multiplier_as_an_output(substitute: bool) -> None:
    """As those of `<mimic>` have."""
    for name in "y mimic", "tie":
        eqs = sb.form_equations(wheels(1.0, name), substitute=substitute)
        run = sb.simulate(eqs, 0.1, {"x": 0.25}, times=[0.0, 0.1])
        multiplier = f"lambda_{name}_1"
        # y = 2 x; 5 x'' = -8 x, y'' = -2 y + lambda.
        assert run[multiplier][0] == pytest.approx(0.2)
        assert run[f"x_ddot + '{multiplier}'"][0] == pytest.approx(-0.2)


def test_generated_code_names_the_factor_that_vanishes() -> None:
    eqs = sb.form_equations(wheels(1.0, "tie"), substitute=True)
    with pytest.raises(sb.FormulationError) as caught:
        sb.generate_code(eqs, "udot", parameters={"r": 0.0})
    assert caught.value.problems[0].code == "equations.vanishing_factor"


def test_a_parameter_may_not_have_the_name_of_a_multiplier() -> None:
    """Outputs read the multiplier, formulas the parameter."""
    model = wheels(1.0, "tie")
    values = {**model.parameters, "lambda_tie_1": 7}
    with pytest.raises(sb.FormulationError, match="lambda_tie_1 is defined twice") as caught:
        sb.form_equations(sb.Model("m", model.elements, parameters=values))
    assert caught.value.problems[0].code == "equations.name_clash"
