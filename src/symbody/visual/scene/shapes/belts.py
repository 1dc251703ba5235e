"""Belts: pulleys, and a line round them."""

from __future__ import annotations

import math

import numpy as np

from symbody.model.constraints.couplings import Belt
from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.fixed_shape import (
    MARK,
    RUBBER,
    FixedShape,
    fixed_shape,
    frame_along,
    mesh_shape,
    shift_frame,
)
from symbody.visual.scene.freedoms import are_parallel
from symbody.visual.scene.poses import RigidTransform, axes_along
from symbody.visual.scene.scene import Floats
from symbody.visual.scene.shapes.meshes import tube
from symbody.visual.scene.shapes.wheel_sites import wheel_sites


def belt_shapes(basis: SceneBasis, element: Belt) -> list[FixedShape]:
    """Return two pulleys with marks, and the belt round them."""
    sites = wheel_sites(basis, element.coupled, (0.0, 0.0))
    radii = np.abs(basis.numbers.vector(element.radii))
    if sites is None or not np.all(radii) or not are_parallel(sites[0].axis, sites[1].axis):
        return []
    width = float(np.clip(0.3 * radii.min(), 1.5 * basis.rod, 5.0 * basis.rod))
    first, second = sites
    across = second.centre - first.centre
    across = across - (across @ first.axis) * first.axis
    distance = float(np.linalg.norm(across))
    shapes: list[FixedShape] = []
    for site, radius in zip(sites, radii, strict=True):
        plane = (first.centre - site.centre) @ first.axis
        back = site.placed.inverse()
        where = frame_along(back.point(site.centre + plane * first.axis), back.axes @ site.axis)
        shapes.append(fixed_shape(site.body, element.name, "cylinder", (radius, width), where))
        mark = shift_frame(where, x=0.7 * radius)
        size = (0.1 * radius, 1.06 * width)
        shapes.append(fixed_shape(site.body, element.name, "cylinder", size, mark, MARK))
    is_apart = distance > (radii.sum() if element.crossed else abs(radii[0] - radii[1]))
    if not is_apart:
        return shapes
    line = belt_line(radii[0] + 0.15 * width, radii[1] + 0.15 * width, distance, element.crossed)
    where = RigidTransform(first.centre, axes_along(first.axis, across))
    points = np.column_stack([line, np.zeros(len(line))])
    loop = tube(points, 0.22 * width, is_closed=True, sides=8)
    return [*shapes, mesh_shape(first.case, element.name, loop, where, RUBBER)]


def belt_line(first: float, second: float, distance: float, is_crossed: bool) -> Floats:
    """Return points (N, 2) of a belt round wheels about the origin and about (distance, 0)."""
    sense = -1.0 if is_crossed else 1.0
    angle = math.acos(float(np.clip((first - sense * second) / distance, -1.0, 1.0)))
    left = np.linspace(angle, 2.0 * math.pi - angle, 33)
    around = first * np.stack([np.cos(left), np.sin(left)], axis=1)
    if is_crossed:  # the belt passes from the lower side of one to the upper side of the other
        right = np.linspace(math.pi - angle, -math.pi + angle, 33)
    else:
        right = np.linspace(-angle, angle, 33)
    beyond = np.array([distance, 0.0]) + second * np.stack([np.cos(right), np.sin(right)], axis=1)
    return np.vstack([around, beyond])
