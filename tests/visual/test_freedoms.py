"""Marks of joints follow from their laws: what rises as it turns is a screw, a curve in a plane is none."""

from __future__ import annotations

import pytest

import symbody as sb
from symbody.model.joint import Joint
from symbody.visual.scene.freedoms import joint_freedoms
from symbody.visual.scene.numbers import model_numbers
from tests.model.test_own_joint import Ellipse

SCREWS = [
    (sb.Screw("j", "ground", "Bead", 0.2, coordinate="q"), True),
    (Ellipse("j", "ground", "Bead", coordinate="q"), False),
    (sb.Revolute("j", "ground", "Bead", coordinate="q"), False),
    (sb.Cylindrical("j", "ground", "Bead", coordinates=["q", "x"]), False),
]


@pytest.mark.parametrize(("joint", "is_screw"), SCREWS, ids=lambda each: type(each).__name__)
def test_only_what_rises_is_a_screw(joint: Joint, is_screw: bool) -> None:
    model = sb.Model("m", [sb.Body("Bead", mass=1, inertia=(1, 1, 1)), joint])
    assert joint_freedoms(joint, model_numbers(model, {})).is_screw is is_screw
