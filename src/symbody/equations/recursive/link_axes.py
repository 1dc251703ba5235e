"""The axes of links: z along the joint, x along the common normal to the next, origin at its foot.

Denavit & Hartenberg's choice in the form of Khalil & Kleinfinger (1986): what is constant between two joints
is then one turn about x, and the angle's offset goes into its sine and cosine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from symbody.equations.recursive.constants import (
    constant_rotation,
    matrix_numbers,
    numbers,
    twist_angles,
    variable_rotation,
)
from symbody.equations.recursive.links import LinkTransform
from symbody.equations.recursive.tree_joints import TreeJoint
from symbody.expr.expression import Expr, cos, number, sin
from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.matrix import Matrix3, Vector3, identity
from symbody.spatial.rotation import AxisRotation
from symbody.spatial.transform import CoordinateRotation, Step, Transform

# Below this sine of the angle between them, axes count as parallel: their common normal is far away.
_PARALLEL = 1e-3

Steps = tuple[Step[Expr], ...]


@dataclass(frozen=True, slots=True)
class LinkAxes:
    """The axes of one link.

    Attributes
    ----------
    transform : Transform
        In its group.
    steps : tuple of Step
        From its parent's axes.
    law : Matrix3
        The axes in which the law of the joint is written, in the near and in the far frame.
    shift : Expr
        From the far frame's origin to the link's, along z.
    """

    transform: LinkTransform
    steps: Steps
    law: Matrix3[Expr]
    shift: Expr


def choose_axes(joint: TreeJoint, parent: LinkTransform, following: Sequence[TreeJoint]) -> LinkAxes:
    """Return the axes of a link.

    Parameters
    ----------
    parent : Transform
        The parent link's axes in its group.
    following : sequence of TreeJoint
        The joints outward of the link.
    """
    graph = joint.near.position[0].graph
    near, far = parent.inverse.then(joint.near), joint.far
    zero = number(graph, 0)
    if joint.rotation == "none":  # it takes the parent's axes
        law = near.matrix.T
        return LinkAxes(Transform((far.matrix @ law,), far.position), (), law, zero)
    if joint.z is None:
        steps = (*_constant_steps(near.matrix), *(_step(step) for step in joint.steps))
        return LinkAxes(far, steps, identity(graph), zero)
    constant = near.matrix @ joint.z
    axes = Transform((far.matrix @ joint.z,), far.position)
    entries = matrix_numbers(constant)
    (turn,) = joint.steps
    assert isinstance(turn, AxisRotation)
    if entries is None:
        return LinkAxes(axes, (*_constant_steps(constant), _rotation(2, turn.angle)), joint.z, zero)
    a, alpha, b = twist_angles(entries)
    spin, shift = 0.0, zero
    if not joint.has_displacements:
        spin, shift = _adjustment(joint, near, entries, axes, following, b)
    position = axes.position + axes.matrix.T[2] * shift
    axes = Transform((axes.matrix @ constant_rotation(graph, 2, spin).matrix,), position)
    constants = [constant_rotation(graph, axis, value) for axis, value in ((2, a), (0, alpha)) if value]
    return LinkAxes(axes, (*constants, variable_rotation(2, b + spin, turn.angle)), joint.z, shift)


def _adjustment(
    joint: TreeJoint,
    near: LinkTransform,
    constant: Sequence[Sequence[float]],
    axes: LinkTransform,
    following: Sequence[TreeJoint],
    offset: float,
) -> tuple[float, Expr]:
    """Return the turn about z and the shift along z to the common normal with the next joint's axis."""
    inward = axes.inverse
    for other in following:
        if other.z is None:
            continue
        direction = inward.matrix @ (other.near.matrix @ other.z).T[2]
        d = numbers(direction)
        if d is None or math.hypot(d[0], d[1]) < _PARALLEL:
            continue
        return _least(math.atan2(d[0], -d[1])), _foot(inward.then(other.near).position, direction)
    # No axis outward in another direction: the common normal with the parent's; no shift along it is left.
    law = near.matrix if joint.z is None else near.matrix @ joint.z
    direction, position = law.T[2], near.position
    if joint.parent == "ground":
        return -offset, position[0] * 0
    if math.hypot(constant[0][2], constant[1][2]) < _PARALLEL:
        return -offset, -direction.dot(position)
    apart = 1 - direction[2] * direction[2]
    return -offset, (direction[2] * position[2] - direction.dot(position)) / apart


def _foot(point: Vector3[Expr], direction: Vector3[Expr]) -> Expr:
    """Return where on z the common normal with the line through a point stands."""
    z = direction[2]
    return (point[2] - z * point.dot(direction)) / (1 - z * z)


def _least(angle: float) -> float:
    """Return the angle, or the opposite direction, whichever is nearer to 0."""
    if angle > math.pi / 2 + 1e-12:
        return angle - math.pi
    return angle + math.pi if angle <= -math.pi / 2 + 1e-12 else angle


def _constant_steps(axes: Matrix3[Expr]) -> Steps:
    return () if axes == identity(axes[0][0].graph) else (axes,)


def _rotation(axis: int, angle: Expr) -> CoordinateRotation[Expr]:
    return CoordinateRotation(axis, cos(angle), sin(angle))


def _step(step: AxisRotation | EulerParameters) -> Step[Expr]:
    graph = (step.angle if isinstance(step, AxisRotation) else step.e0).graph
    if isinstance(step, AxisRotation):
        for k, row in enumerate(identity(graph)):
            if step.axis == row:
                return _rotation(k, step.angle)
            if step.axis == -row:
                return _rotation(k, -step.angle)
    return step.matrix(graph)
