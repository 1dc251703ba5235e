"""The law of every kind of joint in NumPy: rotation, shift, freedoms, speeds by name."""

from __future__ import annotations

import numpy as np

from tests.laws.parts import JointPart
from tests.laws.rotations import Array, of_quaternion, turned, unit

FREEDOMS = {"weld": 0, "revolute": 1, "prismatic": 1, "planar": 3, "spherical": 3, "free": 6}
_NEXT = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}


def in_plane(normal: str) -> tuple[Array, Array]:
    """The two directions of a plane, cyclic after its normal."""
    first, second = _NEXT[normal]
    return unit(first), unit(second)


def body_sequence(joint: JointPart) -> list[tuple[str, int]]:
    """The turns from start to end: letter, and which of the three angles."""
    word = joint.sequence
    letters = ["xyz"["123".index(c)] if c in "123" else c for c in word.removeprefix("space ")]
    turns = list(zip(letters, range(3), strict=True))
    return turns[::-1] if word.startswith("space ") else turns


def orientation(joint: JointPart, values: tuple[float, ...]) -> Array:
    """The rotation matrix of a spherical or free joint from its last coordinates."""
    if joint.sequence == "quaternion":
        return of_quaternion(np.array(values[-4:]))
    r = np.eye(3)
    for letter, k in body_sequence(joint):
        r = r @ turned(letter, values[len(values) - 3 + k])
    return r


def rotation(joint: JointPart) -> Array:
    """The matrix that takes components in the end frame to the start frame."""
    values = joint.values
    if joint.kind == "revolute":
        return turned(joint.axis, values[0])
    if joint.kind == "planar":
        return turned(joint.axis, values[2])
    if joint.kind in ("spherical", "free"):
        return orientation(joint, values)
    return np.eye(3)


def shift(joint: JointPart) -> Array:
    """The position of end's origin from start's, in start axes."""
    if joint.kind == "prismatic":
        return unit(joint.axis) * joint.values[0]
    if joint.kind == "planar":
        assert isinstance(joint.axis, str)
        first, second = in_plane(joint.axis)
        return first * joint.values[0] + second * joint.values[1]
    if joint.kind == "free":
        return np.array(joint.values[:3])
    return np.zeros(3)


def freedoms(joint: JointPart) -> tuple[Array, Array]:
    """W, V (3, f): angular velocity of end and rate of the shift, in start axes, by the joint's freedoms.

    Freedoms are the rates of revolute, prismatic and planar joints, the angular velocity in start axes of
    spherical ones; of free joints the rate of the shift, then the angular velocity.
    """
    n = FREEDOMS[joint.kind]
    w, v = np.zeros((3, n)), np.zeros((3, n))
    if joint.kind == "revolute":
        w[:, 0] = unit(joint.axis)
    elif joint.kind == "prismatic":
        v[:, 0] = unit(joint.axis)
    elif joint.kind == "planar":
        assert isinstance(joint.axis, str)
        v[:, 0], v[:, 1] = in_plane(joint.axis)
        w[:, 2] = unit(joint.axis)
    elif joint.kind == "spherical":
        w[:] = np.eye(3)
    elif joint.kind == "free":
        v[:, :3] = w[:, 3:] = np.eye(3)
    return w, v


def angle_axes(joint: JointPart) -> Array:
    """The axis of each angle in start axes, as columns in the order of the angles."""
    r, axes = np.eye(3), np.zeros((3, 3))
    for letter, k in body_sequence(joint):
        axes[:, k] = r @ unit(letter)
        r = r @ turned(letter, joint.values[len(joint.values) - 3 + k])
    return axes


def rates(joint: JointPart, s: Array) -> dict[str, float]:
    """``<coordinate>_dot`` from the freedoms; not of quaternions."""
    if joint.kind in ("spherical", "free"):
        found = dict(zip(joint.names[:3], s[:3], strict=True)) if joint.kind == "free" else {}
        if joint.sequence != "quaternion":
            angles = np.linalg.solve(angle_axes(joint), s[-3:])
            found |= dict(zip(joint.names[-3:], angles, strict=True))
    else:
        found = dict(zip(joint.names, s, strict=True))
    return {f"{name}_dot": float(value) for name, value in found.items()}


def speed_words(joint: JointPart) -> tuple[str, ...]:
    """Names of the quasi-speeds, () where the speeds are rates."""
    if joint.speeds == "rates":
        return ()
    if joint.speed_names:
        return joint.speed_names
    words = ("wx", "wy", "wz") if joint.kind == "spherical" else ("vx", "vy", "vz", "wx", "wy", "wz")
    return tuple(f"{joint.name}_{word}" for word in words)


def speeds(joint: JointPart, s: Array) -> dict[str, float]:
    """Every speed the joint can have in u, by name: rates, and quasi-speeds where it has them."""
    found = rates(joint, s)
    words = speed_words(joint)
    if words:
        to_end = rotation(joint).T
        w = s[-3:] if joint.speeds == "start" else to_end @ s[-3:]
        if joint.kind == "free":
            v = to_end @ s[:3] if joint.speeds == "twist" else s[:3]
            w = np.concatenate([v, w])
        found |= {name: float(value) for name, value in zip(words, w, strict=True)}
    return found


def effort_wrench(joint: JointPart, efforts: dict[str, float]) -> tuple[Array, Array]:
    """Force and moment about end's origin, in start axes, that efforts along the coordinates mean."""
    force, moment = np.zeros(3), np.zeros(3)
    w, v = freedoms(joint)
    if joint.kind in ("spherical", "free"):
        # The moment whose component about the axis of each angle is the effort along it.
        along = np.array([efforts.get(name, 0.0) for name in joint.names[-3:]])
        if joint.sequence != "quaternion" and along.any():
            moment = np.linalg.solve(angle_axes(joint).T, along)
        if joint.kind == "free":
            force = np.array([efforts.get(name, 0.0) for name in joint.names[:3]])
        return force, moment
    for k, name in enumerate(joint.names):
        force = force + v[:, k] * efforts.get(name, 0.0)
        moment = moment + w[:, k] * efforts.get(name, 0.0)
    return force, moment
