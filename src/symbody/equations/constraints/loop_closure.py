"""Loop closure: the constraint equations of a cut joint, each with the wrench it transmits.

A row of rotation says that an axis fixed in one frame stays perpendicular to an axis of the end frame; a
row of translation, that the end's origin does not move along a direction of the start frame, or of the end
frame where the joint shifts along its axes. Both are formed with vectors, so that velocity and acceleration
rows hold no derivatives of products of sines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.frame_placement import joint_shift, predicted_frame
from symbody.equations.kinematics.joint_axes import (
    complete_axes,
    free_directions,
    perpendiculars,
    unit_axes,
)
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, axis_rotations
from symbody.expr.expression import Expr
from symbody.model.joint import Joint
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import ZERO, Vector, cross, dot, vector

# An axis of a frame and an axis of the end frame.
_Pair = tuple[str, Triple, Triple]


def loop_closure_equations(names: Names, kinematics: Kinematics, role: JointRole) -> list[ConstraintEquation]:
    """Return the rows of a joint that is not in both trees.

    They are counted as they come: locked translations, locked rotations, then the coordinates in use.
    """
    joint = role.joint
    closing = _LoopClosure(kinematics, joint)
    locked: list[ConstraintEquation] = []
    measured: list[ConstraintEquation] = []
    if not role.in_translation:
        free = free_directions(names, joint)
        shift = joint_shift(names, joint)
        tied = shift if joint.coupled_coordinates else ZERO
        locked += [
            closing.translation_equation(direction, tied) for direction in complete_axes(names.graph, free)
        ]
        if role.has_displacements:
            measured += [closing.translation_equation(direction, shift) for direction in free]
    if not role.in_rotation:
        pairs, extra = _axis_pairs(names, role)
        locked += [closing.rotation_equation(*pair) for pair in pairs]
        locked += [closing.twist_equation(*axes) for axes in _shaft(names, role)]
        measured += [closing.rotation_equation(*pair) for pair in extra]
    rows = enumerate([*locked, *measured], start=1)
    return [replace(row, name=f"lambda_{joint.name}_{k}") for k, row in rows]


def assembly_mode(names: Names, kinematics: Kinematics, role: JointRole) -> list[Expr]:
    """Return the cosines between axes that coincide where a cut joint is closed.

    Its rows are products of perpendicular axes and hold for opposite ones too.
    """
    joint, tree = role.joint, kinematics.tree
    if role.in_rotation:
        return []
    start, end = joint.start.full_name, joint.end.full_name
    turns = axis_rotations(names, joint.turns(), f"joint {joint.name}")
    axes = list(unit_axes(names.graph))
    if role.has_angles and joint.quaternion is None:
        start = predicted_frame(joint.name)
    elif len(turns) == 1:
        axes = [turns[0].axis]
    elif joint.is_untwisted:
        first, second = perpendiculars(names.graph, turns[0].axis)
        homes = tree.orientation_frame(start), tree.orientation_frame(end)
        pairs = [(vector(homes[0], axis), vector(homes[1], axis)) for axis in (first, second)]
        return [dot(tree, *pairs[0]) + dot(tree, *pairs[1])]
    elif turns or joint.quaternion is not None:
        return []
    homes = tree.orientation_frame(start), tree.orientation_frame(end)
    return [dot(tree, vector(homes[0], axis), vector(homes[1], axis)) for axis in axes]


def motion_equations(names: Names, kinematics: Kinematics, role: JointRole) -> list[ConstraintEquation]:
    """Return the rows of motions that are constraints on coordinates of the tree."""
    rows = []
    motions = {
        name: motion for name, motion in role.joint.motions.items() if name in role.unknown_coordinates
    }
    for k, (coordinate, motion) in enumerate(motions.items(), start=1):
        value = names.value(coordinate) - names.expression(motion, f"joint {role.joint.name}")
        name = f"lambda_{role.joint.name}_motion" + (f"_{k}" if len(motions) > 1 else "")
        row = scalar_equation(kinematics, name, role.joint.name, value)
        rows.append(replace(row, coordinate=coordinate))
    return rows


@dataclass(frozen=True, slots=True)
class _LoopClosure:
    """A cut joint in its kinematics."""

    kinematics: Kinematics
    joint: Joint

    def translation_equation(self, direction: Triple, shift: Vector) -> ConstraintEquation:
        """Return ``direction . (r_end - r_start - shift) = 0``; both in the frame the joint shifts in."""
        kinematics, tree = self.kinematics, self.kinematics.tree
        start, end = self.joint.start.full_name, self.joint.end.full_name
        carrier = end if self.joint.shift_in == "end" else start
        n = vector(tree.orientation_frame(carrier), direction)
        v_start, v_end = kinematics.velocities[start], kinematics.velocities[end]
        w = kinematics.angular_velocities[carrier]
        arm = kinematics.position(start, end)
        lever = cross(tree, arm, n)
        along = dot(tree, n, shift)
        slide = kinematics.rate(along)
        slopes = kinematics.speed_partials(slide)
        seen = v_end.value - v_start.value - cross(tree, w.value, arm)
        turning = cross(tree, w.value, cross(tree, w.value, arm) + seen * 2)
        change = dot(tree, n, v_end.bias - v_start.bias - turning) - dot(tree, w.bias, lever)
        return ConstraintEquation(
            name="",
            element=self.joint.name,
            value=dot(tree, n, arm - shift),
            jacobian=_nonzero(
                {
                    u: dot(tree, n, v_end.partial(u) - v_start.partial(u)) - dot(tree, w.partial(u), lever)
                    - slopes.get(u, Expr(tree.graph, 0))
                    for u in kinematics.speeds
                }
            ),
            drift=dot(tree, n, v_end.drift - v_start.drift) - dot(tree, w.drift, lever)
            - kinematics.at_zero_speeds(slide),
            gamma=kinematics.bias(slide) - change,
            force=n,
            # A force across a direction that turns with the end acts through the start's origin.
            moment=ZERO if carrier == start else -lever,
        )  # fmt: skip

    def twist_equation(self, first: Triple, second: Triple) -> ConstraintEquation:
        """Return ``x_start . y_end = y_start . x_end`` for two axes x, y: no turn about the bisector of z."""
        start = self.joint.start.full_name
        a, b = self.rotation_equation(start, first, second), self.rotation_equation(start, second, first)
        zero = Expr(self.kinematics.graph, 0)
        slopes = {u: a.jacobian.get(u, zero) - b.jacobian.get(u, zero) for u in {**a.jacobian, **b.jacobian}}
        return replace(
            a,
            value=a.value - b.value,
            jacobian=_nonzero(slopes),
            drift=a.drift - b.drift,
            gamma=a.gamma - b.gamma,
            moment=a.moment - b.moment,
        )

    def rotation_equation(self, frame: str, a: Triple, b: Triple) -> ConstraintEquation:
        """Return ``a . b = 0`` for an axis of `frame` and an axis of the end frame."""
        kinematics, tree = self.kinematics, self.kinematics.tree
        end = self.joint.end.full_name
        first, second = vector(tree.orientation_frame(frame), a), vector(tree.orientation_frame(end), b)
        near, far = kinematics.angular_velocities[frame], kinematics.angular_velocities[end]
        normal = cross(tree, second, first)
        w = far.value - near.value
        bias = far.bias - near.bias - cross(tree, near.value, w)
        swing = cross(tree, w, cross(tree, w, second))
        return ConstraintEquation(
            name="",
            element=self.joint.name,
            value=dot(tree, first, second),
            jacobian=_nonzero(
                {u: dot(tree, normal, far.partial(u) - near.partial(u)) for u in kinematics.speeds}
            ),
            drift=dot(tree, normal, far.drift - near.drift),
            gamma=-dot(tree, normal, bias) - dot(tree, first, swing),
            moment=normal,
        )


def _axis_pairs(names: Names, role: JointRole) -> tuple[list[_Pair], list[_Pair]]:
    """Return what stays perpendicular: for the rotations that a joint locks, and for its known angles.

    Each pair is an axis of a frame and an axis of the end frame. A known angle is compared by the sine
    of a difference, so that it may count turns.
    """
    joint = role.joint
    graph = names.graph
    start, guess = joint.start.full_name, predicted_frame(joint.name)
    x, y, z = unit_axes(graph)
    turns = axis_rotations(names, joint.turns(), f"joint {joint.name}")
    if role.has_angles and len(turns) != 1:
        return [], [(guess, x, y), (guess, y, z), (guess, z, x)]
    if joint.quaternion is not None or len(turns) == 3:  # free to turn, or but for the twist
        return [], []
    if not turns:
        return [(start, x, y), (start, y, z), (start, z, x)], []
    if len(turns) == 2:
        return [(start, turns[0].axis, turns[1].axis)], []
    axis = turns[0].axis
    first, second = perpendiculars(graph, axis)
    return [(start, first, axis), (start, second, axis)], [(guess, second, first)] if role.has_angles else []


def _shaft(names: Names, role: JointRole) -> list[tuple[Triple, Triple]]:
    """Return the axes across the shafts of a joint without twist whose angles are not known, else nothing."""
    if role.has_angles or not role.joint.is_untwisted:
        return []
    axis = axis_rotations(names, role.joint.turns(), f"joint {role.joint.name}")[0].axis
    return [perpendiculars(names.graph, axis)]


def _nonzero(slopes: Mapping[int, Expr]) -> dict[int, Expr]:
    return {u: slope for u, slope in slopes.items() if not slope.is_zero}
