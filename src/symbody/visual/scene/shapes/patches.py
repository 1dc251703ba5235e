"""Planes, lines, curves and surfaces that points are held on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symbody.model.constraints.points import PointOnCurve, PointOnLine, PointOnPlane, PointOnSurface
from symbody.model.constraints.rolling import Rolling
from symbody.model.contacts.contact import Contact
from symbody.model.naming import GROUND
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    GLASS,
    GROUND_COLOR,
    STEEL,
    FixedShape,
    ball,
    fixed_shape,
    frame_along,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.freedoms import PARALLEL
from symbody.visual.scene.poses import RigidTransform, rotation_matrix
from symbody.visual.scene.scene import Floats
from symbody.visual.scene.shapes.level_surface import level_surface
from symbody.visual.scene.shapes.meshes import prism, tube
from symbody.visual.scene.view import plane_normal

# Sides of planes that something rolls on, and that a point slides on, in sizes of the mechanism.
_FLOOR, _PATCH, _LINE, _REACH = 3.0, 1.2, 1.4, 0.8
_STRIP: Final = 0.4  # of the mechanism's size: how wide a plane is drawn that is seen along itself
_SAMPLES: Final = 160
_CELLS: Final = 22


@dataclass(frozen=True, slots=True, eq=False)
class _Floor:
    """A plane that something rolls on or touches.

    Attributes
    ----------
    body, element : str
        The body that it is on, and what it shows.
    where : RigidTransform
        Its frame on the body, whose z axis is the normal.
    points : (N, 3) array
        Where the other body's frame comes, in the body's axes [m].
    """

    body: str
    element: str
    where: RigidTransform
    points: Floats


def floor_shapes(basis: SceneBasis, given: Mapping[str, Sequence[FixedShape]]) -> list[FixedShape]:
    """Return the planes that something rolls on or touches, each once, as large as all of that needs.

    Parameters
    ----------
    given : mapping of body to its shapes
        Those of the model: a plane that is a face of one of them is not drawn again.
    """
    floors: list[_Floor] = []
    normal = plane_normal(basis)
    for floor in _all_floors(basis):
        for k, other in enumerate(floors):
            if other.body == floor.body and _are_coplanar(other.where, floor.where, basis.rod):
                floors[k] = replace(other, points=np.vstack([other.points, floor.points]))
                break
        else:
            floors.append(floor)
    return [
        _patch(basis, floor.body, floor.element, floor.where, floor.points, _FLOOR * basis.size, normal)
        for floor in floors
        if not any(_has_face(shape, floor.where, basis.rod) for shape in given.get(floor.body, ()))
    ]


def _all_floors(basis: SceneBasis) -> Iterator[_Floor]:
    for element in basis.model.elements:
        if isinstance(element, Rolling):
            points = basis.frames[element.start].point(basis.course(element.start, element.end))
            yield _Floor(element.start.body, element.name, _plane_frame(basis, element), points)
        elif isinstance(element, Contact):
            ends = (element.start, element.end)
            for shape, own, other in zip(element.shapes, ends, ends[::-1], strict=True):
                if shape.word == "plane":
                    where = basis.frames[own]
                    yield _Floor(own.body, element.name, where, where.point(basis.course(own, other)))


def _has_face(shape: FixedShape, plane: RigidTransform, thickness: float) -> bool:
    """Return whether a solid is a box one of whose faces lies in a plane."""
    solid = shape.solid
    if solid.kind != "box":
        return False
    normal = rotation_matrix(solid.quaternion).T @ plane.axes[:, 2]
    along = int(np.argmax(np.abs(normal)))
    height = float(plane.axes[:, 2] @ (np.array(solid.at) - plane.at)) + 0.5 * solid.size[along]
    return bool(abs(normal[along]) > 1.0 - PARALLEL) and abs(height) < 0.1 * thickness


def plane_shapes(basis: SceneBasis, element: PointOnPlane) -> list[FixedShape]:
    """Return a patch of the plane that a point is held in, and the point."""
    course = basis.frames[element.start].point(basis.course(element.start, element.end))
    where = _plane_frame(basis, element)
    patch = _patch(basis, element.start.body, element.name, where, course, _PATCH * basis.size)
    return [patch, _point(basis, element)]


def _plane_frame(basis: SceneBasis, element: Rolling | PointOnPlane) -> RigidTransform:
    """Return a frame on start's body whose z axis is the normal."""
    normal = element.normal if isinstance(element, Rolling) else element.axis
    frame = basis.frames[element.start]
    return frame_along(frame.at, frame.axes @ basis.numbers.axis(normal))


def _are_coplanar(plane: RigidTransform, other: RigidTransform, thickness: float) -> bool:
    """Return whether two planes are one."""
    normal = plane.axes[:, 2]
    is_parallel = bool(np.linalg.norm(np.cross(normal, other.axes[:, 2])) < PARALLEL)
    return is_parallel and abs(float(normal @ (other.at - plane.at))) < 0.1 * thickness


def _patch(
    basis: SceneBasis,
    body: str,
    element: str,
    where: RigidTransform,
    course: Floats,
    side: float,
    normal: Floats | None = None,
) -> FixedShape:
    """Return a translucent square in the plane z = 0 of a frame, about points (N, 3) of the body.

    Of a planar mechanism, whose `normal` is given, a plane that is seen along itself is a narrow strip: the
    near part of a square would cover the feet of what stands on it.
    """
    strip = 0.0
    if normal is not None and abs(float(normal @ where.axes[:, 2])) < PARALLEL:
        strip = min(side, _STRIP * basis.size)
        z_axis = where.axes[:, 2]
        along = np.cross(normal, z_axis)
        where = RigidTransform(where.at, np.column_stack([along, np.cross(z_axis, along), z_axis]))
    thickness = 0.15 * basis.rod
    inside = where.inverse().point(course)[:, :2]
    low, high = inside.min(axis=0), inside.max(axis=0)
    side = max(side, float((high - low).max()) + 0.5 * side)
    x, y = 0.5 * (low + high)
    centre = shift_frame(where, float(x), float(y), -0.5 * thickness)
    color = GROUND_COLOR if body == GROUND else ""
    return fixed_shape(body, element, "box", (side, strip or side, thickness), centre, color, GLASS)


def line_shapes(basis: SceneBasis, element: PointOnLine) -> list[FixedShape]:
    """Return the line, about where the point is at the start, and the point."""
    frame = basis.frames[element.start]
    direction = frame.axes @ basis.numbers.axis(element.axis)
    middle = frame.at + ((_seen_from_start(basis, element) - frame.at) @ direction) * direction
    size = (0.5 * basis.rod, _LINE * basis.size)
    line = fixed_shape(
        element.start.body, element.name, "cylinder", size, frame_along(middle, direction), STEEL
    )
    return [line, _point(basis, element)]


def curve_shapes(basis: SceneBasis, element: PointOnCurve) -> list[FixedShape]:
    """Return the curve as a wire; of a closed one that is flat the disc inside it, as of a cam."""
    points, is_closed = curve_points(basis, element)
    frame = basis.frames[element.start]
    name, body = element.name, element.start.body
    if len(points) < 3:
        return [_point(basis, element)]
    shapes = [mesh_shape(body, name, tube(points, 0.4 * basis.rod, is_closed, 6), frame, STEEL)]
    if is_closed:
        middle = points.mean(axis=0)
        _, extents, directions = np.linalg.svd(points - middle)
        axes = np.column_stack([directions[0], directions[1], np.cross(directions[0], directions[1])])
        flat = (points - middle) @ axes[:, :2]
        if extents[2] < 1e-6 * extents[0] and is_star_shaped(flat):
            outline = flat if _area(flat) > 0.0 else flat[::-1]
            disc = prism(outline, 0.6 * basis.rod)
            where = RigidTransform(frame.point(middle), frame.axes @ axes)
            shapes.append(mesh_shape(body, name, disc, where))
    return [*shapes, _point(basis, element)]


def curve_points(basis: SceneBasis, element: PointOnCurve) -> tuple[Floats, bool]:
    """Return points (N, 3) of a curve in its frame, and whether it closes; one full turn if it is periodic.

    Others are shown from the start's value of the parameter to both sides, as far as they stay near.
    """
    start = basis.numbers.number(basis.model.initial[element.parameter]) if (
        element.parameter in basis.model.initial
    ) else 0.0  # fmt: skip
    low, high = basis.travel.get(element.parameter, (start, start))

    def sample(places: Floats) -> Floats:
        return basis.numbers.samples(element.curve, (element.parameter,), places[:, np.newaxis])

    ends = sample(np.array([start, start + 2.0 * math.pi, start + 0.7]))
    scale = float(np.abs(ends[2] - ends[0]).max()) or 1.0
    if np.all(np.isfinite(ends)) and np.abs(ends[1] - ends[0]).max() < 1e-9 * scale:
        angles = np.linspace(0.0, 2.0 * math.pi, _SAMPLES, endpoint=False)
        points = sample(start + angles)
        return points[np.all(np.isfinite(points), axis=1)], True
    speed = float(np.linalg.norm(sample(np.array([start + 1e-6]))[0] - ends[0])) / 1e-6
    reach = _REACH * basis.size / speed if speed > 0.0 and math.isfinite(speed) else 1.0
    places = np.linspace(low - reach, high + reach, _SAMPLES)
    points = sample(places)
    return points[np.all(np.isfinite(points), axis=1)], False


def surface_shapes(basis: SceneBasis, element: PointOnSurface) -> list[FixedShape]:
    """Return the surface of each equation, and the point.

    It is shown about its frame as far as the point is away, or about the point if that is far.
    """
    frame = basis.frames[element.start]
    point = frame.inverse().point(_seen_from_start(basis, element))
    distance = float(np.linalg.norm(point))
    is_near = distance < 3.0 * basis.size
    middle, reach = (np.zeros(3), 1.2 * distance) if is_near else (point, 0.0)
    reach = max(reach, _REACH * basis.size)
    shapes = []
    for equation in element.equations:
        mesh = level_surface(basis.numbers, equation, middle, reach, _CELLS)
        if mesh is not None:
            shapes.append(mesh_shape(element.start.body, element.name, mesh, frame, STEEL, 0.45))
    return [*shapes, _point(basis, element)]


def is_star_shaped(outline: Floats) -> bool:
    """Return whether an outline (N, 2) goes once round its mean without turning back."""
    inside = outline - outline.mean(axis=0)
    after = np.roll(inside, -1, axis=0)
    areas = inside[:, 0] * after[:, 1] - inside[:, 1] * after[:, 0]
    return bool(np.all(areas > 0.0) or np.all(areas < 0.0))


def _area(outline: Floats) -> float:
    after = np.roll(outline, -1, axis=0)
    return float(np.sum(outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]))


def _seen_from_start(basis: SceneBasis, element: PointOnLine | PointOnSurface) -> Floats:
    """Return the origin of end in the axes of start's body, at the start."""
    end = basis.bodies[element.end.body].point(basis.frames[element.end].at)
    return basis.bodies[element.start.body].inverse().point(end)


def _point(
    basis: SceneBasis, element: PointOnPlane | PointOnLine | PointOnCurve | PointOnSurface
) -> FixedShape:
    """Return a bead on the body whose point is held."""
    return ball(element.end.body, element.name, basis.frames[element.end].at, 1.5 * basis.rod)
