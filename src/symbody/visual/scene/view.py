"""How a mechanism is looked at: what is up, and the plane of a planar one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symbody.visual.scene.basis import SceneBasis
from symbody.visual.scene.freedoms import are_parallel
from symbody.visual.scene.numbers import unit
from symbody.visual.scene.poses import as_point
from symbody.visual.scene.scene import Floats, Scene, SceneMotion

_ACROSS = 1e-6


def gravity_of(basis: SceneBasis) -> Floats | None:
    """Return the acceleration of free fall (3,) [m/s^2], or None if there is none."""
    gravity = basis.numbers.vector(basis.model.gravity)
    return gravity if np.any(gravity) else None


def plane_normal(basis: SceneBasis) -> Floats | None:
    """Return the normal of the plane in which all bodies move, in ground's axes; None if there is none."""
    rotations: list[Floats] = []
    translations: list[Floats] = []
    for joint in basis.joints:
        freedoms = basis.freedoms[joint.name]
        if freedoms.rotations > 1:
            return None
        start = basis.frame(joint.start).axes
        slides = basis.frame(joint.end).axes if freedoms.slides_in == "end" else start
        rotations += [start @ axis for axis in freedoms.axes]
        translations += [slides @ slide for slide in freedoms.slides]
        if freedoms.is_screw:
            return None
    normal = _common_normal(rotations, translations)
    if normal is None or not all(are_parallel(normal, axis) for axis in rotations):
        return None
    return None if any(abs(normal @ slide) > _ACROSS for slide in translations) else normal


def up_direction(gravity: Floats | None, normal: Floats | None) -> Floats:
    """Return the direction drawn upwards: against gravity, unless that is the normal of the plane."""
    candidates = [] if gravity is None else [-unit(gravity)]
    candidates += [np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])]
    for candidate in candidates:
        if normal is None or not are_parallel(candidate, normal):
            across = candidate if normal is None else candidate - (candidate @ normal) * normal
            return unit(across)
    return candidates[-1]


def facing_normal(normal: Floats, up: Floats) -> Floats:
    """Return the normal or its opposite: seen against it, ground's x, else y, else z runs to the right."""
    right = np.cross(up, normal)
    across = next(share for share in right if abs(share) > _ACROSS)
    return normal if across > 0.0 else -normal


def seen_along(scene: Scene, motion: SceneMotion) -> Scene:
    """Return a scene of bodies without joints that move in a plane as one that is seen along its normal."""
    if scene.joints or scene.normal is not None or not motion.positions.size:
        return scene
    reach = np.ptp(motion.positions.reshape(-1, len(scene.bodies) - 1, 3), axis=0).max(axis=0)
    turns = np.abs(motion.quaternions.reshape(-1, 4)[:, 1:]).max(axis=0)
    for k in (2, 1, 0):
        others = [j for j in range(3) if j != k]
        if reach[k] <= _ACROSS * scene.size and turns[others].max() <= _ACROSS and reach.max() > 0.0:
            gravity = None if scene.gravity is None else np.array(scene.gravity)
            up = up_direction(gravity, np.eye(3)[k])
            return replace(scene, normal=as_point(facing_normal(np.eye(3)[k], up)), up=as_point(up))
    return scene


def _common_normal(rotations: list[Floats], translations: list[Floats]) -> Floats | None:
    """Return the direction of the first axis, else across all translations; of one alone z, or y."""
    if rotations:
        return _forward(rotations[0])
    for first in translations[:1]:
        for second in translations[1:]:
            if not are_parallel(first, second):
                return _forward(unit(np.cross(first, second)))
        z = np.array([0.0, 0.0, 1.0])
        return z if abs(first[2]) < _ACROSS else unit(np.cross(first, np.cross([0.0, 1.0, 0.0], first)))
    return None


def _forward(direction: Floats) -> Floats:
    """Return a direction or its opposite: that whose largest component is positive."""
    largest = direction[int(np.argmax(np.abs(direction)))]
    return direction if largest > 0.0 else -direction
