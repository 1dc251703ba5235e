"""Loop closure: the constraint equations of a cut joint, each with the wrench it transmits.

A row of rotation says that an axis fixed in one frame stays perpendicular to an axis of the end frame; a
row of translation, that the end's origin does not move along a direction of the start frame, or of the end
frame where the joint shifts along its axes. Both are formed with vectors, so that velocity and acceleration
rows hold no derivatives of products of sines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from symbody.equations.kinematics.joint_axes import completed, free_directions, perpendiculars, unit_axes
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placing import joint_shift, predicted
from symbody.equations.kinematics.row import Row, scalar_row
from symbody.equations.kinematics.variables import Use, turns_of
from symbody.expr.expression import Expr
from symbody.model.joint import Joint
from symbody.vectors.matrix import Triple
from symbody.vectors.vector import NULL, Vector, cross, dot, vector

# An axis of a frame and an axis of the end frame.
_Pair = tuple[str, Triple, Triple]


def closing_rows(names: Names, kinematics: Kinematics, use: Use) -> list[Row]:
    """Return the rows of a joint that is not in both trees.

    They are counted as they come: locked translations, locked rotations, then the coordinates in use.
    """
    joint = use.joint
    closing = _Closing(kinematics, joint)
    locked: list[Row] = []
    measured: list[Row] = []
    if not use.in_translation:
        free = free_directions(names, joint)
        shift = joint_shift(names, joint)
        tied = shift if joint.coupled_coordinates else NULL
        locked += [closing.translation(direction, tied) for direction in completed(names.graph, free)]
        if use.slides:
            measured += [closing.translation(direction, shift) for direction in free]
    if not use.in_rotation:
        pairs, extra = _axis_pairs(names, use)
        locked += [closing.rotation(*pair) for pair in pairs]
        locked += [closing.twist(*axes) for axes in _shaft(names, use)]
        measured += [closing.rotation(*pair) for pair in extra]
    rows = enumerate([*locked, *measured], start=1)
    return [replace(row, name=f"lambda_{joint.name}_{k}") for k, row in rows]


def alignments(names: Names, kinematics: Kinematics, use: Use) -> list[Expr]:
    """Return the cosines between axes that coincide where a cut joint is closed.

    Its rows are products of perpendicular axes and hold for opposite ones too.
    """
    joint, tree = use.joint, kinematics.tree
    if use.in_rotation:
        return []
    start, end = joint.start.frame, joint.end.frame
    turns = turns_of(names, joint.turns(), f"joint {joint.name}")
    axes = list(unit_axes(names.graph))
    if use.turns and joint.quaternion is None:
        start = predicted(joint.name)
    elif len(turns) == 1:
        axes = [turns[0].axis]
    elif joint.is_untwisted:
        first, second = perpendiculars(names.graph, turns[0].axis)
        homes = tree.home(start), tree.home(end)
        pairs = [(vector(homes[0], axis), vector(homes[1], axis)) for axis in (first, second)]
        return [dot(tree, *pairs[0]) + dot(tree, *pairs[1])]
    elif turns or joint.quaternion is not None:
        return []
    homes = tree.home(start), tree.home(end)
    return [dot(tree, vector(homes[0], axis), vector(homes[1], axis)) for axis in axes]


def motion_rows(names: Names, kinematics: Kinematics, use: Use) -> list[Row]:
    """Return the rows of motions that are constraints on coordinates of the tree."""
    rows = []
    motions = {name: motion for name, motion in use.joint.motions.items() if name in use.unknown}
    for k, (coordinate, motion) in enumerate(motions.items(), start=1):
        value = names.value(coordinate) - names.expression(motion, f"joint {use.joint.name}")
        name = f"lambda_{use.joint.name}_motion" + (f"_{k}" if len(motions) > 1 else "")
        row = scalar_row(kinematics, name, use.joint.name, value)
        rows.append(replace(row, coordinate=coordinate))
    return rows


@dataclass(frozen=True, slots=True)
class _Closing:
    """A cut joint in its kinematics."""

    kinematics: Kinematics
    joint: Joint

    def translation(self, direction: Triple, shift: Vector) -> Row:
        """Return ``direction . (r_end - r_start - shift) = 0``; both in the frame the joint shifts in."""
        kinematics, tree = self.kinematics, self.kinematics.tree
        start, end = self.joint.start.frame, self.joint.end.frame
        carrier = end if self.joint.shift_in == "end" else start
        n = vector(tree.home(carrier), direction)
        v_start, v_end = kinematics.velocities[start], kinematics.velocities[end]
        w = kinematics.angular_velocities[carrier]
        arm = kinematics.arm(start, end)
        lever = cross(tree, arm, n)
        along = dot(tree, n, shift)
        slide = kinematics.rate(along)
        slopes = kinematics.slopes(slide)
        seen = v_end.value - v_start.value - cross(tree, w.value, arm)
        turning = cross(tree, w.value, cross(tree, w.value, arm) + seen * 2)
        change = dot(tree, n, v_end.bias - v_start.bias - turning) - dot(tree, w.bias, lever)
        return Row(
            name="",
            element=self.joint.name,
            value=dot(tree, n, arm - shift),
            slopes=_nonzero(
                {
                    u: dot(tree, n, v_end.partial(u) - v_start.partial(u)) - dot(tree, w.partial(u), lever)
                    - slopes.get(u, Expr(tree.graph, 0))
                    for u in kinematics.speeds
                }
            ),
            rest=dot(tree, n, v_end.rest - v_start.rest) - dot(tree, w.rest, lever)
            - kinematics.without_speeds(slide),
            gamma=kinematics.bias(slide) - change,
            force=n,
            # A force across a direction that turns with the end acts through the start's origin.
            moment=NULL if carrier == start else -lever,
        )  # fmt: skip

    def twist(self, first: Triple, second: Triple) -> Row:
        """Return ``x_start . y_end = y_start . x_end`` for two axes x, y: no turn about the bisector of z."""
        start = self.joint.start.frame
        a, b = self.rotation(start, first, second), self.rotation(start, second, first)
        zero = Expr(self.kinematics.graph, 0)
        slopes = {u: a.slopes.get(u, zero) - b.slopes.get(u, zero) for u in {**a.slopes, **b.slopes}}
        return replace(
            a,
            value=a.value - b.value,
            slopes=_nonzero(slopes),
            rest=a.rest - b.rest,
            gamma=a.gamma - b.gamma,
            moment=a.moment - b.moment,
        )

    def rotation(self, frame: str, a: Triple, b: Triple) -> Row:
        """Return ``a . b = 0`` for an axis of `frame` and an axis of the end frame."""
        kinematics, tree = self.kinematics, self.kinematics.tree
        end = self.joint.end.frame
        first, second = vector(tree.home(frame), a), vector(tree.home(end), b)
        near, far = kinematics.angular_velocities[frame], kinematics.angular_velocities[end]
        normal = cross(tree, second, first)
        w = far.value - near.value
        bias = far.bias - near.bias - cross(tree, near.value, w)
        swing = cross(tree, w, cross(tree, w, second))
        return Row(
            name="",
            element=self.joint.name,
            value=dot(tree, first, second),
            slopes=_nonzero(
                {u: dot(tree, normal, far.partial(u) - near.partial(u)) for u in kinematics.speeds}
            ),
            rest=dot(tree, normal, far.rest - near.rest),
            gamma=-dot(tree, normal, bias) - dot(tree, first, swing),
            moment=normal,
        )


def _axis_pairs(names: Names, use: Use) -> tuple[list[_Pair], list[_Pair]]:
    """Return what stays perpendicular: for the rotations that a joint locks, and for its known angles.

    Each pair is an axis of a frame and an axis of the end frame. A known angle is compared by the sine
    of a difference, so that it may count turns.
    """
    joint = use.joint
    graph = names.graph
    start, guess = joint.start.frame, predicted(joint.name)
    x, y, z = unit_axes(graph)
    turns = turns_of(names, joint.turns(), f"joint {joint.name}")
    if use.turns and len(turns) != 1:
        return [], [(guess, x, y), (guess, y, z), (guess, z, x)]
    if joint.quaternion is not None or len(turns) == 3:  # free to turn, or but for the twist
        return [], []
    if not turns:
        return [(start, x, y), (start, y, z), (start, z, x)], []
    if len(turns) == 2:
        return [(start, turns[0].axis, turns[1].axis)], []
    axis = turns[0].axis
    first, second = perpendiculars(graph, axis)
    return [(start, first, axis), (start, second, axis)], [(guess, second, first)] if use.turns else []


def _shaft(names: Names, use: Use) -> list[tuple[Triple, Triple]]:
    """Return the axes across the shafts of a joint without twist whose angles are not known, else nothing."""
    if use.turns or not use.joint.is_untwisted:
        return []
    axis = turns_of(names, use.joint.turns(), f"joint {use.joint.name}")[0].axis
    return [perpendiculars(names.graph, axis)]


def _nonzero(slopes: Mapping[int, Expr]) -> dict[int, Expr]:
    return {u: slope for u, slope in slopes.items() if not slope.is_zero}
