"""Frames: `translate`, `rotate`, `ground`; they compose with ``*``."""

from __future__ import annotations

from typing import Final

from symbody.errors import FrameError, Problem
from symbody.expr.expression import sqrt
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.sympy.sympy_writer import SympyExpr, SympyMatrix
from symbody.mbsymba.arguments import as_frame
from symbody.mbsymba.objects import FRAME, VECTOR
from symbody.mbsymba.workplace import WORKPLACE, to_expressions, triple
from symbody.spatial.matrix import Triple, Vector3
from symbody.spatial.moving import axis_rotation_step
from symbody.spatial.placed import GROUND_FRAME, PlacedFrame, Shift

ground: Final = FRAME(GROUND_FRAME)
"""The frame in which everything stands."""

_AXES: Final = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}


def translate(x: SympyExpr | float, y: SympyExpr | float, z: SympyExpr | float) -> FRAME:
    """Return the frame displaced by x, y, z."""
    return FRAME(PlacedFrame((Shift(triple(x, y, z)),)))


def rotate(axis: str | VECTOR, angle: SympyExpr | float) -> FRAME:
    """Return the frame turned by an angle [rad] about X, Y, Z or a vector.

    Parameters
    ----------
    axis : "X", "Y", "Z" or VECTOR
        Of a vector the components in its own frame count, which are those before the turn and after it; its
        length does not matter.

    Raises
    ------
    FrameError
        If the axis is neither, or the null vector.
    """
    return FRAME(PlacedFrame((axis_rotation_step(WORKPLACE.graph, _axis(axis), to_expressions([angle])[0]),)))


def inv_frame(RF: FRAME | SympyMatrix) -> FRAME:
    """Return the frame that leads back: ``RF * inv_frame(RF)`` is ground."""
    return FRAME(as_frame(RF, "inv_frame").inverse)


def _axis(axis: str | VECTOR) -> Triple:
    """Return the unit vector of an axis."""
    if isinstance(axis, str) and axis.upper() in _AXES:
        return triple(*_AXES[axis.upper()])
    if not isinstance(axis, VECTOR):
        raise FrameError(
            Problem("mbsymba.axis", "rotate", f"{axis!r} is not an axis", "",
                    "write 'X', 'Y', 'Z' or give a VECTOR")
        )  # fmt: skip
    direction = Vector3(axis.placed.components)
    square = direction.dot(direction)
    null, unit = find_zeros(square.graph, [square.index, (square - 1).index])
    if null:
        raise FrameError(
            Problem("mbsymba.null_axis", "rotate", "the axis is the null vector", "it has no direction",
                    "give a vector of nonzero length")
        )  # fmt: skip
    if unit:
        return direction
    x, y, z = direction
    length = sqrt(square)
    return (x / length, y / length, z / length)
