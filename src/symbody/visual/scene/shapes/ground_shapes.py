"""The ground: a foot with hatching at each place where a joint or a spring is fixed to it."""

from __future__ import annotations

import math

import numpy as np

from symbody.model.constraints.points import Distance
from symbody.model.joint import Joint
from symbody.model.loads.forces import Bushing, SpringDamper
from symbody.model.naming import GROUND
from symbody.visual.scene.basis import Link, SceneBasis
from symbody.visual.scene.fixed_shape import GROUND_COLOR, FixedShape, mesh_shape
from symbody.visual.scene.poses import RigidTransform, axes_along, axis_rotation
from symbody.visual.scene.scene import Floats, SceneMesh
from symbody.visual.scene.shapes.meshes import join_meshes, split_faces

# Sizes in radii of rods: half the width of the plate, its thickness, its depth below the joint.
_WIDTH, _THICKNESS, _DEPTH = 4.0, 0.7, 3.6


def ground_shapes(basis: SceneBasis, up: Floats, normal: Floats | None) -> list[FixedShape]:
    """Return a foot below each joint, spring and rope on ground; joints that slide have rails instead."""
    places: list[tuple[str, Floats]] = []
    for link in basis.links:
        slides = isinstance(link, Joint) and basis.freedoms[link.name].translations > 0
        for address in (link.start, link.end):
            if address.body == GROUND and not slides and _has_foot(link):
                at = basis.frames[address].at
                if all(np.linalg.norm(at - other) > 2.0 * basis.rod for _, other in places):
                    places.append((link.name, at))
    mesh = _foot(basis.rod)
    # The hatching is seen from the side that a planar mechanism is looked at from.
    view = axes_along(up, None if normal is None else np.cross(up, normal))
    return [mesh_shape(GROUND, name, mesh, RigidTransform(at, view), GROUND_COLOR) for name, at in places]


def _has_foot(link: Link) -> bool:
    """Return whether what connects two frames is fixed in a point."""
    return isinstance(link, Joint | SpringDamper | Distance | Bushing)


def _foot(rod: float) -> SceneMesh:
    """Return a wedge below the origin that stands on a plate with hatching, z upwards."""
    half, plate, depth = _WIDTH * rod, _THICKNESS * rod, _DEPTH * rod
    flat = _box((2.0 * half, 1.6 * half, plate), (0.0, 0.0, -depth - 0.5 * plate))
    low = -depth
    wedge = np.array([
        [-0.6 * half, -0.5 * half, low], [0.6 * half, -0.5 * half, low],
        [0.6 * half, 0.5 * half, low], [-0.6 * half, 0.5 * half, low],
        [-0.18 * half, -0.3 * half, -0.3 * rod], [0.18 * half, -0.3 * half, -0.3 * rod],
        [0.18 * half, 0.3 * half, -0.3 * rod], [-0.18 * half, 0.3 * half, -0.3 * rod],
    ])  # fmt: skip
    parts = [_hexahedron(wedge), flat]
    stroke = _box((0.25 * plate, 1.6 * half, 2.2 * plate), (0.0, 0.0, 0.0))
    tilt = axis_rotation(np.array([0.0, 1.0, 0.0]), math.radians(40.0))
    for k in range(5):
        at = np.array([(-0.75 + 0.4 * k) * half, 0.0, -depth - 1.7 * plate])
        parts.append(SceneMesh(stroke.vertices @ tilt.T + at, stroke.triangles))
    return join_meshes(parts)


def _box(edges: tuple[float, float, float], at: tuple[float, float, float]) -> SceneMesh:
    signs = [
        (-1, -1, -1),
        (1, -1, -1),
        (1, 1, -1),
        (-1, 1, -1),
        (-1, -1, 1),
        (1, -1, 1),
        (1, 1, 1),
        (-1, 1, 1),
    ]
    return _hexahedron(0.5 * np.array(signs) * edges + np.array(at))


def _hexahedron(corners: Floats) -> SceneMesh:
    """Return a solid from the corners (8, 3) of its lower and its upper face."""
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [np.array([[a, b, c], [a, c, d]], dtype=np.int32) for a, b, c, d in faces]
    return split_faces(corners, triangles)
