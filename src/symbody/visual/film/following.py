"""Mechanisms that go far: the camera goes along with their centre of mass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from symbody.visual.film.facets import Floats
from symbody.visual.film.stage import BodyPlaces, Stage, extent
from symbody.visual.scene.scene import Scene

_LOOSE: Final = ("free", "cartesian", "rectangular", "planar")  # joints that hold nothing in its place
_FAR: Final = 15.0  # times its own extent goes a mechanism that is followed


def centre_of(scene: Scene, pose: BodyPlaces) -> Floats:
    """Return the centre of mass (3,) of all bodies [m]; without masses the mean of their places."""
    masses = np.array([body.mass for body in scene.bodies[1:]])
    places = pose.positions[1:]
    if not len(places):
        return np.zeros(3)
    weights = masses / masses.sum() if masses.sum() > 0.0 else np.full(len(places), 1.0 / len(places))
    return np.asarray(weights @ places, dtype=np.float64)


def carried_extent(stage: Stage, poses: Sequence[BodyPlaces]) -> tuple[Floats, Floats | None]:
    """Return points (N, 3) around the mechanism, relative to the point that the camera follows.

    Returns
    -------
    points : (N, 3) array
        As if the centre of mass stayed where it is at first [m].
    start : (3,) array or None
        Where it is at first; None if the mechanism does not go far: then it is not followed.
    """
    first = centre_of(stage.scene, poses[0])
    ground = len(stage.ground.vertices)
    moved, carried = [], []
    for pose in poses:
        points = extent(stage, [pose])[ground:]
        moved.append(points)
        carried.append(points - centre_of(stage.scene, pose) + first)
    ways, own = np.concatenate(moved), np.concatenate(carried)
    goes_far = not _is_tied(stage.scene) and _diagonal(ways) > _FAR * _diagonal(own) > 0.0
    return own, first if goes_far else None


def _is_tied(scene: Scene) -> bool:
    """Return whether a joint, such as a guide that shows the way, holds the mechanism on the ground."""
    return any(0 in (joint.start.body, joint.end.body) and joint.type not in _LOOSE for joint in scene.joints)


def _diagonal(points: Floats) -> float:
    good = points[np.isfinite(points).all(axis=1)]
    return float(np.linalg.norm(np.ptp(good, axis=0))) if len(good) else 0.0
