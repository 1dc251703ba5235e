"""The fault checklist, K: robots in URDF. One test a row; the number is the row's.

Which line a fault is told with stands in the robot files and is tested with the format.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.errors import FormatError, ModelError, SymbodyError
from symbody.formats import model_from_urdf
from symbody.formats.urdf.file.meshes import find_mesh
from symbody.formats.urdf.file.robot_reading import read_urdf
from tests.effort import limited
from tests.faults.refusals import refused
from tests.formats.urdf.robots import arm, joint, link, robot

FILES = Path(__file__).parent / "robot_files"


def refused_robot(name: str) -> set[str]:
    """Return the codes a robot file is refused with; each names the file and a line."""
    path = FILES / f"{name}.urdf"
    found = refused(lambda: sb.load_urdf(path), SymbodyError)
    assert all(where.partition(":")[0].endswith(path.name) or ".urdf:" in where for _, where in found)
    return {code for code, _ in found}


@pytest.mark.parametrize("name", ["doctype", "external_entity", "undeclared_entity"])
def test_row_114_no_document_types_no_entities(name: str) -> None:
    with limited(2):
        assert refused_robot(name)


@pytest.mark.parametrize(
    "name",
    ["nameless_robot", "nameless_link", "duplicate_link", "missing_child", "missing_parent", "two_roots", "two_parents",
     "self_joint", "cycle", "cycle_of_all"],
)  # fmt: skip
def test_row_115_structure(name: str) -> None:
    assert refused_robot(name)


def test_row_116_links_and_joints_have_names_of_their_own() -> None:
    model = model_from_urdf(robot(link("A"), link("B"), joint("B", "revolute", "A", "B")))
    assert len(model.joints) == 1 and {body.name for body in model.bodies} >= {"B"}


def test_row_117_defaults_are_those_of_the_specification_and_told() -> None:
    model = model_from_urdf(robot('<link name="base"/>', '<link name="A"/>', link("B"),
                                  joint("q", "revolute", "base", "A"), joint("p", "revolute", "A", "B")))  # fmt: skip
    notes = " | ".join(model.notes)
    assert "without <axis> has 1 0 0" in notes and "no <limit>" in notes and "massless" in notes
    w = sb.compile(sb.form_equations(model), "frame w B ground ground")
    assert w(0.0, np.zeros(2), np.array([1.0, 2.0]), np.zeros(2)) == pytest.approx([3.0, 0.0, 0.0])


def test_row_118_an_axis_without_direction() -> None:
    assert refused_robot("zero_axis")
    assert model_from_urdf(arm("fixed", '<axis xyz="0 0 0"/>')).joints == ()


@pytest.mark.parametrize("kind", ["floating", "planar", "continuous"])
def test_row_119_types_of_joints(kind: str) -> None:
    axis = "" if kind == "floating" else '<axis xyz="0 0 1"/>'
    freedoms = {"floating": 6, "planar": 3, "continuous": 1}[kind]
    assert len(sb.form_equations(model_from_urdf(arm(kind, axis))).speed_names) == freedoms


@pytest.mark.parametrize("name", ["mimic_circle", "mimic_itself", "mimic_nobody", "mimic_fixed"])
def test_row_119_followers_of_nobody(name: str) -> None:
    assert refused_robot(name)


def test_row_119_chains_of_followers() -> None:
    text = robot('<link name="base"/>', *map(link, "ABC"), joint("a", "revolute", "base", "A"),
                 joint("b", "revolute", "A", "B", '<mimic joint="a" multiplier="2"/>'),
                 joint("c", "revolute", "B", "C", '<mimic joint="b" multiplier="3" offset="0.1"/>'))  # fmt: skip
    state = sb.assemble(sb.form_equations(model_from_urdf(text)), {"a": 0.2})
    assert state.q["b"] == pytest.approx(0.4) and state.q["c"] == pytest.approx(1.3)


@pytest.mark.parametrize(
    "name", ["nan_axis", "infinite", "half_number", "decimal_comma", "two_numbers", "four_numbers", "degrees"]
)
def test_row_120_numbers(name: str) -> None:
    assert refused_robot(name)


@pytest.mark.parametrize("name", ["xacro_macro", "xacro_number"])
def test_row_121_macros_are_run_first(name: str) -> None:
    with pytest.raises((FormatError, ModelError), match="xacro"):
        sb.load_urdf(FILES / f"{name}.urdf")


def test_row_122_meshes_are_found_in_known_folders_without_the_network(tmp_path: Path) -> None:
    (tmp_path / "robot" / "meshes").mkdir(parents=True)
    (tmp_path / "robot" / "meshes" / "a b.stl").write_text("solid")
    (tmp_path / "secret.stl").write_text("solid")
    path = tmp_path / "robot" / "r.urdf"
    addresses = ["package://robot/meshes/a b.stl", "meshes/a b.stl", "http://example.org/a.stl",
                 "package://nobody/a.stl"]  # fmt: skip
    shapes = "".join(f'<visual><geometry><mesh filename="{one}"/></geometry></visual>' for one in addresses)
    path.write_text(robot(f'<link name="A">{shapes}</link>'))
    read = read_urdf(path)
    found = [find_mesh(read, shape) is not None for shape in read.links["A"].visuals]
    assert found == [True, True, False, False]
    assert sb.load_urdf(path, floating_base=True).name == "r"  # meshes that are missing hinder nothing


def test_row_123_a_mesh_that_lies_about_its_size_costs_nothing(tmp_path: Path) -> None:
    (tmp_path / "lie.stl").write_bytes(bytes(80) + struct.pack("<I", 4_000_000_000))
    shape = '<visual><geometry><mesh filename="lie.stl"/></geometry></visual>'
    path = tmp_path / "r.urdf"
    path.write_text(
        robot('<link name="base"/>', f'<link name="A">{shape}</link>', joint("q", "revolute", "base", "A"))
    )
    with limited(2):  # meshes are named, not read
        sb.load_urdf(path)


def test_row_124_lumped_links_keep_their_names() -> None:
    text = robot('<link name="base"/>', link("A"), link("tool"), joint("q", "revolute", "base", "A"),
                 joint("grip", "fixed", "A", "tool", '<origin xyz="0 0 0.5"/>'))  # fmt: skip
    eqs = sb.form_equations(model_from_urdf(text))
    r = sb.compile(eqs, "frame r A.tool ground ground")
    assert r(0.0, np.zeros(1), np.zeros(1), np.zeros(1)) == pytest.approx([0, 0, 0.5])
