"""Shapes as users give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np

from symbody.errors import SymbodyError
from symbody.model.shapes import BodyShape, Box, Capsule, Cone, Cylinder, Mesh, Sphere
from symbody.model.shapes.shape import hex_color
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import FixedShape, fixed_shape, mesh_shape
from symbody.visual.scene.poses import frame_transform
from symbody.visual.scene.scene import SceneMesh, SolidKind
from symbody.visual.scene.shapes.mesh_files import read_meshes, stretch_mesh

# What stands for a mesh that is not there: a box of this share of the mechanism's size.
_STAND_IN: Final = 0.12

Meshes: TypeAlias = dict[str, list[tuple[SceneMesh, str]]]


def user_shapes(basis: SceneBasis) -> tuple[dict[str, list[FixedShape]], tuple[str, ...]]:
    """Return the shapes that a model gives its bodies, and notes on meshes that could not be read."""
    read: Meshes = {}
    notes: list[str] = []
    shapes: dict[str, list[FixedShape]] = {}
    owners: list[tuple[str, Sequence[BodyShape]]] = [("ground", basis.model.ground_shapes)]
    owners += [(body.name, body.shapes) for body in basis.model.bodies]
    for name, given in owners:
        for shape in given:
            shapes.setdefault(name, []).extend(_solids(basis, name, shape, read, notes))
    return shapes, tuple(dict.fromkeys(notes))


def _solids(
    basis: SceneBasis, body: str, shape: BodyShape, read: Meshes, notes: list[str]
) -> list[FixedShape]:
    """Return a shape as solids on its body: one, or of a file one for each colour."""
    where = frame_transform(shape.frame, basis.numbers)
    color = hex_color(shape.color)
    opacity = float(np.clip(basis.numbers.number(shape.opacity, 1.0), 0.0, 1.0))
    if not isinstance(shape, Mesh):
        sizes = tuple(abs(basis.numbers.number(formula)) for _, formula in shape.lengths)
        return [fixed_shape(body, body, _KINDS[type(shape)], sizes, where, color, opacity)]
    factors = basis.numbers.vector(shape.scale)
    key = f"{shape.place} {factors}"
    if key not in read:
        try:
            read[key] = [
                (stretch_mesh(mesh, factors), painted) for mesh, painted in read_meshes(Path(shape.place))
            ]
        except SymbodyError as error:
            problem = error.problems[0]
            notes.append(f"{body}: a box replaces {shape.path}: {problem.what}; {problem.fix}")
            edge = _STAND_IN * basis.size
            return [fixed_shape(body, body, "box", (edge, edge, edge), where, color, opacity)]
    return [mesh_shape(body, body, mesh, where, color or painted, opacity) for mesh, painted in read[key]]


_KINDS: Final[Mapping[type[BodyShape], SolidKind]] = MappingProxyType(
    {Box: "box", Cylinder: "cylinder", Sphere: "sphere", Capsule: "capsule", Cone: "cone"}
)
