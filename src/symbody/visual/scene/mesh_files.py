"""Meshes from files: STL, OBJ, glTF, GLB, DAE; read by trimesh, which the extra `meshes` installs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np

from symbody.errors import EnvironmentFault, FormatError, Problem
from symbody.visual.scene.scene import Floats, SceneMesh

SUFFIXES: Final = frozenset({".stl", ".obj", ".gltf", ".glb", ".dae"})
# Meshes with more triangles are made coarser, so that pages stay small.
MOST_TRIANGLES: Final = 20_000
# Edges between triangles that are bent by more than this stay sharp [rad].
_SHARP: Final = 0.6
_LARGEST_FILE: Final = 200_000_000


def read_mesh(path: Path) -> SceneMesh:
    """Return the triangles of a file, in metres where the file has a unit, vertices that coincide as one.

    Raises
    ------
    FormatError
        If there is no such file, or it is no mesh of a format that is read.
    EnvironmentFault
        If the packages that read it are not installed.
    """
    where = str(path)
    if path.suffix.lower() not in SUFFIXES:
        known = ", ".join(sorted(SUFFIXES))
        raise FormatError(_problem("format", where, f"{path.suffix or 'no suffix'} is no format of meshes",
                                   f"convert it to one of {known}"))  # fmt: skip
    try:
        size = path.stat().st_size if path.is_file() else -1
    except (OSError, ValueError):  # a name that no file can have
        size = -1
    if size < 0:
        raise FormatError(_problem("missing", where, "there is no such file", "check the path"))
    if size > _LARGEST_FILE:
        raise FormatError(_problem("large", where, f"the file has {size / 1e6:.0f} MB", "use a coarser mesh"))
    trimesh = _trimesh(where, path.suffix.lower())
    try:
        mesh = trimesh.load(where, force="mesh", process=True)
        if mesh.units is not None:
            mesh.apply_scale(trimesh.units.unit_conversion(mesh.units, "meters"))
        mesh.merge_vertices()
    except Exception as error:  # its readers raise whatever comes
        what = f"the mesh cannot be read: {type(error).__name__}: {error}"
        raise FormatError(
            _problem("unreadable", where, what[:300], "save it anew from the program it is of")
        ) from error
    if not len(mesh.faces) or not np.all(np.isfinite(mesh.vertices)):
        raise FormatError(_problem("empty", where, "the file has no triangles", "save it with its surfaces"))
    if len(mesh.faces) > MOST_TRIANGLES:
        mesh = _coarser(mesh)
    mesh = trimesh.graph.smooth_shade(mesh, angle=_SHARP)  # sharp edges have vertices of their own
    return SceneMesh(np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int32))


def stretched(mesh: SceneMesh, factors: Floats) -> SceneMesh:
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
        what = f"the package {error.name} that reads {suffix} files is not installed"
        problem = Problem("scene.no_meshes", where, what, "", 'pip install "symbody[meshes]"')
        raise EnvironmentFault(problem) from error
    return trimesh


def _coarser(mesh: Any) -> Any:
    """Return a mesh with few enough triangles, or the same if the package that does it is not installed."""
    try:
        return mesh.simplify_quadric_decimation(face_count=MOST_TRIANGLES)
    except (ImportError, ModuleNotFoundError):
        return mesh


def _problem(kind: str, where: str, what: str, fix: str) -> Problem:
    return Problem(f"scene.mesh_{kind}", where, what, "", fix)
