"""Composite bodies that move, and the forces that the motion of a joint below them costs.

All twists and wrenches are in the axes of one frame, about its origin. With the column ``S`` of a joint, its
rate ``S'``, its second rate ``S"``, and inertia I, matrix B and wrench f of all that a joint carries, for a
joint j at or outward of i::

    dD_i/dq_j = S_i . (2 B S'_j + I S"_j + S_j x* f)     dD_j/dq_i = 2 B^T S_j . S'_i + I S_j . S"_i
    dD_i/du_j = S_i . (2 B S_j + 2 I S'_j)               dD_j/du_i = 2 B^T S_j . S_i + 2 I S_j . S'_i

The matrix B of Coriolis forces is ``sum of P^T P' dm``, with P from twists to velocities of points: its
moment is ``(tr G) w - G w`` and its force ``w x p``, with ``G = sum of V r^T dm`` and the momentum p.

Singh, Russell & Wensing, IEEE Robotics Autom. Lett. 7 (2022) 1776; Echeandia & Wensing, J. Comput. Nonlinear
Dyn. 16 (2021) 091004. Derived in docs/derivations/recursive.md.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from symbody.equations.recursive.links import LinkInertia, LinkTransform, LinkTwist, LinkWrench
from symbody.expr.expression import Expr
from symbody.spatial.matrix import Matrix3, Vector3, matrix3
from symbody.spatial.twist import Wrench


class CompositeBody(NamedTuple):
    """All links that a joint carries: their inertia, motion and wrench; with ``+``.

    Attributes
    ----------
    inertia : RigidInertia
        I.
    momentum : (3,) Expr
        ``p = sum of V dm``.
    velocity_moment : Matrix3
        ``G = sum of V r^T dm``.
    wrench : Wrench
        f, ``I a + B v``.
    """

    inertia: LinkInertia
    momentum: Vector3[Expr]
    velocity_moment: Matrix3[Expr]
    wrench: LinkWrench

    def __add__(self, other: tuple[Any, ...]) -> CompositeBody:
        return CompositeBody(*(mine + its for mine, its in zip(self, other, strict=True)))

    def coriolis(self, twist: LinkTwist) -> LinkWrench:
        """Return ``B m``."""
        return Wrench(twist.angular.cross(self.momentum), _trace_less(self.velocity_moment) @ twist.angular)

    def coriolis_transposed(self, twist: LinkTwist) -> Vector3[Expr]:
        """Return the moment of ``B^T m``, whose force is zero."""
        G = self.velocity_moment.T
        return _trace_less(G) @ twist.angular + self.momentum.cross(twist.linear)


def moving_body(
    inertia: LinkInertia, X: LinkTransform, velocity: LinkTwist, acceleration: LinkTwist
) -> CompositeBody:
    """Return one link as it moves; X leads from the common frame to the link."""
    v, w = velocity
    I = inertia.to_parent(X)
    momentum = v * I.mass + w.cross(I.first)
    x, y, z = (v * I.first[k] + w.cross(row) for k, row in enumerate(I.second.matrix))
    body = CompositeBody(I, momentum, matrix3(x, y, z).T, I @ acceleration)
    return body._replace(wrench=body.wrench + body.coriolis(velocity))


class JointColumn(NamedTuple):
    """A column S of the motion subspace with ``S' = v x S`` and ``S" = a x S + v x S'``."""

    S: LinkTwist
    rate: LinkTwist
    second: LinkTwist


class ColumnForces(NamedTuple):
    """The forces of a column on what it carries.

    Attributes
    ----------
    by_position, by_rate : Wrench
        Derivatives of the wrench f by the joint's coordinate and rate.
    inertia : Wrench
        ``I S``.
    coriolis : (3,) Expr
        The moment of ``2 B^T S``, whose force is zero.
    """

    by_position: LinkWrench
    by_rate: LinkWrench
    inertia: LinkWrench
    coriolis: Vector3[Expr]


def column_forces(body: CompositeBody, column: JointColumn) -> ColumnForces:
    """Return the forces of a column on the body it carries."""
    S, rate, second = column
    I = body.inertia
    return ColumnForces(
        by_position=body.coriolis(rate) * 2 + I @ second + S.cross_force(body.wrench),
        by_rate=(body.coriolis(S) + I @ rate) * 2,
        inertia=I @ S,
        coriolis=body.coriolis_transposed(S) * 2,
    )


def _trace_less(G: Matrix3[Expr]) -> Matrix3[Expr]:
    """Return ``(tr G) 1 - G``."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = G
    return matrix3((yy + zz, -xy, -xz), (-yx, xx + zz, -yz), (-zx, -zy, xx + yy))
