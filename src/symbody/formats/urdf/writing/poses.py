"""Frames of a model in numbers, as URDF's origins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from symbody.formats.urdf.file.placement import (
    ONE,
    Numbers,
    Rows,
    apply,
    numeral,
    product,
    total,
    transpose,
)
from symbody.formats.urdf.writing.values import Values
from symbody.model.frame import Frame


@dataclass(frozen=True, slots=True)
class UrdfPose:
    """A frame in another, by its rotation matrix."""

    at: Numbers = (0, 0, 0)
    rows: Rows = ONE

    def then(self, inner: UrdfPose) -> UrdfPose:
        """Return the pose of a frame that stands in this one."""
        x, y, z = (total(pair) for pair in zip(self.at, apply(self.rows, inner.at), strict=True))
        return UrdfPose((x, y, z), product(self.rows, inner.rows))

    def inverse(self) -> UrdfPose:
        """Return the pose of the other frame in this one."""
        back = transpose(self.rows)
        x, y, z = apply(back, self.at)
        return UrdfPose((-x, -y, -z), back)

    def origin(self) -> str:
        """Return the element of URDF."""
        words = {"xyz": self.at, "rpy": roll_pitch_yaw(self.rows)}
        inside = "".join(
            f' {key}="{" ".join(map(numeral, value))}"' for key, value in words.items() if any(value)
        )
        return f"<origin{inside}/>"


def frame_pose(frame: Frame, values: Values) -> UrdfPose:
    """Return where a frame stands on its body."""
    rows = ONE
    for turn in frame.turns():
        rows = product(rows, _rotation_rows([values.number(x) for x in turn.axis], values.number(turn.angle)))
    x, y, z = map(values.number, frame.at)
    return UrdfPose((x, y, z), rows)


def roll_pitch_yaw(R: Rows) -> Numbers:
    """Return the angles about fixed x, y, z of a rotation; yaw is 0 where only its sum with roll counts."""
    cosine = math.hypot(float(R[0][0]), float(R[1][0]))
    pitch = math.atan2(-float(R[2][0]), cosine)
    if cosine > 1e-9:
        return math.atan2(float(R[2][1]), float(R[2][2])), pitch, math.atan2(float(R[1][0]), float(R[0][0]))
    roll = math.atan2(-float(R[1][2]), float(R[1][1]))
    return roll, math.copysign(math.pi / 2, pitch), 0


def _rotation_rows(axis: Sequence[float], angle: float) -> Rows:
    """Return the rotation matrix about a unit vector (Rodrigues), exact for right angles about main axes."""
    c, s = math.cos(angle), math.sin(angle)
    quarters = round(angle * 2 / math.pi)
    if abs(angle - quarters * math.pi / 2) < 4e-16 * max(1.0, abs(angle)):
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
    x, y, z = axis
    d = 1 - c
    return (
        (c + x * x * d, x * y * d - z * s, x * z * d + y * s),
        (x * y * d + z * s, c + y * y * d, y * z * d - x * s),
        (x * z * d - y * s, y * z * d + x * s, c + z * z * d),
    )
