"""Three successive turns: the 24 sequences of angles, their rates, and the angles of a given matrix.

A sequence is written ``"313"`` or ``"zxz"`` for turns about body axes, R = R_3 R_1 R_3 from end to start;
``"space 313"`` turns about the axes of the start frame, which is the reverse order about body axes.
Kane, Likins & Levinson, Spacecraft Dynamics (1983), sections 1.7 and 1.10.
"""

from __future__ import annotations

from typing import Final

from symbody.errors import FrameError, Problem
from symbody.expr.expression import Expr, atan2, cos, sin
from symbody.expr.graph import Graph
from symbody.spatial.euler_parameters import Side
from symbody.spatial.matrix import Matrix, Triple, Vector3, identity
from symbody.spatial.rotation import AxisRotation, axis_rotation_matrix

_LETTERS: Final = {"1": "x", "2": "y", "3": "z", "x": "x", "y": "y", "z": "z"}
_SPACE: Final = "space "


def sequence_axes(sequence: str) -> tuple[tuple[str, str, str], bool]:
    """Return the three axes as letters, in the order written, and whether they are space axes.

    Raises
    ------
    FrameError
        Unless there are three axes, x y z or 1 2 3, of which neighbours differ.
    """
    is_space = sequence.startswith(_SPACE)
    written = sequence.removeprefix(_SPACE).strip()
    letters = [_LETTERS.get(sign, "") for sign in written]
    if len(letters) != 3 or not all(letters):
        raise _sequence_error(
            sequence, "does not name three axes", "its signs must be x y z or 1 2 3, lower case"
        )
    first, second, third = letters
    if second in (first, third):
        raise _sequence_error(
            sequence,
            "rotates twice in succession about one axis",
            "two such rotations are a single one, by the sum of the angles",
        )
    return (first, second, third), is_space


def euler_rotations(
    graph: Graph, sequence: str, angles: Triple
) -> tuple[AxisRotation, AxisRotation, AxisRotation]:
    """Return the turns from start to end, about body axes; `angles` in the order of the written axes."""
    axes, is_space = sequence_axes(sequence)
    units = dict(zip("xyz", identity(graph), strict=True))
    first, second, third = (
        AxisRotation(units[axis], angle) for axis, angle in zip(axes, angles, strict=True)
    )
    return (third, second, first) if is_space else (first, second, third)


def angle_rates(
    graph: Graph, turns: tuple[AxisRotation, ...], omega: Triple, resolved_in: Side = "end"
) -> tuple[Triple, Expr]:
    """Return the rates of the angles of three turns, and the determinant that was divided by.

    Parameters
    ----------
    turns : tuple of AxisRotation
        In body order; the rates come in the same order.
    omega : (3,) Expr
        Angular velocity of end relative to start, in axes of start or end.

    Notes
    -----
    ``omega = q1' a1 + q2' a2 + q3' a3`` is solved with the dual basis of the axes, in the frame after
    the first turn (`omega` in start axes) or after the second (end axes): there two axes are constants and
    the third turns with the middle angle only. The determinant ``a1 . (a2 x a3)`` vanishes where the
    sequence is singular.

    Raises
    ------
    FrameError
        Unless there are three turns.
    """
    first, second, third = _check_three(turns)
    middle, w = axis_rotation_matrix(graph, second), Vector3(omega)
    axes = [Vector3(turn.axis) for turn in (first, second, third)]
    if resolved_in == "start":
        a1, a2, a3 = axes[0], axes[1], middle @ axes[2]
        seen = axis_rotation_matrix(graph, first).T @ w
    else:
        a1, a2, a3 = middle.T @ axes[0], axes[1], axes[2]
        seen = axis_rotation_matrix(graph, third) @ w
    if not (a1.dot(a2).is_zero and a2.dot(a3).is_zero):
        determinant = a1.cross(a2).dot(a3)
        dual = (a2.cross(a3), a3.cross(a1), a1.cross(a2))
        x, y, z = (axis.dot(seen) / determinant for axis in dual)
        return (x, y, z), determinant
    # The middle axis stands on both others: its rate is a component. One of the outer rates comes from
    # the dual vector of constant axes, the other from the component of omega along its own axis.
    if resolved_in == "start":
        determinant = a1.cross(a2).dot(a3)
        rate3 = a1.cross(a2).dot(seen) / determinant
        return (axes[0].dot(w) - a1.dot(a3) * rate3, a2.dot(seen), rate3), determinant
    determinant = a1.dot(a2.cross(a3))
    rate1 = a2.cross(a3).dot(seen) / determinant
    return (rate1, a2.dot(seen), axes[2].dot(w) - a1.dot(a3) * rate1), determinant


def angles_of_matrix(matrix: Matrix, sequence: str) -> Triple:
    """Return the angles [rad] of a rotation matrix, in the order of the written axes.

    The middle angle lies in [0, pi] if the outer axes are the same, else in [-pi/2, pi/2]. Where the
    sequence is singular the last body angle takes the turn of both, or all but a half turn.
    """
    axes, is_space = sequence_axes(sequence)
    if is_space:
        first, second, third = angles_of_matrix(matrix, "".join(reversed(axes)))
        return (third, second, first)
    i, j = "xyz".index(axes[0]), "xyz".index(axes[1])
    k = 3 - i - j
    sense = 1 if (j - i) % 3 == 1 else -1  # of i, j, k: right-handed or not
    if axes[0] == axes[2]:
        first = atan2(matrix[j][i], -sense * matrix[k][i])
        across = sin(first) * matrix[j][i] - sense * (cos(first) * matrix[k][i])
        second = atan2(across, matrix[i][i])
    else:
        first = atan2(-sense * matrix[j][k], matrix[k][k])
        across = cos(first) * matrix[k][k] - sense * (sin(first) * matrix[j][k])
        second = atan2(sense * matrix[i][k], across)
    # With the first turn taken back, row j is that of the last turn alone: the middle one leaves it.
    row = [cos(first) * x + sense * (sin(first) * y) for x, y in zip(matrix[j], matrix[k], strict=True)]
    sine = -sense * row[k] if axes[0] == axes[2] else sense * row[i]
    return (first, second, atan2(sine, row[j]))


def _check_three(turns: tuple[AxisRotation, ...]) -> tuple[AxisRotation, AxisRotation, AxisRotation]:
    if len(turns) != 3:
        raise FrameError(
            Problem("frame.three_turns", "angles",
                    f"an angular velocity has three components, but the orientation has {len(turns)} angles",
                    "an angular velocity determines the rates of the angles only if there are three",
                    "give the speeds as rates of the angles")
        )  # fmt: skip
    return (turns[0], turns[1], turns[2])


def _sequence_error(sequence: str, what: str, why: str) -> FrameError:
    return FrameError(
        Problem("frame.sequence", "angles", f"the sequence {sequence!r} {what}", why,
                'write three axes, with neighbouring axes different, as "313", "zyx" or "space 123"')
    )  # fmt: skip
