"""Transforms between two frames, and rotations made of simple steps that are applied one after the other.

A turn about a coordinate axis costs 6 operations for a vector and 16 for a symmetric tensor; a full matrix
15 and about 50.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Generic, NamedTuple

from symbody.spatial.matrix import Matrix3, S, SymmetricTensor, Vector3, matrix3
from symbody.spatial.twist import Twist, Wrench


class CoordinateRotation(NamedTuple, Generic[S]):
    """A turn about coordinate axis 0, 1 or 2, by its cosine and sine (Featherstone 2008, table 2.2)."""

    axis: int
    c: S
    s: S

    @property
    def inverse(self) -> CoordinateRotation[S]:
        """The turn back."""
        return CoordinateRotation(self.axis, self.c, -self.s)

    @property
    def matrix(self) -> Matrix3[S]:
        """The rotation matrix: components after the turn to components before it."""
        zero: S = self.c * 0
        rows = [[zero] * 3 for _ in range(3)]
        (k, c, s), i, j = self, (self.axis + 1) % 3, (self.axis + 2) % 3
        rows[k][k], rows[i][i], rows[j][j], rows[i][j], rows[j][i] = zero + 1, c, c, -s, s
        a, b, d = ((row[0], row[1], row[2]) for row in rows)
        return matrix3(a, b, d)

    def rotate(self, v: Sequence[S]) -> Vector3[S]:
        """Return a vector's components before the turn from those after it."""
        k, c, s = self
        i, j = (k + 1) % 3, (k + 2) % 3
        parts = [v[0], v[1], v[2]]
        parts[i], parts[j] = v[i] * c - v[j] * s, v[i] * s + v[j] * c
        return Vector3((parts[0], parts[1], parts[2]))

    def rotate_tensor(self, tensor: SymmetricTensor[S]) -> SymmetricTensor[S]:
        """Return ``R K R^T``.

        With ``g = s (K_ii - K_jj) + 2 c K_ij`` the entries across the axis are ``K_ii - s g``, ``K_jj + s g``
        and ``c g - K_ij``: the double-angle form without the double angle, 10 operations.
        """
        k, c, s = self
        i, j = (k + 1) % 3, (k + 2) % 3
        ii, jj, ij = tensor[i], tensor[j], tensor.entry(i, j)
        g = (ii - jj) * s + ij * 2 * c
        diagonal = list(tensor[:3])
        diagonal[i], diagonal[j] = ii - g * s, jj + g * s
        beside = self.rotate(tensor.matrix[k])
        off = {i + j: g * c - ij, i + k: beside[i], j + k: beside[j]}
        return SymmetricTensor(diagonal[0], diagonal[1], diagonal[2], off[1], off[2], off[3])

    def rotate_matrix(self, matrix: Matrix3[S]) -> Matrix3[S]:
        """Return ``R A R^T``."""
        k, c, s = self
        i, j = (k + 1) % 3, (k + 2) % 3
        rows = [list(row) for row in matrix]
        ii, jj, ij, ji = rows[i][i], rows[j][j], rows[i][j], rows[j][i]
        g = (ii - jj) * s + (ij + ji) * c
        row, column = self.rotate(matrix[k]), self.rotate(matrix.T[k])
        rows[i][i], rows[j][j], rows[i][j], rows[j][i] = ii - g * s, jj + g * s, g * c - ji, g * c - ij
        for p in (i, j):
            rows[k][p], rows[p][k] = row[p], column[p]
        a, b, d = ((entry[0], entry[1], entry[2]) for entry in rows)
        return matrix3(a, b, d)


Step = CoordinateRotation[S] | Matrix3[S]


class Transform(NamedTuple, Generic[S]):
    """Where a frame, the child, stands in another, its parent.

    Attributes
    ----------
    steps : tuple of CoordinateRotation or Matrix3
        From the parent's axes to the child's.
    position : (3,)
        From the parent's origin to the child's, in the parent's axes [m].
    """

    steps: tuple[Step[S], ...]
    position: Vector3[S]

    @property
    def matrix(self) -> Matrix3[S]:
        """R: components in the child to components in the parent."""
        matrices = [step if isinstance(step, Matrix3) else step.matrix for step in self.steps]
        if not matrices:
            zero: S = self.position[0] * 0
            one: S = zero + 1
            return matrix3((one, zero, zero), (zero, one, zero), (zero, zero, one))
        return reduce(lambda a, b: a @ b, matrices)

    @property
    def inverse(self) -> Transform[S]:
        """The parent in the child."""
        back = Transform(
            tuple(step.T if isinstance(step, Matrix3) else step.inverse for step in reversed(self.steps)),
            self.position,
        )
        return back._replace(position=-back.to_parent(self.position))

    def then(self, other: Transform[S]) -> Transform[S]:
        """Return the frame that `other` is in this frame's child, in this frame's parent."""
        return Transform((self.matrix @ other.matrix,), self.point_to_parent(other.position))

    def to_parent(self, v: Vector3[S]) -> Vector3[S]:
        """Return ``R v``: a vector's components in the parent."""
        for step in reversed(self.steps):
            v = step @ v if isinstance(step, Matrix3) else step.rotate(v)
        return v

    def to_child(self, v: Vector3[S]) -> Vector3[S]:
        """Return ``R^T v``: a vector's components in the child."""
        for step in self.steps:
            v = step.T @ v if isinstance(step, Matrix3) else step.inverse.rotate(v)
        return v

    def point_to_parent(self, x: Vector3[S]) -> Vector3[S]:
        """Return ``r + R x``: a point's coordinates in the parent."""
        return self.position + self.to_parent(x)

    def twist_to_child(self, twist: Twist[S]) -> Twist[S]:
        """Return a twist of the parent's points about the child's origin, in the child's axes."""
        w, v = twist.angular, twist.linear
        return Twist(self.to_child(v + w.cross(self.position)), self.to_child(w))

    def wrench_to_parent(self, wrench: Wrench[Vector3[S]]) -> Wrench[Vector3[S]]:
        """Return a wrench about the parent's origin, in the parent's axes."""
        force = self.to_parent(wrench.force)
        return Wrench(force, self.to_parent(wrench.moment) + self.position.cross(force))

    def tensor_to_parent(self, tensor: SymmetricTensor[S]) -> SymmetricTensor[S]:
        """Return ``R K R^T``."""
        for step in reversed(self.steps):
            tensor = _conjugate(step, tensor) if isinstance(step, Matrix3) else step.rotate_tensor(tensor)
        return tensor

    def matrix_to_parent(self, matrix: Matrix3[S]) -> Matrix3[S]:
        """Return ``R A R^T``."""
        for step in reversed(self.steps):
            if isinstance(step, Matrix3):
                matrix = step @ matrix @ step.T
            else:
                matrix = step.rotate_matrix(matrix)
        return matrix


def _conjugate(R: Matrix3[S], tensor: SymmetricTensor[S]) -> SymmetricTensor[S]:
    """Return ``R K R^T``, of which one half is formed."""
    left = R @ tensor.matrix
    return SymmetricTensor(*(left[i].dot(R[j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))
