"""Where bodies and frames stand, in numbers."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from symbody.expr.language.formula import Formula
from symbody.model.element import FrameRef
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.visual.scene.numbers import ModelNumbers
from symbody.visual.scene.scene import Floats, Point, Quaternion

_LETTERS: Final = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# Entries of rotation matrices below this are rounding: right angles stay right.
_ROUNDING: Final = 1e-15


def _origin() -> Floats:
    return np.zeros(3)


def _axes() -> Floats:
    return np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class RigidTransform:
    """A frame in another.

    Attributes
    ----------
    at : (3,) array
        Its origin [m].
    axes : (3, 3) array
        Its axes as columns.
    """

    at: Floats = field(default_factory=_origin)
    axes: Floats = field(default_factory=_axes)

    def __matmul__(self, inner: RigidTransform) -> RigidTransform:
        """Return where a frame stands that stands so in this one."""
        return RigidTransform(self.at + self.axes @ inner.at, self.axes @ inner.axes)

    def inverse(self) -> RigidTransform:
        """Return where the other frame stands in this one."""
        return RigidTransform(-self.axes.T @ self.at, self.axes.T)

    def point(self, point: Floats) -> Floats:
        """Return a point of this frame (3,) or several (N, 3) in the other."""
        return np.asarray(self.at + point @ self.axes.T)

    @property
    def quaternion(self) -> Quaternion:
        """From this frame's axes to the other's, scalar first and not negative."""
        return matrix_quaternion(self.axes)

    @property
    def place(self) -> Point:
        """The origin as plain numbers."""
        return as_point(self.at)


def as_point(vector: Floats) -> Point:
    """Return three components as plain numbers."""
    x, y, z = (float(component) + 0.0 for component in vector)  # no minus zero
    return (x, y, z)


def matrix_quaternion(matrix: Floats) -> Quaternion:
    """Return the quaternion of a rotation matrix (3, 3), scalar first and not negative.

    Pictures hold hundreds of them, each of which costs a library that takes arrays a tenth of a millisecond.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    if a == e == i == 1.0 and not (b or c or d or f or g or h):  # as most frames stand
        return (1.0, 0.0, 0.0, 0.0)
    # four times the products of one component, the largest, with all of them
    products = max(
        ((1.0 + a + e + i, h - f, c - g, d - b), 0), ((h - f, 1.0 + a - e - i, b + d, c + g), 1),
        ((c - g, b + d, 1.0 - a + e - i, f + h), 2), ((d - b, c + g, f + h, 1.0 - a - e + i), 3),
        key=lambda row: row[0][row[1]],
    )[0]  # fmt: skip
    length = math.sqrt(math.fsum(part * part for part in products))
    sign = math.copysign(length, next((part for part in products if part), 1.0))
    w, x, y, z = (part / sign for part in products)
    return (w + 0.0, x + 0.0, y + 0.0, z + 0.0)  # no minus zero


def rotation_matrix(quaternion: Quaternion) -> Floats:
    """Return the matrix (3, 3) of a quaternion, scalar first."""
    w, x, y, z = quaternion
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())


def axis_rotation(axis: Floats, angle: float) -> Floats:
    """Return the matrix (3, 3) of a rotation about a unit vector."""
    x, y, z = axis.tolist()
    sine, cosine, half = math.sin(angle), math.cos(angle), math.sin(0.5 * angle)
    rise = 2.0 * half * half  # 1 - cosine
    a, b, c = sine * x, sine * y, sine * z
    matrix = np.array([
        [cosine + rise * x * x, rise * x * y - c, rise * x * z + b],
        [rise * x * y + c, cosine + rise * y * y, rise * y * z - a],
        [rise * x * z - b, rise * y * z + a, cosine + rise * z * z],
    ])  # fmt: skip
    matrix[np.abs(matrix) < _ROUNDING] = 0.0
    return matrix


def axes_along(direction: Floats, sideways: Floats | None = None) -> Floats:
    """Return axes as columns whose third is a unit vector.

    Parameters
    ----------
    sideways : (3,) array, optional
        The first axis is the part of it that is across `direction`.
    """
    x, y, z = direction.tolist()
    candidates = [_LETTERS[k] for k in sorted(range(3), key=lambda k: abs((x, y, z)[k]))]
    for a, b, c in candidates if sideways is None else [sideways.tolist(), *candidates]:
        along = a * x + b * y + c * z
        a, b, c = a - along * x, b - along * y, c - along * z
        length = math.sqrt(a * a + b * b + c * c)
        if length > 1e-6:
            a, b, c = a / length, b / length, c / length
            return np.array([[a, y * c - z * b, x], [b, z * a - x * c, y], [c, x * b - y * a, z]])
    return np.eye(3)


def frame_transform(frame: Frame, numbers: ModelNumbers) -> RigidTransform:
    """Return where a frame stands on its body."""
    at = numbers.vector(frame.at)
    if frame.matrix is not None:
        matrix = np.array([numbers.vector(row) for row in frame.matrix])
        return RigidTransform(at, nearest_rotation(matrix))
    axes = np.eye(3)
    for axis, angle in frame.rotate:
        axes = axes @ axis_rotation(numbers.axis(axis), numbers.number(angle))
    return RigidTransform(at, axes)


def nearest_rotation(matrix: Floats) -> Floats:
    """Return a matrix of numbers that is a rotation; no rotation where it is not near one."""
    left, sizes, right = np.linalg.svd(matrix)
    rotation = left @ right
    return rotation if sizes[-1] > 0.0 and np.linalg.det(rotation) > 0.0 else np.eye(3)


def frame_transforms(model: Model, numbers: ModelNumbers) -> dict[FrameRef, RigidTransform]:
    """Return where each frame stands on its body; those of centres of mass included."""
    transforms = {
        FrameRef(body): RigidTransform() for body in (GROUND, *(body.name for body in model.bodies))
    }
    owners: list[tuple[str, Mapping[str, Frame]]] = [(GROUND, model.ground)]
    owners += [(body.name, body.frames) for body in model.bodies]
    for body, frames in owners:
        for name, frame in frames.items():
            transforms[FrameRef(body, name)] = frame_transform(frame, numbers)
    return transforms


def joint_transform(joint: Joint, numbers: ModelNumbers, coordinates: Mapping[str, float]) -> RigidTransform:
    """Return where the end frame of a joint stands in its start frame."""
    axes = np.eye(3)
    for turn in joint.turns():
        axis = numbers.axis(turn.axis)
        axes = axes @ axis_rotation(axis, numbers.number(turn.angle, 0.0, **coordinates))
    if joint.quaternion is not None:
        w, x, y, z = (coordinates[name] for name in joint.quaternion)
        norm = np.linalg.norm([w, x, y, z])
        axes = np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix()) if norm > 0.0 else axes
    shift = numbers.vector(joint.shift(), **coordinates)
    return RigidTransform(axes @ shift if joint.shift_in == "end" else shift, axes)


def joint_coordinates(
    joint: Joint, numbers: ModelNumbers, values: Mapping[str, Formula | float]
) -> dict[str, float]:
    """Return a value of each coordinate of a joint: as given, as prescribed at the time 0, else zero."""
    result = {}
    for name in joint.coordinates:
        upright = 1.0 if joint.quaternion is not None and name == joint.quaternion[0] else 0.0
        value = values.get(name, joint.motion.get(name, upright))
        result[name] = numbers.number(value, upright) if isinstance(value, Formula) else float(value)
    return result


def body_transforms(
    joints: Iterable[Joint],
    frames: Mapping[FrameRef, RigidTransform],
    steps: Mapping[str, RigidTransform],
    doubtful: Collection[str] = (),
) -> dict[str, RigidTransform]:
    """Return where bodies stand in ground's axes, from joint to joint; joints that close loops are left out.

    Parameters
    ----------
    steps : mapping of joint to RigidTransform
        Where its end frame stands in its start frame.
    doubtful : collection of joint
        Those whose coordinates are not known: bodies are placed over others where that can be.
    """
    waiting = sorted(joints, key=lambda joint: joint.name in doubtful)
    transforms = {GROUND: RigidTransform()}
    while True:
        joint = next((each for each in waiting if _leads_on(each, transforms)), None)
        if joint is None:
            return transforms
        waiting.remove(joint)
        step = frames[joint.start] @ steps[joint.name] @ frames[joint.end].inverse()
        if joint.start.body in transforms:
            transforms[joint.end.body] = transforms[joint.start.body] @ step
        else:
            transforms[joint.start.body] = transforms[joint.end.body] @ step.inverse()


def _leads_on(joint: Joint, reached: Collection[str]) -> bool:
    """Return whether one body of a joint is among those reached, and the other is not."""
    return (joint.start.body in reached) != (joint.end.body in reached)
