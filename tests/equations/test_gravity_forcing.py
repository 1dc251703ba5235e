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
