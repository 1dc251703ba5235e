"""Rigid-body and articulated-body inertias (Featherstone 2008, sections 2.13 and 7.1)."""

from __future__ import annotations

from typing import Any, Generic, NamedTuple

from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.spatial.matrix import (
    Matrix3,
    S,
    SymmetricTensor,
    Vector3,
    dyad,
    skew,
    square,
    symmetric_tensor,
    zero_vector,
)
from symbody.spatial.transform import Transform
from symbody.spatial.twist import Twist, Wrench


class RigidInertia(NamedTuple, Generic[S]):
    """A mass distribution about the origin of some axes, with ``+`` and ``@`` twist.

    The second moment ``K = sum of r r^T dm`` takes the place of the tensor ``I = tr(K) 1 - K``: it adds up
    and shifts like a distribution of points, which shows what of a link its parent can carry as well.

    Attributes
    ----------
    second : SymmetricTensor
        ``K``, sum of ``r r^T dm`` [kg m^2].
    first : (3,)
        ``h``, sum of ``r dm`` [kg m].
    mass : scalar
        [kg].
    """

    second: SymmetricTensor[S]
    first: Vector3[S]
    mass: S

    def __add__(self, other: tuple[Any, ...]) -> RigidInertia[S]:
        return RigidInertia(self.second + other[0], self.first + other[1], self.mass + other[2])

    def __matmul__(self, acceleration: Twist[S]) -> Wrench[Vector3[S]]:
        """Return the wrench about the origin for accelerations from rest."""
        a, alpha = acceleration
        return Wrench(a * self.mass + alpha.cross(self.first), self.rotational @ alpha + self.first.cross(a))

    @property
    def rotational(self) -> SymmetricTensor[S]:
        """The tensor of inertia, ``tr(K) 1 - K``."""
        k = self.second
        return SymmetricTensor(k.yy + k.zz, k.xx + k.zz, k.xx + k.yy, -k.xy, -k.xz, -k.yz)

    def to_parent(self, X: Transform[S]) -> RigidInertia[S]:
        """Return the same distribution about the parent's origin, in its axes."""
        h, r, m = X.to_parent(self.first), X.position, self.mass
        second = X.tensor_to_parent(self.second) + dyad(h, r) + square(r) * m
        return RigidInertia(second, h + r * m, m)

    def bias_wrench(self, U: Matrix3[S], a: Vector3[S]) -> Wrench[Vector3[S]]:
        """Return the wrench for the acceleration ``a + U r`` of the points, ``U = alpha~ + w~ w~``.

        The moment is that of the skew part of ``U K`` (Khalil & Kleinfinger 1987 with I in place of K).
        """
        h, k = self.first, self.second
        moment = Vector3((_twice_skew(U, k, 1, 2), _twice_skew(U, k, 2, 0), _twice_skew(U, k, 0, 1)))
        return Wrench(a * self.mass + U @ h, moment + h.cross(a))


class ArticulatedInertia(NamedTuple, Generic[S]):
    """``moment = I alpha + H a``, ``force = H^T alpha + M a`` about an origin (Featherstone, section 7.1).

    Attributes
    ----------
    rotational, linear : SymmetricTensor
        I and M.
    coupling : Matrix3
        H.
    """

    rotational: SymmetricTensor[S]
    coupling: Matrix3[S]
    linear: SymmetricTensor[S]

    def __add__(self, other: tuple[Any, ...]) -> ArticulatedInertia[S]:
        return ArticulatedInertia(
            self.rotational + other[0], self.coupling + other[1], self.linear + other[2]
        )

    def __matmul__(self, acceleration: Twist[S]) -> Wrench[Vector3[S]]:
        """Return the wrench about the origin for accelerations from rest."""
        a, alpha = acceleration
        force = self.coupling.T @ alpha + self.linear @ a
        return Wrench(force, self.rotational @ alpha + self.coupling @ a)

    def to_parent(self, X: Transform[S]) -> ArticulatedInertia[S]:
        """Return the same inertia about the parent's origin, in its axes."""
        r = skew(X.position)
        linear = X.tensor_to_parent(self.linear)
        coupling = X.matrix_to_parent(self.coupling)
        before = coupling @ r
        coupling = coupling + r @ linear.matrix
        lever = symmetric_tensor(r @ coupling.T)
        rotational = X.tensor_to_parent(self.rotational) + lever - symmetric_tensor(before)
        return ArticulatedInertia(rotational, coupling, linear)

    def project_out(self, unit: Wrench[Vector3[S]], inverse: S, direction: int = -1) -> ArticulatedInertia[S]:
        """Return ``I - U D^-1 U^T``, the inertia that is felt through a free motion.

        Parameters
        ----------
        unit : Wrench
            U, what a unit acceleration along the motion needs.
        inverse : scalar
            ``D^-1``.
        direction : int
            Which row vanishes: along a motion that is one coordinate direction nothing is felt, which is set,
            not computed. Rows 0 to 2 are rotations, 3 to 5 displacements; -1: none.
        """
        force, moment = unit
        x, y = moment * inverse, force * inverse

        def reduce(i: int, j: int, entry: S, share: S) -> S:
            return entry * 0 if direction in (i, j) else entry - share

        pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        I, H, M = self
        rotational = SymmetricTensor(*(reduce(i, j, I.entry(i, j), x[i] * moment[j]) for i, j in pairs))
        linear = SymmetricTensor(*(reduce(3 + i, 3 + j, M.entry(i, j), y[i] * force[j]) for i, j in pairs))
        rows = [[reduce(i, 3 + j, H[i][j], x[i] * force[j]) for j in range(3)] for i in range(3)]
        a, b, c = (Vector3((row[0], row[1], row[2])) for row in rows)
        return ArticulatedInertia(rotational, Matrix3((a, b, c)), linear)


def single_body(body: RigidInertia[S]) -> ArticulatedInertia[S]:
    """Return the inertia of a rigid body alone."""
    m = body.mass
    zero: S = m * 0
    return ArticulatedInertia(body.rotational, skew(body.first), SymmetricTensor(m, m, m, zero, zero, zero))


def massless(graph: Graph) -> RigidInertia[Expr]:
    """Return the inertia of nothing."""
    zero = number(graph, 0)
    return RigidInertia(SymmetricTensor(*[zero] * 6), zero_vector(graph), zero)


def central_inertia(tensor: SymmetricTensor[S], mass: S) -> RigidInertia[S]:
    """Return the distribution of a body about its center of mass, from its tensor of inertia."""
    xx, yy, zz, xy, xz, yz = tensor
    half: S = (xx + yy + zz) / 2
    zero: S = mass * 0
    second = SymmetricTensor(half - xx, half - yy, half - zz, -xy, -xz, -yz)
    return RigidInertia(second, Vector3((zero, zero, zero)), mass)


def acceleration_tensor(w: Vector3[S], alpha: Vector3[S]) -> Matrix3[S]:
    """Return ``alpha~ + w~ w~``, whose product with an arm is the acceleration that turning gives its end."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return Matrix3(
        (
            Vector3((-(yy + zz), xy - alpha[2], xz + alpha[1])),
            Vector3((xy + alpha[2], -(xx + zz), yz - alpha[0])),
            Vector3((xz - alpha[1], yz + alpha[0], -(xx + yy))),
        )
    )


def _twice_skew(U: Matrix3[S], k: SymmetricTensor[S], i: int, j: int) -> S:
    """Return ``(U K)_ji - (U K)_ij``, with i, j the axes across the component."""
    n = 3 - i - j
    across = U[j][n] * k.entry(n, i) - U[i][n] * k.entry(n, j)
    result: S = U[j][i] * k[i] - U[i][j] * k[j] + (U[j][j] - U[i][i]) * k.entry(i, j) + across
    return result
