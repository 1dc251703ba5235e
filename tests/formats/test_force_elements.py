"""Torsion springs, bushings, laws and curves in files: read, written, read again; faults with their place."""

from __future__ import annotations

import pytest

from symbody.errors import SymbodyError
from symbody.formats import model_from_toml, model_to_toml
from symbody.model import Bushing, Curve, TorsionSpring

TEXT = """
name = "elements"
[parameters]
k = 2
[[body]]
name = "A"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "pin"
type = "revolute"
between = ["ground", "A"]
coordinate = "q"
torque = { law = { x = [0, 1, 2.5], y = [0, "-1", -3], kind = "pchip" } }
[[joint]]
name = "rubber"
type = "bushing"
between = ["ground", "A"]
stiffness = ["k", "k", "k", 1, 1, 1]
damping = [
  [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0],
  [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1],
]
[[spring]]
name = "line"
between = ["ground", "A"]
law = "-k*length^3"
[[torsion_spring]]
name = "spiral"
between = ["ground", "A"]
axis = "z"
stiffness = "k"
free = "30 deg"
law = { x = [0, 1], y = [0, 1], outside = "slope" }
"""


def test_what_is_written_is_read_again() -> None:
    model = model_from_toml(TEXT)
    assert model_from_toml(model_to_toml(model)) == model
    rubber = next(element for element in model.elements if element.name == "rubber")
    assert isinstance(rubber, Bushing) and [joint.name for joint in model.joints] == ["pin"]
    spiral = next(element for element in model.elements if element.name == "spiral")
    assert isinstance(spiral, TorsionSpring) and spiral.law == Curve([0, 1], [0, 1], outside="slope")
    assert model.joint("pin").drives["q"].law == Curve([0, 1, 2.5], [0, -1, -3], kind="pchip")


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ('y = [0, "-1", -3]', 'y = [0, "-1"]', "model.curve_length", "torque.law"),
        ('y = [0, "-1", -3]', 'y = [0, "k", -3]', "model.curve_number", "torque.law.y[1]"),
        ("x = [0, 1, 2.5]", "x = [0, 1, 1]", "model.curve_order", "torque.law.x[2]"),
        ('kind = "pchip"', 'kind = "cubic"', "model.curve_kind", "torque.law.kind"),
        ('outside = "slope"', 'beyond = "slope"', "model.curve_words", "law"),
        ('["k", "k", "k", 1, 1, 1]', '["k", "k", "k"]', "file.wrong_type", "stiffness"),
        ('"-k*length^3"', '"-k*lenght^3"', "names.unknown", "law"),
        ("k = 2", "k = 2\nlength = 1", "names.shadowed", "law"),
        ('between = ["ground", "A"]\nstiffness = ["k"', 'between = ["A", "A"]\nstiffness = ["k"',
         "model.self_joint", "between"),
        ('axis = "z"', "axis = [0, 0, 0]", "model.zero_axis", "axis"),
    ],
)  # fmt: skip
def test_faults_are_named_with_their_place(old: str, new: str, code: str, place: str) -> None:
    assert old in TEXT
    with pytest.raises(SymbodyError) as caught:
        model_from_toml(TEXT.replace(old, new))
    found = [problem.where.split(", ") for problem in caught.value.problems if problem.code == code]
    assert any(place in words for words in found)
    assert all(problem.fix for problem in caught.value.problems)
