"""Meshes from files."""

from __future__ import annotations

import builtins
import struct
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.errors import EnvironmentFault, FormatError
from symbody.visual.scene import make_scene
from symbody.visual.scene.shapes.mesh_files import MOST_TRIANGLES, read_meshes, split_at_edges

trimesh = pytest.importorskip("trimesh")

ASCII = """\
solid one
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 2 0
endloop
endfacet
endsolid one
"""


def write_box(path: Path) -> Path:
    trimesh.creation.box((1.0, 2.0, 3.0)).export(path)
    return path


def test_stl_in_text(tmp_path: Path) -> None:
    path = tmp_path / "one.stl"
    path.write_text(ASCII)
    ((mesh, color),) = read_meshes(path)
    assert color == ""
    assert np.allclose(mesh.vertices.max(axis=0), (1, 2, 0)) and mesh.triangles.shape == (1, 3)


def test_stl_in_bytes(tmp_path: Path) -> None:
    path = tmp_path / "one.STL"
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", 1) + facet)
    ((mesh, _),) = read_meshes(path)
    assert np.allclose(mesh.vertices.max(axis=0), (1, 2, 0))


@pytest.mark.filterwarnings("ignore:Setting the shape on a NumPy array:DeprecationWarning")  # in pycollada
@pytest.mark.parametrize("suffix", ["stl", "obj", "glb", "gltf", "dae"])
def test_formats(suffix: str, tmp_path: Path) -> None:
    if suffix == "dae":
        pytest.importorskip("collada")
    path = tmp_path / f"box.{suffix}"
    if suffix == "gltf":  # several files, which its export leaves open
        files = trimesh.exchange.gltf.export_gltf(trimesh.creation.box((1.0, 2.0, 3.0)).scene())
        for name, content in files.items():
            (tmp_path / name).write_bytes(content)
        path = tmp_path / next(name for name in files if name.endswith(".gltf"))
    else:
        write_box(path)
    ((mesh, _),) = read_meshes(path)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (1, 2, 3)) and len(mesh.triangles) == 12
    corners = mesh.vertices[mesh.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert np.isclose(volume, 6)  # outsides are outside
    assert len(mesh.vertices) == 24  # edges of a box are sharp


def test_large_meshes_are_made_coarser(tmp_path: Path) -> None:
    pytest.importorskip("fast_simplification")
    trimesh.creation.icosphere(subdivisions=6).export(tmp_path / "ball.stl")
    ((mesh, _),) = read_meshes(tmp_path / "ball.stl")
    assert len(mesh.triangles) <= MOST_TRIANGLES
    assert np.allclose(np.linalg.norm(mesh.vertices, axis=1), 1, atol=0.01)


def test_parts_keep_the_colours_of_their_materials(tmp_path: Path) -> None:
    red, blue = ([200, 30, 20, 255], [10, 40, 160, 255])
    scene = trimesh.Scene()
    for place, rgba in enumerate((red, blue, red)):
        box = trimesh.creation.box(
            (1.0, 1.0, 1.0), transform=trimesh.transformations.translation_matrix((2 * place, 0, 0))
        )
        box.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(baseColorFactor=rgba)
        )
        scene.add_geometry(box)
    scene.export(tmp_path / "boxes.glb")
    parts = read_meshes(tmp_path / "boxes.glb")
    assert [(len(mesh.triangles), color) for mesh, color in parts] == [(24, "#c81e14"), (12, "#0a28a0")]
    drawn = make_scene(arm(tmp_path / "boxes.glb")).bodies[1].solids
    assert [solid.color for solid in drawn] == ["#c81e14", "#0a28a0"]
    painted = make_scene(arm(tmp_path / "boxes.glb", color="#ffffff")).bodies[1].solids
    assert {solid.color for solid in painted} == {"#ffffff"}  # what the model says wins


def arm(path: str | Path, **more: object) -> sb.Model:
    return sb.Model("m", [sb.Body("Arm", 1, shapes=[sb.Mesh(path, **more)])])


def test_meshes_are_stretched_and_mirrored(tmp_path: Path) -> None:
    write_box(tmp_path / "box.stl")
    scene = make_scene(arm("box.stl", folder=str(tmp_path), scale=(1, 1, "-2")))
    assert scene.notes == () and np.allclose(np.ptp(scene.meshes[0].vertices, axis=0), (1, 2, 6))
    corners = scene.meshes[0].vertices[scene.meshes[0].triangles]
    assert np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() > 0


def test_a_mesh_that_stands_twice_is_kept_once(tmp_path: Path) -> None:
    path = write_box(tmp_path / "box.stl")
    shapes = [sb.Mesh(path), sb.Mesh(path, at=(1, 0, 0))]
    scene = make_scene(sb.Model("m", [sb.Body("Arm", 1, shapes=shapes)]))
    assert len(scene.meshes) == 1 and [solid.mesh for solid in scene.bodies[1].solids] == [0, 0]


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("none.stl", None, "scene.mesh_missing"),
        ("part.step", "ISO-10303-21;", "scene.mesh_format"),
        ("empty.stl", "solid nothing\nendsolid nothing\n", "scene.mesh_empty"),
        ("broken.glb", "glTF, but not really", "scene.mesh_unreadable"),
    ],
)
def test_a_box_stands_for_what_is_no_mesh(name: str, content: str | None, code: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(FormatError) as caught:
        read_meshes(path)
    assert [problem.code for problem in caught.value.problems] == [code]
    scene = make_scene(arm(path))
    assert scene.bodies[1].solids[0].kind == "box"
    assert len(scene.notes) == 1 and "Arm" in scene.notes[0] and name in scene.notes[0]


def test_without_the_package_the_cure_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_box(tmp_path / "box.stl")
    plain = builtins.__import__

    def without(name: str, *rest: object) -> object:
        if name == "trimesh":
            raise ImportError("No module named 'trimesh'", name="trimesh")
        return plain(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(EnvironmentFault, match=r"symbody\[meshes\]"):
        read_meshes(path)
    assert "symbody[meshes]" in make_scene(arm(path)).notes[0]


def test_sharp_edges_have_vertices_of_their_own() -> None:
    box = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([[q[0], q[k], q[k + 1]] for q in quads for k in (1, 2)])
    split = split_at_edges(box, triangles)
    assert len(split.vertices) == 24  # four for each face
    np.testing.assert_array_equal(split.vertices[split.triangles], box[triangles])
    sphere = pytest.importorskip("trimesh").creation.icosphere(3)
    assert len(split_at_edges(sphere.vertices, sphere.faces).vertices) == len(sphere.vertices)
