"""What touches in contacts: the shapes that bodies without shapes of their own are drawn by."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from symbody.model.contacts.contact import Contact
from symbody.model.contacts.contact_shapes import ContactShape
from symbody.model.element import FrameRef
from symbody.model.naming import GROUND
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import GLASS, MARK, RUBBER, FixedShape, ball, fixed_shape, mesh_shape
from symbody.visual.scene.freedoms import PARALLEL
from symbody.visual.scene.poses import RigidTransform
from symbody.visual.scene.scene import Floats, SceneMesh
from symbody.visual.scene.shapes.meshes import hollow_prism, prism, ring
from symbody.visual.scene.shapes.wheels import ball_with_marks
from symbody.visual.scene.view import plane_normal

# Sides of a ground, of its cells and of the strip of it below a planar mechanism, in sizes of the mechanism;
# the least and the largest number of cells along a side; corners of round outlines.
_GROUND, _CELL, _STRIP = 3.0, 0.06, 0.4
_CELLS: Final = (12, 600)
_CORNERS: Final = 96

Maker = Callable[[SceneBasis, str, Floats, RigidTransform], list[FixedShape]]


def contact_solids(basis: SceneBasis) -> list[FixedShape]:
    """Return the shapes of all contacts but planes, each once; a body's name stands for what it shows."""
    drawn: set[tuple[FrameRef, ContactShape]] = set()
    shapes: list[FixedShape] = []
    for element in basis.model.elements:
        if not isinstance(element, Contact):
            continue
        for shape, at, other in _sides(element):
            if (at, shape) in drawn:
                continue
            drawn.add((at, shape))
            if shape.word == "height":
                shapes += _height(basis, element, shape, at, other)
            elif shape.word == "cam":
                shapes += _cam(basis, shape, at)
            elif shape.word in _MAKERS:
                sizes = np.abs(basis.numbers.vector(shape.sizes))
                if sizes[:1].all():
                    shapes += _MAKERS[shape.word](basis, at.body, sizes, basis.frames[at])
    return shapes


def _sides(contact: Contact) -> Iterator[tuple[ContactShape, FrameRef, FrameRef]]:
    """Yield each shape with its frame and the frame of the other."""
    first, second = contact.shapes
    yield first, contact.start, contact.end
    yield second, contact.end, contact.start


def _point(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return [] if body == GROUND else [ball(body, body, where.at, 1.5 * basis.rod)]


def _sphere(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return ball_with_marks(body, body, where, float(sizes[0]))


def _capsule(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return [fixed_shape(body, body, "capsule", (sizes[0], sizes[1]), where)]


def _cylinder(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    radius, length = sizes
    return [fixed_shape(body, body, "cylinder", (radius, length), where), *_spot(body, radius, length, where)]


def _disc(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return _cylinder(basis, body, np.array([sizes[0], min(0.1 * sizes[0], basis.rod)]), where)


def _spot(body: str, radius: float, length: float, where: RigidTransform) -> list[FixedShape]:
    """Return a mark through a cylinder, so that its turning is seen."""
    spot = RigidTransform(where.point(np.array([0.7 * radius, 0.0, 0.0])), where.axes)
    return [fixed_shape(body, body, "cylinder", (0.12 * radius, 1.02 * length), spot, MARK)]


def _torus(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    radius, tube = (float(size) for size in sizes)
    spot = ball(body, body, where.point(np.array([radius, 0.0, 0.0])), 1.03 * tube, MARK)
    return [mesh_shape(body, body, ring(radius, tube), where, RUBBER), spot]


def _box(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return [fixed_shape(body, body, "box", (sizes[0], sizes[1], sizes[2]), where)]


def _socket(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    return [ball(body, body, where.at, float(sizes[0]), opacity=GLASS)]


def _hole(basis: SceneBasis, body: str, sizes: Floats, where: RigidTransform) -> list[FixedShape]:
    wall = max(0.1 * float(sizes[0]), basis.rod)
    inner, outer = _circle(float(sizes[0])), _circle(float(sizes[0]) + wall)
    return [mesh_shape(body, body, hollow_prism(inner, outer, 2.0 * basis.rod), where)]


def _circle(radius: float) -> Floats:
    angles = np.linspace(0.0, 2.0 * math.pi, _CORNERS, endpoint=False)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _cam(basis: SceneBasis, shape: ContactShape, at: FrameRef) -> list[FixedShape]:
    """Return the disc inside of a cam's outline."""
    angles = np.linspace(0.0, 2.0 * math.pi, _CORNERS, endpoint=False)
    radii = basis.numbers.samples(shape.sizes, ("angle",), angles[:, np.newaxis])
    if not (np.isfinite(radii).all() and (radii > 0.0).all()):
        return []
    disc = prism(radii * np.stack([np.cos(angles), np.sin(angles)], axis=1), basis.rod)
    return [mesh_shape(at.body, at.body, disc, basis.frames[at])]


def _height(
    basis: SceneBasis, contact: Contact, shape: ContactShape, at: FrameRef, other: FrameRef
) -> list[FixedShape]:
    """Return the surface of a ground of given height about where the other body comes."""
    course = basis.course(at, other)[:, :2]
    low, high = course.min(axis=0), course.max(axis=0)
    sides = np.maximum(_GROUND * basis.size, 1.25 * (high - low))
    normal = plane_normal(basis)
    if normal is not None:  # what is across the plane would cover the wheels
        sides[np.abs(normal @ basis.frames[at].axes[:, :2]) > 1.0 - PARALLEL] = _STRIP * basis.size
    counts = np.clip(np.ceil(sides / (_CELL * basis.size)), *_CELLS).astype(int)
    lines = [
        np.linspace(mean - 0.5 * side, mean + 0.5 * side, count + 1)
        for mean, side, count in zip(0.5 * (low + high), sides, counts, strict=True)
    ]
    x, y = np.meshgrid(*lines, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel()])
    heights = basis.numbers.samples(shape.sizes, ("x", "y"), points)[:, 0]
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    triangles = np.vstack([np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, b, c), (a, c, d))])
    triangles = triangles[np.isfinite(heights)[triangles].all(axis=1)]
    vertices = np.column_stack([points, np.where(np.isfinite(heights), heights, 0.0)])
    mesh = SceneMesh(vertices, triangles.astype(np.int32))
    return [mesh_shape(at.body, contact.name, mesh, basis.frames[at])] if len(triangles) else []


_MAKERS: Final[Mapping[str, Maker]] = MappingProxyType(
    {
        "point": _point,
        "sphere": _sphere,
        "capsule": _capsule,
        "cylinder": _cylinder,
        "disc": _disc,
        "torus": _torus,
        "box": _box,
        "socket": _socket,
        "hole": _hole,
    }
)
