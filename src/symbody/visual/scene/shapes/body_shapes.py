"""Default shapes of bodies: rods between what is connected to them, or a solid of their inertia."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from symbody.model.body import Body
from symbody.visual.scene.basis import SAME_POINT, SceneBasis
from symbody.visual.scene.fixed_shape import (
    MARK,
    FixedShape,
    ball,
    fixed_shape,
    frame_along,
    mesh_shape,
    rod,
    shift_frame,
)
from symbody.visual.scene.poses import RigidTransform, rotation_matrix
from symbody.visual.scene.scene import Floats, Solid
from symbody.visual.scene.shapes.meshes import prism
from symbody.visual.scene.shapes.wheels import ball_with_marks

# Bodies without extent: the edge of the heaviest, and of the lightest, as shares of the size.
_LARGEST, _SMALLEST = 0.17, 0.07
# Solids of inertia have edges up to this share of the size: of bodies without extent, and beside others.
_WIDEST, _WIDE = 0.7, 0.35
# Massless bodies are this much thinner.
_THIN: Final = 0.6
# A body reaches to so many frames that nothing is connected to; more are not a shape.
_MOST_LOOSE: Final = 2
# Points off a line, or off a plane, by this share of the extent are on it.
_OFF: Final = 0.03


def body_shapes(basis: SceneBasis, body: Body, is_wheel: bool = False) -> list[FixedShape]:
    """Return the default shapes of a body; of one that is drawn as a wheel no more than rods."""
    points = _shape_points(basis, body)
    mass = abs(basis.numbers.number(body.mass))
    radius = basis.rod if mass else _THIN * basis.rod
    apart = [point for point in points if np.linalg.norm(point) > SAME_POINT * basis.size]
    if not apart:
        return [] if is_wheel else _with_marks(_compact(basis, body, mass))
    if is_wheel and len(points) == 1:
        return []
    if len(points) == 1:
        return _pendulum(basis, body, points[0], mass, radius)
    shapes = _frame_work(body.name, points, radius)
    if mass and _distance_to_lines(points) > 3.0 * radius:
        middle = np.mean(points, axis=0)
        shapes += [rod(body.name, body.name, middle, np.zeros(3), _THIN * radius)]
        shapes += [ball(body.name, body.name, np.zeros(3), 2.0 * radius)]
    return shapes


def _shape_points(basis: SceneBasis, body: Body) -> list[Floats]:
    """Return the points that a body reaches to: where it is connected, and its few other frames."""
    points = basis.points(body.name)
    loose = basis.loose_points(body.name)
    if not points or len(loose) > _MOST_LOOSE:
        return points
    for at in loose:
        if all(np.linalg.norm(at - other) > SAME_POINT * basis.size for other in [np.zeros(3), *points]):
            points.append(at)
    return points


def inertia_box(basis: SceneBasis, body: Body) -> tuple[tuple[float, float, float], RigidTransform]:
    """Return the edges of the uniform box with mass and inertia of a body, and its axes; edges may be 0."""
    mass = abs(basis.numbers.number(body.mass))
    xx, yy, zz = basis.numbers.vector(body.inertia)
    xy, xz, yz = basis.numbers.vector(body.products)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments, axes = np.linalg.eigh(tensor) if np.any([xy, xz, yz]) else (np.array([xx, yy, zz]), np.eye(3))
    if np.linalg.det(axes) < 0.0:
        axes = axes * [1.0, 1.0, -1.0]
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass if mass else np.zeros(3)
    a, b, c = (float(edge) for edge in np.sqrt(np.maximum(squares, 0.0)))
    return (a, b, c), RigidTransform(axes=axes)


def _compact(basis: SceneBasis, body: Body, mass: float) -> FixedShape:
    """Return the shape of a body without extent: a block if it slides, else a solid of its inertia."""
    edges, _ = inertia_box(basis, body)
    slides = _slide_axes(basis, body)
    if slides is not None or sum(edge > 0.0 for edge in edges) < 2:
        return _block(basis, body, mass, slides)
    return _solid_of_inertia(basis, body)


def _solid_of_inertia(basis: SceneBasis, body: Body) -> FixedShape:
    """Return a box of a body's inertia, or a cylinder if two of its moments are equal, or a ball."""
    edges, axes = inertia_box(basis, body)
    is_alone = all(basis.extent(other.name) == 0.0 for other in basis.model.bodies)
    # Flat bodies differ in thickness: where two overlap in their plane, one is in front.
    place = [other.name for other in basis.model.bodies].index(body.name) % 8
    low, high = _SMALLEST * (0.3 + 0.04 * place) * basis.size, (_WIDEST if is_alone else _WIDE) * basis.size
    scale = min(1.0, high / max(edges))
    a, b, c = (max(low, scale * edge) for edge in edges)
    name = body.name
    for first, second, length, k in ((a, b, c, 2), (b, c, a, 0), (c, a, b, 1)):
        if abs(first - second) < _OFF * first and abs(length - first) > _OFF * first:
            where = frame_along(np.zeros(3), axes.axes[:, k])
            return fixed_shape(name, name, "cylinder", (first / 3.0**0.5, length), where)
    if abs(a - b) < _OFF * a and abs(b - c) < _OFF * b:
        return ball(name, name, np.zeros(3), a * (5.0 / 12.0) ** 0.5)
    return fixed_shape(name, name, "box", (a, b, c), axes)


def _slide_axes(basis: SceneBasis, body: Body) -> RigidTransform | None:
    """Return axes of a body along those of a joint in which it slides and does not turn, if there is one."""
    for joint in basis.joints:
        freedoms = basis.freedoms[joint.name]
        for address in (joint.start, joint.end):
            if address.body == body.name and freedoms.slides and not freedoms.rotations:
                return RigidTransform(axes=basis.frames[address].axes)
    return None


def _block(basis: SceneBasis, body: Body, mass: float, slides: RigidTransform | None) -> FixedShape:
    """Return a block if the body slides, else a ball; by its share of the largest mass."""
    if not mass:
        return ball(body.name, body.name, np.zeros(3), _THIN * basis.rod)
    masses = [abs(basis.numbers.number(other.mass)) for other in basis.model.bodies]
    edge = basis.size * max(_SMALLEST, _LARGEST * (mass / max(masses)) ** (1.0 / 3.0))
    if slides is not None:
        return fixed_shape(body.name, body.name, "box", (edge, edge, edge), slides)
    return ball(body.name, body.name, np.zeros(3), 0.5 * edge)


def _pendulum(basis: SceneBasis, body: Body, point: Floats, mass: float, radius: float) -> list[FixedShape]:
    """Return a rod from the only joint to the centre of mass, and what swings there."""
    shapes = [rod(body.name, body.name, point, np.zeros(3), radius)]
    if not mass:
        return shapes
    edges, _ = inertia_box(basis, body)
    length = float(np.linalg.norm(point))
    direction = -point / length
    if sum(edge > 0.0 for edge in edges) == 3:
        shape = _limit_size(_solid_of_inertia(basis, body), length)
        if shape.solid.kind == "sphere":  # a disc shows how it spins
            size = (0.4 * length, 0.1 * length)
            shape = fixed_shape(body.name, body.name, "cylinder", size, frame_along(np.zeros(3), direction))
        return [*shapes, *_with_marks(shape)]
    edge = max(edges)
    if sum(edge > 0.0 for edge in edges) == 1:  # a thin rod: shown as long as it is
        end = direction * min(0.5 * edge, 1.2 * length)
        return [rod(body.name, body.name, point, end, radius), ball(body.name, body.name, end, 1.6 * radius)]
    return [*shapes, ball(body.name, body.name, np.zeros(3), 3.0 * radius)]


def _with_marks(shape: FixedShape) -> list[FixedShape]:
    """Return a shape, with marks if it is round, so that its turning is seen."""
    solid = shape.solid
    where = RigidTransform(np.array(solid.at), rotation_matrix(solid.quaternion))
    if solid.kind == "sphere":
        return ball_with_marks(shape.body, solid.element, where, solid.size[0])
    if solid.kind != "cylinder":
        return [shape]
    radius, length = solid.size
    size = (0.12 * radius, 1.04 * length)
    mark = fixed_shape(shape.body, solid.element, "cylinder", size, shift_frame(where, x=0.7 * radius), MARK)
    return [shape, mark]


def _limit_size(shape: FixedShape, largest: float) -> FixedShape:
    """Return a shape whose sizes are at most so large."""
    solid = shape.solid
    factor = min(1.0, largest / max(solid.size))
    sizes = tuple(factor * size for size in solid.size)
    return FixedShape(
        shape.body, Solid(solid.element, solid.kind, sizes, solid.at, solid.quaternion, color=solid.color)
    )


def _frame_work(body: str, points: Sequence[Floats], radius: float) -> list[FixedShape]:
    """Return a rod through points on a line, a plate through points in a plane, else rods to their mean."""
    if len(points) == 2:
        return [rod(body, body, points[0], points[1], radius)]
    array = np.array(points)
    middle = array.mean(axis=0)
    _, extents, directions = np.linalg.svd(array - middle)
    if extents[1] < _OFF * extents[0]:
        order = np.argsort((array - middle) @ directions[0])
        pairs = zip(order[:-1], order[1:], strict=True)
        return [rod(body, body, array[i], array[j], radius) for i, j in pairs]
    if len(extents) < 3 or extents[2] < _OFF * extents[0]:
        return _plate(body, array, middle, directions, radius)
    return [rod(body, body, middle, point, radius) for point in points]


def _plate(body: str, points: Floats, middle: Floats, directions: Floats, radius: float) -> list[FixedShape]:
    """Return the hull of points in a plane as a thin plate with a rim of rods, rods to points inside it."""
    axes = np.column_stack([directions[0], directions[1], np.cross(directions[0], directions[1])])
    flat = (points - middle) @ axes[:, :2]
    corners = [int(k) for k in ConvexHull(flat).vertices]
    shapes = [mesh_shape(body, body, prism(flat[corners], 0.7 * radius), RigidTransform(middle, axes))]
    after = [*corners[1:], corners[0]]
    shapes += [
        rod(body, body, points[i], points[j], 0.8 * radius) for i, j in zip(corners, after, strict=True)
    ]
    inside = [k for k in range(len(points)) if k not in corners]
    return shapes + [rod(body, body, middle, points[k], 0.8 * radius) for k in inside]


def _distance_to_lines(points: Sequence[Floats]) -> float:
    """Return how far the centre of mass is from the rods of a body."""
    array = np.array(points)
    if len(points) == 2:
        return _distance_to_line(array[0], array[1])
    middle = array.mean(axis=0)
    _, extents, directions = np.linalg.svd(array - middle)
    if extents[1] >= _OFF * extents[0]:
        if len(extents) >= 3 and extents[2] >= _OFF * extents[0]:
            return float(np.linalg.norm(middle))
        normal = np.cross(directions[0], directions[1])
        inside = float(np.linalg.norm(middle - (middle @ normal) * normal)) < extents[0]
        return abs(float(middle @ normal)) if inside else float(np.linalg.norm(middle))
    across = middle - (middle @ directions[0]) * directions[0]
    along_line = (array - middle) @ directions[0]
    position = float(-middle @ directions[0])
    beyond = max(0.0, position - float(along_line.max()), float(along_line.min()) - position)
    return float(np.hypot(np.linalg.norm(across), beyond))


def _distance_to_line(start: Floats, end: Floats) -> float:
    """Return how far the centre of mass is from the rod between two points."""
    along = end - start
    share = min(1.0, max(0.0, -float(start @ along) / float(along @ along)))
    return float(np.linalg.norm(start + share * along))
