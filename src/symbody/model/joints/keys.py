"""Whether what a joint has by coordinate, drives and motions, belongs to coordinates that can have it."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.errors import nearest
from symbody.model.door import Door
from symbody.model.joint import Joint


def check_keys(joint: Joint, door: Door) -> None:
    """Note drives and motions of coordinates that cannot have them."""
    if not (joint.force or joint.torque or joint.motion):
        return
    angles, displacements = joint.angle_coordinates, joint.translation_coordinates
    for word, keys, own in (
        ("force", joint.force, displacements),
        ("torque", joint.torque, angles),
        ("motion", joint.motion, (*displacements, *angles)),
    ):
        for key in keys:
            if key not in own:
                _refuse(joint, door, word, key, own)
    if not joint.as_constraint:
        _check_motions(joint, door)


def _refuse(joint: Joint, door: Door, word: str, key: str, own: Iterable[str]) -> None:
    path = joint.path_of(word, key)
    if key in (joint.quaternion or ()):
        door.refuse(
            "model.quaternion_component",
            path,
            f"{key} is a component of a quaternion, which nothing can drive by itself",
            "the four components depend on each other",
            'choose angles, for instance angles = "313"; or let a [[torque]] act on the body',
        )
    elif key in joint.coordinates:
        other = "torque" if word == "force" else "force"
        door.refuse(
            "model.wrong_drive",
            path,
            f"{key} is {'an angle' if word == 'force' else 'a displacement'}",
            "force holds displacements, torque holds angles",
            f"write {other} instead of {word}",
        )
    else:
        door.refuse(
            "model.unknown_coordinate", path, f"the joint has no coordinate {key!r}", "", nearest(key, own)
        )


def _check_motions(joint: Joint, door: Door) -> None:
    """Note prescribed coordinates whose rates are no speeds, so that they cannot leave the unknowns."""
    for names, speeds in (
        (joint.rotation_coordinates, joint.rotation_speeds),
        (joint.translation_coordinates, joint.translation_speeds),
    ):
        for name in joint.motion:
            if name in names and speeds is not None and name not in (joint.quaternion or ()):
                door.refuse(
                    "model.motion_without_rate",
                    joint.path_of("motion", name),
                    f"the rate of {name} is not among the speeds of the joint",
                    f"its speeds are {', '.join(speeds.names)}",
                    'write speeds = "rates", or as_constraint = true',
                )
