"""The recursive Newton-Euler algorithm: motion outward from ground, wrenches inward from the leaves.

Featherstone (2008), section 5.3 and table 5.1; Luh, Walker & Paul (1980) in the form of Khalil & Kleinfinger
(1987): with ``U = alpha~ + w~ w~`` the points of a link have the acceleration ``a + U r``, so that no linear
velocity is formed. Gravity is an acceleration of ground.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from symbody.equations.recursive.links import GROUND, KinematicTree, LinkWrench
from symbody.expr.expression import Expr
from symbody.spatial.inertia import acceleration_tensor
from symbody.spatial.matrix import Matrix3, Vector3, matrix3


class LinkMotion(NamedTuple):
    """Motion of a link in its own axes.

    Attributes
    ----------
    w, alpha : (3,) Expr
        Angular velocity and acceleration.
    U : (3, 3) Expr
        ``alpha~ + w~ w~``.
    a : (3,) Expr
        Acceleration of the origin less that of gravity.
    """

    w: Vector3[Expr]
    alpha: Vector3[Expr]
    U: Matrix3[Expr]
    a: Vector3[Expr]


def link_motions(
    tree: KinematicTree, gravity: Vector3[Expr], accelerations: Mapping[int, Expr] | None = None
) -> list[LinkMotion]:
    """Return the motion of all links: ``v_i = v_p + S u``, ``a_i = a_p + S u' + S' u`` (table 5.1, outward).

    Parameters
    ----------
    gravity : (3,) Expr
        In ground axes.
    accelerations : mapping of node to Expr, optional
        u' by the node of u; by default all are 0.
    """
    zero = gravity * 0
    ground = LinkMotion(zero, zero, matrix3(zero, zero, zero), -gravity)
    motions: list[LinkMotion] = []
    for link in tree.links:
        parent = ground if link.parent == GROUND else motions[link.parent]
        X, joint = link.transform, link.motion
        relative = joint.bias
        if accelerations is not None:
            for column in joint.columns:
                relative = relative + column.twist * accelerations[column.speed]
        w = X.to_child(parent.w)
        alpha = X.to_child(parent.alpha) + w.cross(joint.velocity.angular) + relative.angular
        a = X.to_child(parent.a + parent.U @ X.position)
        a = a + (w * 2).cross(joint.velocity.linear) + relative.linear
        w = w + joint.velocity.angular
        motions.append(LinkMotion(w, alpha, acceleration_tensor(w, alpha), a))
    return motions


def inertial_wrenches(tree: KinematicTree, motions: Sequence[LinkMotion]) -> list[LinkWrench]:
    """Return ``I a + v x* I v`` of each link."""
    return [link.inertia.bias_wrench(m.U, m.a) for link, m in zip(tree.links, motions, strict=True)]


def generalized_forces(tree: KinematicTree, wrenches: Sequence[LinkWrench]) -> dict[int, Expr]:
    """Return ``S^T f`` by the node of each speed, f summed over all that a joint carries (table 5.1).

    Coupled joints add to the speed they share.
    """
    total: list[LinkWrench] = list(wrenches)
    forces: dict[int, Expr] = {}
    for k, link in reversed(list(enumerate(tree.links))):
        for column in link.motion.columns:
            force = column.twist.dot(total[k])
            forces[column.speed] = forces[column.speed] + force if column.speed in forces else force
        if link.parent != GROUND:
            total[link.parent] = total[link.parent] + link.transform.wrench_to_parent(total[k])
    return forces
