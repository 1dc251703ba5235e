"""The law of every kind of joint in NumPy: rotation, shift, freedoms, speeds by name."""

from __future__ import annotations

import numpy as np

from tests.laws.parts import JointPart
from tests.laws.rotations import Array, of_quaternion, turned, unit

# What each coordinate is: a an angle, d a displacement, o the angles or the quaternion of an orientation.
LAYOUT = {
    "weld": "", "revolute": "a", "prismatic": "d", "screw": "a", "cylindrical": "ad", "universal": "aa",
    "constant_velocity": "aa", "pin_slot": "ad", "planar": "dda", "rectangular": "dd", "cartesian": "ddd",
    "spherical": "o", "gimbal": "o", "bearing": "do", "telescoping": "od", "free": "dddo",
}  # fmt: skip
FREEDOMS = {kind: sum(3 if letter == "o" else 1 for letter in word) for kind, word in LAYOUT.items()}
_NEXT = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}


def letters(joint: JointPart) -> str:
    """What each coordinate of a joint is, one letter each."""
    return LAYOUT[joint.kind].replace("o", "oooo" if joint.sequence == "quaternion" else "ooo")


def translations(joint: JointPart) -> tuple[str, ...]:
    """The coordinates that are lengths."""
    return tuple(name for name, word in zip(joint.names, letters(joint), strict=True) if word == "d")


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
    """The rotation matrix of an orientation."""
    values = tuple(x for x, word in zip(values, letters(joint), strict=True) if word == "o")
    if joint.sequence == "quaternion":
        return of_quaternion(np.array(values))
    r = np.eye(3)
    for letter, k in body_sequence(joint):
        r = r @ turned(letter, values[k])
    return r


def rotation(joint: JointPart) -> Array:
    """The matrix that takes components in the end frame to the start frame."""
    values = joint.values
    if joint.sequence:
        return orientation(joint, values)
    if joint.kind == "universal":
        return turned(joint.axis, values[0]) @ turned(joint.second, values[1])
    if joint.kind == "constant_velocity":
        # The bend is a turn about a line across the shaft, at the azimuth from the second axis after it.
        return turned(_bend_line(joint), values[0])
    angles = [x for x, word in zip(values, letters(joint), strict=True) if word == "a"]
    return turned(joint.axis, angles[0]) if angles else np.eye(3)


def _bend_line(joint: JointPart) -> tuple[float, float, float]:
    assert isinstance(joint.axis, str)
    first, second = in_plane(joint.axis)
    x, y, z = second * np.cos(joint.values[1]) - first * np.sin(joint.values[1])
    return (float(x), float(y), float(z))


def shift(joint: JointPart) -> Array:
    """The position of end's origin from start's, in start axes."""
    values = joint.values
    if joint.kind == "screw":
        return unit(joint.axis) * joint.pitch * values[0] / (2 * np.pi)
    if joint.kind == "telescoping":
        return rotation(joint) @ unit(joint.axis) * values[3]
    slides = freedoms(joint)[1]
    places = [k for k, word in enumerate(letters(joint)) if word == "d"]
    return sum((slides[:, k] * values[k] for k in places), np.zeros(3))


def freedoms(joint: JointPart) -> tuple[Array, Array]:
    """W, V (3, f): angular velocity of end and rate of the shift, in start axes, by the joint's freedoms.

    Freedoms are the rates of the coordinates; but the angular velocity in start axes of spherical joints and, after
    the rate of the shift, of free ones.
    """
    w, v = np.zeros((3, FREEDOMS[joint.kind])), np.zeros((3, FREEDOMS[joint.kind]))
    turning = [k for k, word in enumerate(LAYOUT[joint.kind].replace("o", "ooo")) if word != "d"]
    sliding = [k for k in range(w.shape[1]) if k not in turning]
    w[:, turning], v[:, sliding] = _turns(joint), _slides(joint)
    if joint.kind == "screw":
        v[:, 0] = w[:, 0] * joint.pitch / (2 * np.pi)
    if joint.kind == "telescoping":
        v[:, :3] = np.cross(w[:, :3], v[:, 3:] * joint.values[3], axis=0)
    return w, v


def _turns(joint: JointPart) -> Array:
    """The angular velocity in start axes for each freedom that turns, as columns."""
    if joint.kind == "universal":
        columns = [unit(joint.axis), turned(joint.axis, joint.values[0]) @ unit(joint.second)]
    elif joint.kind == "constant_velocity":
        columns = [np.array(_bend_line(joint)), unit(joint.axis) - rotation(joint) @ unit(joint.axis)]
    elif "o" in LAYOUT[joint.kind]:
        return np.eye(3) if joint.kind in ("spherical", "free") else angle_axes(joint)
    else:
        columns = [unit(joint.axis)] * LAYOUT[joint.kind].count("a")
    return np.array(columns).reshape(-1, 3).T


def _slides(joint: JointPart) -> Array:
    """The directions of displacements in start axes, as columns."""
    count = LAYOUT[joint.kind].count("d")
    if count == 3:
        return np.eye(3)
    if count == 2:
        assert isinstance(joint.axis, str)
        return np.array(in_plane(joint.axis)).T
    own = rotation(joint) @ unit(joint.axis) if joint.kind == "telescoping" else unit(joint.axis)
    return np.array([unit(joint.second) if joint.kind == "pin_slot" else own] * count).reshape(-1, 3).T


def angle_axes(joint: JointPart) -> Array:
    """The axis of each angle of an orientation in start axes, as columns in the order of the angles."""
    values = [x for x, word in zip(joint.values, letters(joint), strict=True) if word == "o"]
    r, axes = np.eye(3), np.zeros((3, 3))
    for letter, k in body_sequence(joint):
        axes[:, k] = r @ unit(letter)
        r = r @ turned(letter, values[k])
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
    along = np.array([efforts.get(name, 0.0) for name in joint.names])
    w, v = freedoms(joint)
    turning = np.array([name not in translations(joint) for name in joint.names], dtype=bool)
    if joint.sequence == "quaternion":  # nothing can drive its components
        return v[:, :3] @ along[:3] if joint.kind == "free" else np.zeros(3), np.zeros(3)
    if joint.kind in ("spherical", "free"):
        w[:, -3:] = angle_axes(joint)
    force = v[:, ~turning] @ along[~turning]
    # The moment in the plane of the turns whose component about the axis of each angle is the effort along it.
    moment = np.linalg.pinv(w[:, turning].T) @ along[turning] if along[turning].any() else np.zeros(3)
    return force, moment
