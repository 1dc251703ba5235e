"""`Limits` of joints and `Backlash` of gears as descriptions: names, faults, parts, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.formats import model_from_toml, model_from_urdf, model_to_toml


def rail(limits: Any, **others: Any) -> sb.Prismatic:
    return sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), coordinate="x", limits=limits, **others)


def sleeve(limits: Any) -> sb.Cylindrical:
    body = sb.Body("Rod", mass=1, inertia=(1, 1, 1))
    return sb.Cylindrical("sleeve", "ground", body, coordinates=["phi", "s"], limits=limits)


def test_rigid_ends_are_stops_named_after_joint_and_end() -> None:
    model = sb.Model("m", [rail({"low": 0, "high": "L", "rigid": True, "restitution": "e"})],
                     parameters={"L": 1, "e": 0.5})  # fmt: skip
    low, high = model.constraints
    assert (low.name, high.name) == ("rail low", "rail high")
    assert isinstance(low, sb.Stop) and low.restitution.text == "e"
    assert [element.kind for element in model.elements] == ["body", "joint"]
    assert rail({"low": 0, "high": "L", "stiffness": "k"}).stops == ()


def test_of_several_coordinates_each_has_its_own() -> None:
    both = sleeve({"s": {"high": 1, "rigid": True}, "phi": sb.Limits("-10 deg", "10 deg", stiffness=3)})
    assert [stop.name for stop in both.stops] == ["sleeve s high"]
    assert both.output_words("effort") == ("phi",)


FAULTS = [
    ({"rigid": True}, "model.limits", "no end"),
    ({"high": 1}, "model.gap_law", "rigid = true"),
    ({"high": 1, "rigid": True, "stiffness": 3}, "model.gap_law", "rigid"),
    ({"low": 2, "high": 1, "rigid": True}, "model.limits", "above high"),
    ({"low": "L", "high": "L/2", "stiffness": 3}, "model.limits", "above high"),
    ({"high": 1, "rigid": True, "restitution": 1.5}, "model.restitution", "from 0 to 1"),
    ({"high": 1, "stiffness": -1}, "contact.domain", "stiffness"),
    ({"high": 1, "stiffness": 1, "exponent": 0.5}, "contact.domain", "exponent"),
    ({"high": 1, "stiffness": 1, "restitution": 0.5}, "contact.normal", "speed"),
    ({"high": 1, "stiffness": 1, "law": "gap"}, "contact.normal", "law"),
    ({"hihg": 1, "rigid": True}, "call.unknown_argument", "high"),
    ({"high": "x", "rigid": True}, "names.not_here", "x"),
    ({"high": "10 deg", "rigid": True}, "model.not_an_angle", "deg"),
    (5, "model.not_limits", "Limits"),
]  # fmt: skip


@pytest.mark.parametrize(("limits", "code", "words"), FAULTS)
def test_faults_say_what_to_write(limits: Any, code: str, words: str) -> None:
    with pytest.raises(sb.SymbodyError) as error:
        sb.Model("m", [rail(limits)], parameters={"L": 1})
    assert code in {problem.code for problem in error.value.problems}
    assert words in str(error.value) and "limits" in str(error.value)


def test_components_of_quaternions_and_prescribed_coordinates_have_none() -> None:
    body = sb.Body("B", mass=1, inertia=(1, 1, 1))
    with pytest.raises(sb.ModelError, match="quaternion"):
        sb.Spherical("ball", "ground", body, coordinates=["q0", "q1", "q2", "q3"],
                     limits={"q0": {"high": 1, "rigid": True}})  # fmt: skip
    with pytest.raises(sb.ModelError, match="prescribed"):
        rail({"high": 1, "rigid": True}, motion="t")
    with pytest.raises(sb.ModelError, match="no coordinate"):
        sleeve({"z": {"high": 1, "rigid": True}})
    with pytest.raises(sb.ModelError, match="needs the coordinate"):
        sleeve(sb.Limits(high=1, rigid=True))


def test_a_name_of_an_end_is_not_given_twice() -> None:
    with pytest.raises(sb.ModelError, match="rail high"):
        sb.Model("m", [rail({"high": 1, "rigid": True}), sb.Stop("rail high", "1 - x")])


def test_a_part_renames_ends_with_joint_and_coordinate() -> None:
    part = sb.Model("part", [sleeve({"s": {"high": "L", "rigid": True}}), sb.Signal("room", output="gap sleeve s high")],
                    parameters={"L": 1})  # fmt: skip
    inner = sb.Model("inner", [sb.Include(part, "a")])
    whole = sb.Model("whole", [sb.Include(inner, "b")])
    (stop,) = whole.constraints
    assert stop == sb.Stop("b_a_sleeve b_a_s high", "(b_a_L) - b_a_s")
    eqs = sb.form_equations(whole)
    assert sb.assemble(eqs, {"b_a_s": 0.25})["b_a_room"] == pytest.approx(0.75)


GEARS = """
name = "gears"
gravity = [0, 0, 0]

[[body]]
name = "A"
mass = 1
inertia = [1, 1, 1]

[[body]]
name = "B"
mass = 1
inertia = [1, 1, 1]

[[joint]]
name = "a"
type = "revolute"
between = ["ground", "A"]
limits = { low = "-90 deg", high = "b", rigid = true, restitution = 0.5 }

[[joint]]
name = "sleeve"
type = "cylindrical"
between = ["ground", "B"]
coordinates = ["phi", "s"]
limits = { s = { high = 1, stiffness = "k", exponent = 1.5, damping = 2, depth = 0.1 } }

[[constraint]]
name = "mesh"
type = "gear"
coupled = ["a", "phi"]
ratio = -2
backlash = { angle = "0.5 deg", law = "1e3*gap^2" }

[parameters]
b = 1.5
k = 100
"""


def test_files_have_limits_and_backlash() -> None:
    model = model_from_toml(GEARS)
    assert model_from_toml(model_to_toml(model)) == model
    assert model_to_toml(model, onto=GEARS) == GEARS
    assert [stop.name for stop in model.constraints] == ["a low", "a high"]


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ('high = "b", rigid = true', 'high = "b", rigit = true', "file.unknown_key"),
        ('high = "b", rigid = true', 'high = "b", rigid = 1', "file.wrong_type"),
        ('{ s = { high = 1, stiffness = "k",', '{ high = 1, stiffness = "k",', "file.wrong_type"),
        ('angle = "0.5 deg", ', "", "file.missing_key"),
        ('law = "1e3*gap^2"', 'rigid = true, law = "1e3*gap^2"', "model.gap_law"),
    ],
)  # fmt: skip
def test_faults_of_files_have_codes(old: str, new: str, code: str) -> None:
    text = GEARS.replace(old, new)
    if "depth" in text and old.startswith("{ s"):
        text = text.replace("depth = 0.1 } }", "depth = 0.1 }")
    with pytest.raises(sb.SymbodyError) as error:
        model_from_toml(text)
    assert code in {problem.code for problem in error.value.problems}


def test_a_backlash_is_no_constraint_and_says_so_in_urdf(tmp_path: Path) -> None:
    wheels = [sb.Revolute(name, "ground", sb.Body(name.upper(), mass=1, inertia=(1, 1, 1))) for name in "ab"]
    model = sb.Model(
        "m", [*wheels, sb.Gear("mesh", ["a", "b"], ratio=-1, backlash={"angle": 0.1, "stiffness": 5})]
    )
    assert model.constraints == ()
    with pytest.raises(sb.SymbodyError, match="mesh"):
        sb.save_urdf(model, tmp_path / "m.urdf")
    with pytest.raises(sb.SymbodyError, match="limits"):
        sb.save_urdf(sb.Model("m", [rail({"high": 1, "rigid": True})]), tmp_path / "m.urdf")
    with pytest.raises(sb.ModelError, match="backlash"):
        sb.Gear("mesh", ["a", "b"], ratio=-1, backlash=0.1)
    with pytest.raises(sb.ModelError, match="0 or more"):
        sb.Model(
            "m", [*wheels, sb.Gear("mesh", ["a", "b"], ratio=-1, backlash={"angle": -0.1, "rigid": True})]
        )


def test_limits_of_a_robot_are_read_where_asked_for() -> None:
    text = """<robot name="r"><link name="base"/>
    <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    </link><joint name="hip" type="revolute"><parent link="base"/><child link="arm"/>
    <limit upper="1.5" effort="1" velocity="1"/></joint></robot>"""
    assert model_from_urdf(text).constraints == ()
    model = model_from_urdf(text, limits={"rigid": True, "restitution": 0.1})
    assert [(stop.name, stop.gap.text) for stop in model.constraints if isinstance(stop, sb.Stop)] == [
        ("hip low", "hip - (0)"), ("hip high", "(1.5) - hip")
    ]  # fmt: skip
    assert model_from_urdf(text, limits={"stiffness": 100}).joints[0].limits["hip"].stiffness is not None
    with pytest.raises(sb.SymbodyError, match="rigid"):
        model_from_urdf(text, limits={})
