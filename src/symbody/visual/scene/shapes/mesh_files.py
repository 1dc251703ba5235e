"""Meshes from files: STL, OBJ, glTF, GLB, DAE; read by trimesh, which the extra `meshes` installs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from symbody.errors import EnvironmentFault, FormatError, Problem
from symbody.visual.scene.scene import Floats, SceneMesh

SUFFIXES: Final = frozenset({".stl", ".obj", ".gltf", ".glb", ".dae"})
# Meshes with more triangles are made coarser, so that pages stay small.
MOST_TRIANGLES: Final = 20_000
# Edges between triangles that are bent by more than this stay sharp [rad].
_SHARP: Final = 0.6
_FLAT: Final = 1e-3  # less than this and faces are one plane [rad]
_LARGE: Final = 10.0  # the part of a mesh that a flat face has at least to stay flat at its borders
_LARGEST_FILE: Final = 200_000_000


def read_meshes(path: Path) -> list[tuple[SceneMesh, str]]:
    """Return the triangles of a file with their colours, a mesh for each colour, in the order of the file.

    Lengths are in metres where the file has a unit; vertices that coincide are one. The colour is
    ``"#rrggbb"``, empty where the file gives none.

    Raises
    ------
    FormatError
        If there is no such file, or it is not a mesh of a format that is read.
    EnvironmentFault
        If the packages that read it are not installed.
    """
    where = str(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise FormatError(
            Problem("scene.mesh_format", where, f"{suffix or 'no suffix'} is not a supported mesh format", "",
                    "convert the file to stl, obj, glb, gltf or dae")
        )  # fmt: skip
    _check_file(path, where)
    trimesh = _trimesh(where, suffix)
    parts = _load(trimesh, where)
    share = MOST_TRIANGLES / sum(len(mesh.faces) for mesh, _ in parts)
    if share < 1.0:
        parts = [(_coarser(mesh, share), color) for mesh, color in parts]
    return [
        (
            split_at_edges(
                np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
            ),
            color,
        )
        for mesh, color in parts
    ]


def split_at_edges(vertices: Floats, triangles: NDArray[np.int64]) -> SceneMesh:
    """Return a mesh whose sharp edges have vertices of their own on each side, as smooth shading needs them.

    So have the borders of large flat faces, which would look bent where they meet a rounding.
    """
    pairs = _neighbours(triangles)
    first, second, third = (vertices[triangles[:, k]] for k in range(3))
    cross = np.asarray(np.cross(second - first, third - first), dtype=np.float64)
    doubled = np.linalg.norm(cross, axis=1)
    normals = cross / np.where(doubled > 0.0, doubled, 1.0)[:, np.newaxis]
    cosines = np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])
    flat = pairs[cosines > np.cos(_FLAT)]
    plane = _groups(flat, len(triangles))
    is_large = np.bincount(plane, doubled)[plane] > doubled.sum() / _LARGE
    smooth = pairs[(cosines > np.cos(_SHARP)) & ~is_large[pairs].any(axis=1)]
    patch = _groups(np.concatenate([flat, smooth]), len(triangles))
    keys = np.repeat(patch, 3) * len(vertices) + triangles.reshape(-1)
    corners, place = np.unique(keys, return_inverse=True)
    return SceneMesh(vertices[corners % len(vertices)], place.reshape(-1, 3).astype(np.int32))


def _neighbours(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the pairs (P, 2) of triangles with a common edge that no third one has."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys = (sides[:, 0] << 32) | sides[:, 1]
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    first = first[counts == 2]
    return np.stack([order[first], order[first + 1]], axis=1) // 3


def _groups(pairs: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return for each of `count` things the number of the group that pairs connect it to."""
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def stretch_mesh(mesh: SceneMesh, factors: Floats) -> SceneMesh:
    """Return a mesh with other lengths along x, y and z; one that is mirrored keeps its outside."""
    triangles = mesh.triangles if np.prod(factors) > 0.0 else mesh.triangles[:, ::-1]
    return SceneMesh(mesh.vertices * factors, triangles)


def _trimesh(where: str, suffix: str) -> Any:
    """Return the package that reads meshes."""
    try:
        import trimesh

        if suffix == ".dae":
            import collada  # noqa: F401
    except ImportError as error:
        what = f"the package {error.name}, which reads {suffix} files, is not installed"
        problem = Problem("scene.no_meshes", where, what, "", 'pip install "symbody[meshes]"')
        raise EnvironmentFault(problem) from error
    return trimesh


def _coarser(mesh: Any, share: float) -> Any:
    """Return a mesh with a share of its triangles; without the package that does it, all of them."""
    try:
        return mesh.simplify_quadric_decimation(face_count=max(int(share * len(mesh.faces)), 4))
    except (ImportError, ModuleNotFoundError):
        return mesh


def _check_file(path: Path, where: str) -> None:
    """Refuse a file that is not there, or too large to be looked at."""
    try:
        size = path.stat().st_size if path.is_file() else -1
    except (OSError, ValueError):  # a name that no file can have
        size = -1
    if size < 0:
        raise FormatError(
            Problem("scene.mesh_missing", where, "there is no such file", "", "check the path of the mesh")
        )
    if size > _LARGEST_FILE:
        raise FormatError(
            Problem("scene.mesh_large", where, f"the file has {size / 1e6:.0f} MB", "",
                    "reduce the mesh in the program that created it")
        )  # fmt: skip


def _load(trimesh: Any, where: str) -> list[tuple[Any, str]]:
    """Return the meshes of a file as trimesh holds them, in metres, one for each colour."""
    try:
        scene = trimesh.load_scene(where, process=True)
        scale = 1.0 if scene.units is None else trimesh.units.unit_conversion(scene.units, "meters")
        groups: dict[str, list[Any]] = {}
        for mesh in scene.dump():
            if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
                groups.setdefault(_color_of(mesh), []).append(mesh)
        parts = [(trimesh.util.concatenate(meshes), color) for color, meshes in groups.items()]
        for mesh, _ in parts:
            mesh.apply_scale(scale)
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
        is_good = bool(parts) and all(bool(np.all(np.isfinite(mesh.vertices))) for mesh, _ in parts)
    except Exception as error:  # readers of its formats raise whatever comes
        raise FormatError(
            Problem("scene.mesh_unreadable", where, "the file cannot be read as a mesh",
                    f"{type(error).__name__}: {error}"[:200],
                    "export it again from the program that created it")
        ) from error  # fmt: skip
    if not is_good:
        raise FormatError(
            Problem("scene.mesh_empty", where, "the file has no triangles, or its coordinates are not "
                                               "finite", "",
                    "export it again, with its surfaces")
        )  # fmt: skip
    return parts


def _color_of(mesh: Any) -> str:
    """Return the colour of a mesh's material or, if it has one, of all its faces; empty without."""
    kind = mesh.visual.kind
    if kind == "texture":
        rgba = mesh.visual.material.main_color
    elif kind in ("face", "vertex"):
        rgba = mesh.visual.main_color
    else:
        return ""
    return "#" + "".join(f"{int(share):02x}" for share in rgba[:3])
