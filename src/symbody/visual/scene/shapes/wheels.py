"""What rolls and cuts: tyres, balls, blades; each with a mark, so that its turning is seen."""

from __future__ import annotations

import math

import numpy as np

from symbody.model.constraints.rolling import KnifeEdge, Rolling
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    MARK,
    RUBBER,
    STEEL,
    FixedShape,
    ball,
    fixed_shape,
    frame_along,
    mesh_shape,
    rod,
)
from symbody.visual.scene.poses import RigidTransform
from symbody.visual.scene.shapes.meshes import ring

_SPOKES = 6


def rolling_shapes(basis: SceneBasis, element: Rolling) -> list[FixedShape]:
    """Return the wheel or the ball that rolls."""
    frame = basis.frames[element.end]
    radius = abs(basis.numbers.number(element.radius)) or 2.0 * basis.rod
    if element.axis is None:
        return ball_with_marks(element.end.body, element.name, frame, radius)
    where = frame_along(frame.at, frame.axes @ basis.numbers.axis(element.axis))
    return _spoked_wheel(element.end.body, element.name, where, radius, basis.rod)


def knife_shapes(basis: SceneBasis, element: KnifeEdge) -> list[FixedShape]:
    """Return the blade: thin along its normal, long along the first axis of its frame that is across it."""
    frame = basis.frames[element.end]
    normal = basis.numbers.axis(element.axis)
    sideways = np.eye(3)[int(np.argmin(np.abs(normal)))]
    where = frame_along(frame.at, frame.axes @ normal, frame.axes @ sideways)
    size = (8.0 * basis.rod, 3.0 * basis.rod, 0.4 * basis.rod)
    return [fixed_shape(element.end.body, element.name, "box", size, where, STEEL)]


def ball_with_marks(body: str, name: str, frame: RigidTransform, radius: float) -> list[FixedShape]:
    """Return a ball with spots at the ends of its axes."""
    spots = [
        ball(body, name, frame.point(sign * 0.86 * radius * np.eye(3)[k]), 0.16 * radius, MARK)
        for k in range(3)
        for sign in (-1.0, 1.0)
    ]
    return [ball(body, name, frame.at, radius), *spots]


def _spoked_wheel(
    body: str, name: str, where: RigidTransform, radius: float, thickness: float
) -> list[FixedShape]:
    """Return a tyre about z, whose outside has the radius, a hub, and spokes of which one is marked."""
    tyre = min(0.09 * radius, 1.3 * thickness)
    hub = (max(0.09 * radius, 0.6 * tyre), 3.0 * tyre)
    shapes = [
        mesh_shape(body, name, ring(radius - tyre, tyre), where, RUBBER),
        fixed_shape(body, name, "cylinder", hub, where, STEEL),
    ]
    for k in range(_SPOKES):
        angle = 2.0 * math.pi * k / _SPOKES
        rim = (radius - tyre) * np.array([math.cos(angle), math.sin(angle), 0.0])
        color = MARK if k == 0 else ""
        shapes.append(rod(body, name, where.at, where.point(rim), 0.35 * tyre, color))
    return shapes
