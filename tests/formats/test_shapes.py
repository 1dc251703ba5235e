"""Shapes in model files and in URDF."""

from __future__ import annotations

from pathlib import Path

import pytest

import symbody as sb
from symbody.errors import FormatError, ModelError
from symbody.formats.native import from_data, model_from_toml, model_to_toml, to_data

TEXT = """\
name = "arm"      # title
[parameters]
L = 2

[[ground.shape]]
type = "box"
size = [10, 10, 0.1]
opacity = 0.3

[[body]]
name = "Arm"
mass = 1

[[body.shape]]      # the tube
type = "cylinder"
radius = 0.1
length = "L"
rotate = [["y", "90 deg"]]

[[body.shape]]
type = "mesh"
path = "parts/arm.stl"
scale = 0.001
color = "orange"

[[joint]]
name = "j"
type = "revolute"
between = ["ground", "Arm"]
"""


def test_shapes_are_read() -> None:
    model = model_from_toml(TEXT, "models/arm.toml")
    tube, part = model.body("Arm").shapes
    assert isinstance(tube, sb.Cylinder) and tube.length.text == "L"
    assert isinstance(part, sb.Mesh) and part.place == "models/parts/arm.stl"
    assert [factor.text for factor in part.scale] == ["0.001"] * 3
    assert model.ground_shapes == (sb.Box((10, 10, 0.1), opacity=0.3),)


def test_text_and_data_hold_shapes() -> None:
    model = model_from_toml(TEXT)
    assert model_from_toml(model_to_toml(model)) == model
    assert from_data(to_data(model)) == model
    assert to_data(model)["body"][0]["shape"][1]["path"] == "parts/arm.stl"


def test_every_shape_comes_back() -> None:
    shapes = [
        sb.Box((1, "a", 2), color="#aabbcc"), sb.Cylinder("a", 1, at=(1, 2, "a")), sb.Sphere(1, opacity="a/2"),
        sb.Capsule(1, 2, matrix=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]), sb.Cone(1, 2, rotate=[((0, 1, 1), "a")]),
        sb.Mesh("x.obj", scale=(1, "a", 1)),
    ]  # fmt: skip
    body = sb.Body("B", 1, shapes=shapes)
    model = sb.Model("m", [body], parameters={"a": 1}, ground_shapes=shapes)
    assert model_from_toml(model_to_toml(model)) == model


def test_a_change_keeps_comments_beside_shapes() -> None:
    model = model_from_toml(TEXT)
    tube, part = model.body("Arm").shapes
    changed = sb.Model(
        "arm", [sb.Body("Arm", 3, shapes=[sb.Cylinder(0.2, "L", rotate=tube.rotate), part]), *model.joints],
        parameters={"L": 2}, ground_shapes=model.ground_shapes,
    )  # fmt: skip
    text = model_to_toml(changed, onto=TEXT)
    assert text == TEXT.replace("mass = 1", "mass = 3").replace("radius = 0.1", "radius = 0.2")
    fewer = sb.Model("arm", [sb.Body("Arm", 1), *model.joints], parameters={"L": 2})
    again = model_to_toml(fewer, onto=TEXT)
    assert "# title" in again and model_from_toml(again) == fewer


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('type = "box"', 'type = "bx"', 5, "did you mean 'box'"),
        ('type = "box"\n', "", 5, 'add type = "box"'),
        ("radius = 0.1", "radius = true", 16, "body Arm, shape[0].radius"),
        ("radius = 0.1", "radios = 0.1", 16, "did you mean 'radius'"),
        ('length = "L"\n', "", 14, "add length = .."),
        ("scale = 0.001", "scale = [1, 2]", 23, "a number, or three"),
    ],
)
def test_misfits_are_refused_with_their_line(old: str, new: str, line: int, words: str) -> None:
    with pytest.raises(FormatError) as caught:
        model_from_toml(TEXT.replace(old, new), "arm.toml")
    assert f"arm.toml:{line}, " in str(caught.value) and words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("radius = 0.1", 'radius = "r"', 16, "body Arm, shape[0].radius"),
        ("radius = 0.1", 'radius = "L - 3"', 16, "the length is -1 m"),
        ("opacity = 0.3", 'color = "orang"', 8, "ground.shape[0].color"),
        ("opacity = 0.3", "opacity = 3", 8, "from 0 to 1"),
        ('"orange"', '"#12"', 24, "is not a colour"),
    ],
)
def test_impossible_shapes_are_refused_with_their_line(old: str, new: str, line: int, words: str) -> None:
    with pytest.raises(ModelError) as caught:
        model_from_toml(TEXT.replace(old, new), "arm.toml")
    assert f"arm.toml:{line}, " in str(caught.value) and words in str(caught.value)


def test_saving_elsewhere_keeps_meshes_in_reach(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(TEXT)
    (tmp_path / "copies").mkdir()
    sb.save_model(sb.load_model(tmp_path / "arm.toml"), tmp_path / "copies" / "arm.toml")
    part = sb.load_model(tmp_path / "copies" / "arm.toml").body("Arm").shapes[1]
    assert isinstance(part, sb.Mesh) and part.path == "../parts/arm.stl"


ROBOT = """\
<robot name="r">
  <material name="blue"><color rgba="0 0 1 0.5"/></material>
  <link name="base">
    <visual><origin xyz="0 0 0.1"/><geometry><box size="1 1 0.2"/></geometry><material name="blue"/></visual>
  </link>
  <link name="arm">
    <inertial><origin xyz="0.5 0 0"/><mass value="2"/>
      <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0.5 0 0" rpy="0 1.5707963267948966 0"/>
      <geometry><cylinder radius="0.05" length="1"/></geometry></visual>
    <visual><geometry><mesh filename="package://kit/m/arm.stl" scale="0.1 0.1 0.1"/></geometry></visual>
    <visual><geometry><sphere radius="-1"/></geometry></visual>
  </link>
  <link name="hand">
    <visual><geometry><sphere radius="0.1"/></geometry></visual>
  </link>
  <joint name="wrist" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="1 0 0"/></joint>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>
"""


def urdf(folder: Path) -> sb.Model:
    (folder / "kit" / "m").mkdir(parents=True)
    (folder / "kit" / "m" / "arm.stl").write_text("solid")
    (folder / "r.urdf").write_text(ROBOT)
    return sb.load_urdf(folder / "r.urdf")


def test_visuals_of_a_robot_are_shapes(tmp_path: Path) -> None:
    model = urdf(tmp_path)
    (box,) = model.ground_shapes
    assert (box.color, box.opacity.text) == ("#0000ff", "0.5")
    tube, mesh, hand = model.body("arm").shapes
    assert isinstance(tube, sb.Cylinder) and [x.text for x in tube.at] == ["0", "0", "0"]
    assert tube.rotate[0][1].text == "pi/2"
    assert isinstance(mesh, sb.Mesh) and mesh.path == "kit/m/arm.stl" and mesh.at[0].text == "-0.5"
    assert isinstance(hand, sb.Sphere) and hand.at[0].text == "0.5"  # of a link that is fixed on the arm
    assert any("visual" in note for note in model.notes)


def test_shapes_are_written_as_visuals(tmp_path: Path) -> None:
    model = urdf(tmp_path)
    (tmp_path / "copies").mkdir()
    sb.save_urdf(model, tmp_path / "copies" / "r.urdf")
    again = sb.load_urdf(tmp_path / "copies" / "r.urdf")
    assert again.ground_shapes == model.ground_shapes
    tube, mesh, hand = again.body("arm").shapes
    assert tube == model.body("arm").shapes[0] and hand == model.body("arm").shapes[2]
    assert isinstance(mesh, sb.Mesh) and mesh.path == "../kit/m/arm.stl"
