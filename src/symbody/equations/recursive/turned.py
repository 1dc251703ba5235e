"""Turning vectors and tensors from one link's axes to the next, one simple turn after another.

A turn about a coordinate axis costs 6 operations for a vector and 16 for a symmetric tensor; a full matrix
15 and about 50.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from symbody.expr.expression import Expr
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, product, transpose


class AxisTurn(NamedTuple):
    """A turn about coordinate axis 0, 1 or 2, by its cosine and sine."""

    axis: int
    c: Expr
    s: Expr

    @property
    def matrix(self) -> Matrix:
        """The rotation matrix, turned components to components before."""
        zero, one = self.c * 0, self.c * 0 + 1
        units = ((one, zero, zero), (zero, one, zero), (zero, zero, one))
        return transpose((turned(self, units[0]), turned(self, units[1]), turned(self, units[2])))


Step = AxisTurn | Matrix
Steps = tuple[Step, ...]


class Symmetric(NamedTuple):
    """A symmetric 3 x 3 tensor."""

    xx: Expr
    yy: Expr
    zz: Expr
    xy: Expr
    xz: Expr
    yz: Expr

    def entry(self, i: int, j: int) -> Expr:
        """Return one entry."""
        return self[i] if i == j else self[2 + i + j]

    @property
    def matrix(self) -> Matrix:
        """All nine entries."""
        return (
            (self.xx, self.xy, self.xz),
            (self.xy, self.yy, self.yz),
            (self.xz, self.yz, self.zz),
        )

    def plus(self, other: Symmetric) -> Symmetric:
        """Return the sum."""
        return Symmetric(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, factor: Expr | int) -> Symmetric:
        """Return the multiple."""
        return Symmetric(*(a * factor for a in self))

    def apply(self, v: Triple) -> Triple:
        """Return the product with a vector."""
        return apply_matrix(self.matrix, v)


def symmetric(m: Matrix) -> Symmetric:
    """Return the tensor of a symmetric matrix."""
    return Symmetric(m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])


def dyad(a: Triple, b: Triple) -> Symmetric:
    """Return ``a b^T + b a^T``."""
    x, y, z = a
    p, q, r = b
    return Symmetric(2 * (x * p), 2 * (y * q), 2 * (z * r), x * q + y * p, x * r + z * p, y * r + z * q)


def square(a: Triple) -> Symmetric:
    """Return ``a a^T``."""
    x, y, z = a
    return Symmetric(x * x, y * y, z * z, x * y, x * z, y * z)


def to_parent(steps: Steps, v: Triple) -> Triple:
    """Return a vector in the parent's axes."""
    for step in reversed(steps):
        v = turned(step, v) if isinstance(step, AxisTurn) else apply_matrix(step, v)
    return v


def to_child(steps: Steps, v: Triple) -> Triple:
    """Return a vector in the child's axes."""
    for step in steps:
        if isinstance(step, AxisTurn):
            v = turned(AxisTurn(step.axis, step.c, -step.s), v)
        else:
            v = apply_matrix(transpose(step), v)
    return v


def tensor_to_parent(steps: Steps, tensor: Symmetric) -> Symmetric:
    """Return a symmetric tensor in the parent's axes."""
    for step in reversed(steps):
        tensor = turned_tensor(step, tensor) if isinstance(step, AxisTurn) else _conjugate(step, tensor)
    return tensor


def matrix_to_parent(steps: Steps, matrix: Matrix) -> Matrix:
    """Return any tensor in the parent's axes."""
    for step in reversed(steps):
        if isinstance(step, AxisTurn):
            matrix = _turned_matrix(step, matrix)
        else:
            matrix = product(product(step, matrix), transpose(step))
    return matrix


def turned(turn: AxisTurn, v: Sequence[Expr]) -> Triple:
    """Return the vector turned about an axis."""
    k, c, s = turn
    i, j = (k + 1) % 3, (k + 2) % 3
    found = [v[0], v[1], v[2]]
    found[i], found[j] = c * v[i] - s * v[j], s * v[i] + c * v[j]
    return (found[0], found[1], found[2])


def turned_tensor(turn: AxisTurn, tensor: Symmetric) -> Symmetric:
    """Return the symmetric tensor turned about an axis.

    With ``g = s (K_ii - K_jj) + 2 c K_ij`` the entries across the axis are ``K_ii - s g``, ``K_jj + s g`` and
    ``c g - K_ij``: the double-angle form without the double angle, 10 operations.
    """
    k, c, s = turn
    i, j = (k + 1) % 3, (k + 2) % 3
    found = [list(row) for row in tensor.matrix]
    ii, jj, ij = found[i][i], found[j][j], found[i][j]
    g = s * (ii - jj) + c * (2 * ij)
    found[i][i], found[j][j], mixed = ii - s * g, jj + s * g, c * g - ij
    beside = turned(turn, found[k])
    pairs = {(i, j): mixed, (i, k): beside[i], (j, k): beside[j]}
    off = {tuple(sorted(pair)): value for pair, value in pairs.items()}
    return Symmetric(found[0][0], found[1][1], found[2][2], off[0, 1], off[0, 2], off[1, 2])


def _turned_matrix(turn: AxisTurn, matrix: Matrix) -> Matrix:
    k, c, s = turn
    i, j = (k + 1) % 3, (k + 2) % 3
    found = [list(row) for row in matrix]
    ii, jj, ij, ji = found[i][i], found[j][j], found[i][j], found[j][i]
    g = s * (ii - jj) + c * (ij + ji)
    row = turned(turn, matrix[k])
    column = turned(turn, (matrix[0][k], matrix[1][k], matrix[2][k]))
    found[i][i], found[j][j], found[i][j], found[j][i] = ii - s * g, jj + s * g, c * g - ji, c * g - ij
    for p in (i, j):
        found[k][p], found[p][k] = row[p], column[p]
    (a, b, d) = (tuple(line) for line in found)
    return ((a[0], a[1], a[2]), (b[0], b[1], b[2]), (d[0], d[1], d[2]))


def _conjugate(matrix: Matrix, tensor: Symmetric) -> Symmetric:
    """Return ``R K R^T``, of which one half is formed."""
    left = product(matrix, tensor.matrix)
    rows = transpose(matrix)

    def entry(i: int, j: int) -> Expr:
        return left[i][0] * rows[0][j] + left[i][1] * rows[1][j] + left[i][2] * rows[2][j]

    return Symmetric(entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))
