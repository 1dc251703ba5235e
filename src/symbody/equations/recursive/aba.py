"""The articulated-body algorithm: accelerations, linear in the number of links.

Featherstone (2008), section 7.3 and table 7.1, for the equations ``M u' = F`` in which F holds all that
u' = 0 leaves, so that the bodies start from rest and no bias accelerations occur. A joint with several
freedoms is a chain of such with one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.recursive.links import (
    GROUND,
    KinematicTree,
    LinkTwist,
    LinkWrench,
    MotionSubspaceColumn,
)
from symbody.expr.expression import Expr
from symbody.spatial.inertia import single_body
from symbody.spatial.matrix import zero_vector
from symbody.spatial.twist import Twist, Wrench


@dataclass(frozen=True, slots=True)
class JointInertia:
    """The inertia against one free motion: its column S, ``U = I S``, ``D = S . U`` and its inverse."""

    column: MotionSubspaceColumn
    U: LinkWrench
    D: Expr
    inverse: Expr


def articulated_inertias(tree: KinematicTree, rotors: Mapping[int, Expr]) -> list[list[JointInertia]]:
    """Return ``U = I S`` and ``D = S . U`` of all free motions, and on the way ``I_p += I - U D^-1 U^T``.

    Table 7.1, inward.

    Parameters
    ----------
    rotors : mapping of speed to Expr
        Inertia that moves with a speed alone.
    """
    inertias = [single_body(link.inertia) for link in tree.links]
    joints: list[list[JointInertia]] = [[] for _ in tree.links]
    for k, link in reversed(list(enumerate(tree.links))):
        body = inertias[k]
        for column in reversed(link.motion.columns):
            rotor = rotors.get(column.speed)
            U = body @ column.twist
            D = column.twist.dot(U) if rotor is None else column.twist.dot(U) + rotor
            joint = JointInertia(column, U, D, D + 1 if D.is_zero else 1 / D)
            joints[k].insert(0, joint)
            body = body.project_out(U, joint.inverse, _direction(column) if rotor is None else -1)
        if link.parent != GROUND:
            inertias[link.parent] = inertias[link.parent] + body.to_parent(link.transform)
    return joints


def accelerations(
    tree: KinematicTree, joints: Sequence[Sequence[JointInertia]], forces: Mapping[int, Expr]
) -> dict[int, Expr]:
    """Return u' with ``M u' = forces``, by the node of u: ``u' = D^-1 (F - S . p) - D^-1 U . a`` (table 7.1).

    Inward the bias wrenches ``p_p += p + U D^-1 (F - S . p)``, outward the accelerations a.
    """
    if not tree.links:
        return {}
    zero = zero_vector(tree.links[0].inertia.mass.graph)
    bias: list[LinkWrench] = [Wrench(zero, zero) for _ in tree.links]
    inward: dict[int, Expr] = {}
    for k, link in reversed(list(enumerate(tree.links))):
        p = bias[k]
        for joint in reversed(joints[k]):
            speed = joint.column.speed
            inward[speed] = (forces[speed] - joint.column.twist.dot(p)) * joint.inverse
            p = p + joint.U * inward[speed]
        if link.parent != GROUND:
            bias[link.parent] = bias[link.parent] + link.transform.wrench_to_parent(p)
    twists: list[LinkTwist] = []
    udot: dict[int, Expr] = {}
    for k, link in enumerate(tree.links):
        a = Twist(zero, zero)
        if link.parent != GROUND:
            a = link.transform.twist_to_child(twists[link.parent])
        for joint in joints[k]:
            speed = joint.column.speed
            udot[speed] = inward[speed] - a.dot(joint.U) * joint.inverse
            a = a + joint.column.twist * udot[speed]
        twists.append(a)
    return udot


def _direction(column: MotionSubspaceColumn) -> int:
    """Return which of the six directions a free motion is, rotations first, or -1 if it is none."""
    entries = (*column.twist.angular, *column.twist.linear)
    nonzero = [k for k, entry in enumerate(entries) if not entry.is_zero]
    return nonzero[0] if len(nonzero) == 1 and entries[nonzero[0]].number in (1, -1) else -1
