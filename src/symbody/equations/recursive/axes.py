"""The axes of links: z along the joint, x along the common normal to the next, origin at its foot.

Denavit & Hartenberg's choice in the form of Khalil & Kleinfinger (1986): what is constant between two joints
is then one turn about x, and the angle's offset goes into its sine and cosine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from symbody.equations.recursive.constants import (
    constant_turn,
    matrix_numbers,
    numbers,
    turn_about,
    twist_angles,
)
from symbody.equations.recursive.placing import Hinge, Pose
from symbody.equations.recursive.turned import AxisTurn, Step, Steps
from symbody.expr.expression import Expr, cos, number, sin
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, identity, inner, product, transpose
from symbody.vectors.rotation import EulerParameters, Turn

# Below this sine of the angle between them, axes count as parallel: their common normal is far away.
_PARALLEL = 1e-3


@dataclass(frozen=True, slots=True)
class Placed:
    """The axes of one link.

    Attributes
    ----------
    pose : Pose
        In its group.
    steps : tuple of Step
        From its parent's axes.
    law : Matrix
        The axes in which the law of the joint is written, in the near and in the far frame.
    slide : Expr
        From the far frame's origin to the link's, along z.
    """

    pose: Pose
    steps: Steps
    law: Matrix
    slide: Expr


def place_axes(hinge: Hinge, parent: Pose, following: Sequence[Hinge]) -> Placed:
    """Return the axes of a link.

    Parameters
    ----------
    parent : Pose
        Of the parent link's axes in its group.
    following : sequence of Hinge
        The joints outward of the link.
    """
    graph = hinge.near.at[0].graph
    near = parent.inverse.then(hinge.near)
    slide = number(graph, 0)
    if hinge.turning == "none":  # it takes the parent's axes
        law = transpose(near.axes)
        return Placed(Pose(product(hinge.far.axes, law), hinge.far.at), (), law, slide)
    if hinge.z is None:
        own = (*_constant(near.axes), *(_step(step) for step in hinge.steps))
        return Placed(hinge.far, own, identity(graph), slide)
    constant = product(near.axes, hinge.z)
    pose = Pose(product(hinge.far.axes, hinge.z), hinge.far.at)
    found = matrix_numbers(constant)
    (turn,) = hinge.steps
    assert isinstance(turn, Turn)
    angle = turn.angle
    if found is None:
        return Placed(pose, (*_constant(constant), _plain(2, angle)), hinge.z, slide)
    a, alpha, b = twist_angles(found)
    spin = 0.0
    if not hinge.sliding:
        spin, slide = _adjustment(hinge, near, found, pose, following, b)
    axes = product(pose.axes, constant_turn(graph, 2, spin).matrix)
    at = tuple(x + slide * z for x, z in zip(pose.at, (row[2] for row in pose.axes), strict=True))
    pose = Pose(axes, (at[0], at[1], at[2]))
    steps = [constant_turn(graph, axis, value) for axis, value in ((2, a), (0, alpha)) if value]
    return Placed(pose, (*steps, turn_about(2, b + spin, angle)), hinge.z, slide)


def _adjustment(
    hinge: Hinge,
    near: Pose,
    constant: Sequence[Sequence[float]],
    pose: Pose,
    following: Sequence[Hinge],
    offset: float,
) -> tuple[float, Expr]:
    """Return the turn about z and the shift along z to the common normal with the next joint's axis."""
    zero = near.at[0] * 0
    inward = pose.inverse
    for other in following:
        if other.z is None:
            continue
        direction = apply_matrix(inward.axes, _column(product(other.near.axes, other.z), 2))
        d = numbers(direction)
        if d is None or math.hypot(d[0], d[1]) < _PARALLEL:
            continue
        place = inward.then(other.near).at
        return _least(math.atan2(d[0], -d[1])), _foot(place, direction)
    # No other axis outward: the common normal with the parent's, so that no shift along it is left.
    direction, arm = _column(_law_axes(near.axes, hinge), 2), near.at
    if hinge.parent == "ground":
        return -offset, zero
    if math.hypot(constant[0][2], constant[1][2]) < _PARALLEL:
        return -offset, -inner(direction, arm)
    apart = 1 - direction[2] * direction[2]
    return -offset, (direction[2] * arm[2] - inner(direction, arm)) / apart


def _law_axes(axes: Matrix, hinge: Hinge) -> Matrix:
    """Return the axes in which a joint's law is written, in its parent's axes."""
    return axes if hinge.z is None else product(axes, hinge.z)


def _foot(place: Triple, direction: Triple) -> Expr:
    """Return where on z the common normal with a line stands."""
    z = direction[2]
    return (place[2] - z * inner(place, direction)) / (1 - z * z)


def _least(angle: float) -> float:
    """Return the angle, or the opposite direction, whichever is nearer to 0."""
    if angle > math.pi / 2 + 1e-12:
        return angle - math.pi
    return angle + math.pi if angle <= -math.pi / 2 + 1e-12 else angle


def _constant(axes: Matrix) -> tuple[Step, ...]:
    return () if axes == identity(axes[0][0].graph) else (axes,)


def _plain(axis: int, angle: Expr) -> AxisTurn:
    return AxisTurn(axis, cos(angle), sin(angle))


def _step(step: Turn | EulerParameters) -> Step:
    graph = (step.angle if isinstance(step, Turn) else step.e0).graph
    if isinstance(step, Turn):
        for k, row in enumerate(identity(graph)):
            if step.axis == row:
                return _plain(k, step.angle)
            if step.axis == tuple(-x for x in row):
                return _plain(k, -step.angle)
    return step.matrix(graph)


def _column(m: Matrix, k: int) -> Triple:
    return (m[0][k], m[1][k], m[2][k])
