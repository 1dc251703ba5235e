"""The output "gravity_forcing" is what the forcing loses where gravity is switched off."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from tests.tiers import cases

EXAMPLES = Path(__file__).parents[2] / "examples"


def forces(eqs: sb.EquationSet, output: str, t: float, q: Any, u: Any) -> Any:
    return sb.compile(eqs, output)(t, q, u, np.zeros(len(eqs.input_names)))


@pytest.mark.parametrize(
    "name", cases(["four_bar", "bicycle", "spinning_top_omega", "rr_robot"], fast=["four_bar", "rr_robot"])
)
@pytest.mark.parametrize("formulation", [sb.VirtualWork(), sb.Lagrange(), None], ids=repr)
def test_it_is_the_part_of_gravity(name: str, formulation: Formulation | None) -> None:
    model = sb.load_model(EXAMPLES / name / f"{name}.toml")
    without = sb.Model(
        model.name, model.elements, parameters=model.parameters, inputs=model.inputs, ground=model.ground,
    )  # fmt: skip
    heavy, light = (sb.form_equations(one, formulation) for one in (model, without))
    draw = np.random.default_rng(1)
    q, u = draw.normal(size=len(heavy.coordinate_names)), draw.normal(size=len(heavy.speed_names))
    for place in heavy.quaternions:
        rows = [heavy.coordinate_names.index(part) for part in place]
        q[rows] /= np.linalg.norm(q[rows])
    weights = forces(heavy, "gravity_forcing", 0.3, q, u)
    difference = forces(heavy, "forcing", 0.3, q, u) - forces(light, "forcing", 0.3, q, u)
    np.testing.assert_allclose(weights, difference, atol=1e-9 * np.abs(difference).max())
    assert np.abs(forces(light, "gravity_forcing", 0.3, q, u)).max() == 0.0


def test_it_holds_an_arm_at_rest() -> None:
    model = sb.load_model(EXAMPLES / "rr_robot" / "rr_robot.toml")
    eqs = sb.form_equations(model)
    run = sb.simulate(eqs, 0.1)
    assert run["gravity_forcing"].shape == (len(eqs.speed_names), run.t.size)
    text = sb.generate_code(eqs, ["gravity_forcing"], language="python")
    assert "gravity_forcing" in text


def test_one_coordinate_alone() -> None:
    model = sb.load_model(EXAMPLES / "rr_robot" / "rr_robot.toml")
    eqs = sb.form_equations(model)
    names = [name.removesuffix("_dot") for name in eqs.speed_names]
    run = sb.simulate(eqs, 0.1, times=[0.0, 0.1])
    alone = np.array([run[f"gravity_forcing {name}"] for name in names])
    np.testing.assert_array_equal(alone, run["gravity_forcing"])
    assert [run.units[f"gravity_forcing {name}"] for name in names] == ["N m"] * len(names)
    assert run[f"-'gravity_forcing {names[0]}'"].shape == run.t.shape
    with pytest.raises(sb.FormulationError, match="equations.unknown_speed") as caught:
        eqs.roots("gravity_forcing nothing")
    assert names[0] in caught.value.problems[0].fix


def test_a_law_that_compensates_weights_keeps_an_arm_at_rest() -> None:
    arm = sb.Body("Arm", mass=2, inertia=(0, 0, 1), frames={"pin": sb.Frame(at=(-1, 0, 0))})
    pin = sb.Revolute("pin", "ground", "Arm.pin", coordinate="theta", torque=sb.Drive(applied="T"))
    model = sb.Model("arm", [arm, pin], (0, -9.81, 0), inputs=["T"], initial={"theta": 0.3})
    eqs = sb.form_equations(model)
    run = sb.simulate(eqs, 10.0, inputs={"T": "-'gravity_forcing theta'"}, times=[0.0, 10.0])
    # Both are one formula with opposite signs: what rounding leaves of 19 N m moves 3 kg m^2 by 1e-13 in 10 s.
    assert abs(run["theta"][-1] - 0.3) < 1e-12
    assert run["T"][0] == pytest.approx(2 * 9.81 * np.cos(0.3), rel=1e-14)
