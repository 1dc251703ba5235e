"""Shapes, limits and meshes: no influence on the motion, and not lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from symbody.formats import find_mesh, read_urdf, robot_from_text
from tests.formats.urdf.robots import joint, robot

VISUAL = '<visual name="v"><origin xyz="1 0 0"/><geometry>{0}</geometry><material name="red"/></visual>'
RED = '<material name="red"><color rgba="1 0 0 0.5"/></material>'


@pytest.mark.parametrize(
    ("form", "kind", "sizes"),
    [
        ('<box size="1 2 3"/>', "box", (1, 2, 3)),
        ('<cylinder radius="1" length="2"/>', "cylinder", (1, 2)),
        ('<sphere radius="2"/>', "sphere", (2,)),
        ('<mesh filename="a.stl" scale="2 2 2"/>', "mesh", (2, 2, 2)),
    ],
)
def test_shapes_are_kept(form: str, kind: str, sizes: tuple[int, ...]) -> None:
    (shape,) = robot_from_text(robot(RED, f'<link name="A">{VISUAL.format(form)}</link>')).links["A"].visuals
    assert (shape.kind, shape.sizes, shape.origin.at, shape.name) == (kind, sizes, (1, 0, 0), "v")
    assert shape.color is not None and [float(c) for c in shape.color] == [1, 0, 0, 0.5]


def test_limits_are_kept() -> None:
    limit = '<limit lower="-1" upper="2" effort="30" velocity="4"/>'
    found = robot_from_text(
        robot('<link name="a"/><link name="b"/>', joint("q", "revolute", "a", "b", limit))
    )
    limits = found.joints["q"].limit
    assert limits is not None and (limits.lower, limits.upper, limits.effort, limits.velocity) == (
        -1,
        2,
        30,
        4,
    )


@pytest.mark.parametrize(
    ("address", "found"),
    [
        ("meshes/a b.stl", True), ("package://arm/meshes/a b.stl", True), ("model://arm/meshes/a b.stl", True),
        ("http://example.org/a.stl", False), ("package://leg/a.stl", False), ("a\0.stl", False), ("", False),
    ],
)  # fmt: skip
def test_meshes_are_found_by_address(address: str, found: bool, tmp_path: Path) -> None:
    folder = tmp_path / "arm" / "meshes"
    folder.mkdir(parents=True)
    (folder / "a b.stl").write_text("solid")
    path = folder.parent / "r.urdf"
    path.write_text(robot(f'<link name="A">{VISUAL.format(f"<mesh filename={chr(34)}x{chr(34)}/>")}</link>'))
    robot_read = read_urdf(path)
    (shape,) = robot_read.links["A"].visuals
    moved = type(shape)(shape.name, shape.origin, "mesh", shape.sizes, address)
    assert (find_mesh(robot_read, moved) == folder / "a b.stl") is found
    if found:
        assert find_mesh(robot_read, moved, {"arm": tmp_path / "nowhere"}) is not None
