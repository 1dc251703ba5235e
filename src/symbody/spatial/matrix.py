"""Three components, 3 x 3 matrices and symmetric tensors, over any numbers.

Entries are expressions, fractions or floats: whatever adds and multiplies. A `Vector3` is a tuple, so three
numbers in a plain tuple may stand wherever one is read.
"""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar, overload

from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph

# Three components and three rows as callers give them.
Triple = tuple[Expr, Expr, Expr]
Matrix = tuple[Triple, Triple, Triple]


class Scalar(Protocol):
    """A number to calculate with: `Expr`, `Fraction`, `float`."""

    def __add__(self, other: Any, /) -> Self:
        """Return the sum."""

    def __sub__(self, other: Any, /) -> Self:
        """Return the difference."""

    def __mul__(self, other: Any, /) -> Self:
        """Return the product."""

    def __truediv__(self, other: Any, /) -> Self:
        """Return the quotient."""

    def __neg__(self) -> Self:
        """Return the opposite."""


S = TypeVar("S", bound=Scalar)


class Vector3(tuple[S, S, S]):
    """Three components in one frame, with ``+``, ``-``, ``* scalar``, `dot` and `cross`."""

    __slots__ = ()

    def __add__(self, other: tuple[Any, ...]) -> Vector3[S]:
        return Vector3((self[0] + other[0], self[1] + other[1], self[2] + other[2]))

    def __sub__(self, other: tuple[Any, ...]) -> Vector3[S]:
        return Vector3((self[0] - other[0], self[1] - other[1], self[2] - other[2]))

    def __neg__(self) -> Vector3[S]:
        return Vector3((-self[0], -self[1], -self[2]))

    def __mul__(self, factor: Any) -> Vector3[S]:
        return Vector3((self[0] * factor, self[1] * factor, self[2] * factor))

    def dot(self, other: tuple[S, S, S]) -> S:
        """Return ``a . b``."""
        total: S = self[0] * other[0] + self[1] * other[1] + self[2] * other[2]
        return total

    def cross(self, other: tuple[S, S, S]) -> Vector3[S]:
        """Return ``a x b``."""
        x, y, z = self
        p, q, r = other
        return Vector3((y * r - z * q, z * p - x * r, x * q - y * p))


class Matrix3(tuple[Vector3[S], Vector3[S], Vector3[S]]):
    """Three rows, with ``+``, ``-`` and ``@`` (a vector or a matrix)."""

    __slots__ = ()

    def __add__(self, other: tuple[Any, ...]) -> Matrix3[S]:
        return Matrix3((self[0] + other[0], self[1] + other[1], self[2] + other[2]))

    def __sub__(self, other: tuple[Any, ...]) -> Matrix3[S]:
        return Matrix3((self[0] - other[0], self[1] - other[1], self[2] - other[2]))

    @overload
    def __matmul__(self, other: Matrix3[S]) -> Matrix3[S]: ...

    @overload
    def __matmul__(self, other: tuple[S, S, S]) -> Vector3[S]: ...

    def __matmul__(self, other: Matrix3[S] | tuple[S, S, S]) -> Matrix3[S] | Vector3[S]:
        if isinstance(other, Matrix3):
            columns = other.T
            return Matrix3((columns @ self[0], columns @ self[1], columns @ self[2]))
        return Vector3((self[0].dot(other), self[1].dot(other), self[2].dot(other)))

    @property
    def T(self) -> Matrix3[S]:
        """Rows and columns exchanged."""
        a, b, c = self
        return Matrix3(
            (Vector3((a[0], b[0], c[0])), Vector3((a[1], b[1], c[1])), Vector3((a[2], b[2], c[2])))
        )


class SymmetricTensor(NamedTuple, Generic[S]):
    """A symmetric 3 x 3 tensor, with ``+``, ``-``, ``* scalar`` and ``@`` vector."""

    xx: S
    yy: S
    zz: S
    xy: S
    xz: S
    yz: S

    def entry(self, i: int, j: int) -> S:
        """Return one entry."""
        return self[i] if i == j else self[2 + i + j]

    @property
    def matrix(self) -> Matrix3[S]:
        """All nine entries."""
        return matrix3((self.xx, self.xy, self.xz), (self.xy, self.yy, self.yz), (self.xz, self.yz, self.zz))

    def __add__(self, other: tuple[Any, ...]) -> SymmetricTensor[S]:
        return SymmetricTensor(*(a + b for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: tuple[Any, ...]) -> SymmetricTensor[S]:
        return SymmetricTensor(*(a - b for a, b in zip(self, other, strict=True)))

    def __mul__(self, factor: Any) -> SymmetricTensor[S]:
        return SymmetricTensor(*(a * factor for a in self))

    def __matmul__(self, v: tuple[S, S, S]) -> Vector3[S]:
        return self.matrix @ v


def matrix3(a: tuple[S, S, S], b: tuple[S, S, S], c: tuple[S, S, S]) -> Matrix3[S]:
    """Return the matrix of three rows."""
    return Matrix3((Vector3(a), Vector3(b), Vector3(c)))


def identity(graph: Graph) -> Matrix3[Expr]:
    """Return the unit matrix."""
    zero, one = number(graph, 0), number(graph, 1)
    return matrix3((one, zero, zero), (zero, one, zero), (zero, zero, one))


def zero_vector(graph: Graph) -> Vector3[Expr]:
    """Return three zeros."""
    zero = number(graph, 0)
    return Vector3((zero, zero, zero))


def skew(v: tuple[S, S, S]) -> Matrix3[S]:
    """Return ``v~``, whose product with a vector is ``v x``."""
    x, y, z = v
    zero = x * 0
    return matrix3((zero, -z, y), (z, zero, -x), (-y, x, zero))


def symmetric_tensor(m: tuple[tuple[S, S, S], tuple[S, S, S], tuple[S, S, S]]) -> SymmetricTensor[S]:
    """Return the tensor of a symmetric matrix; entries on and above the diagonal are read."""
    return SymmetricTensor(m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])


def dyad(a: tuple[S, S, S], b: tuple[S, S, S]) -> SymmetricTensor[S]:
    """Return ``a b^T + b a^T``."""
    x, y, z = a
    p, q, r = b
    return SymmetricTensor(x * p * 2, y * q * 2, z * r * 2, x * q + y * p, x * r + z * p, y * r + z * q)


def square(a: tuple[S, S, S]) -> SymmetricTensor[S]:
    """Return ``a a^T``."""
    x, y, z = a
    return SymmetricTensor(x * x, y * y, z * z, x * y, x * z, y * z)


def transpose(a: Matrix) -> Matrix3[Expr]:
    """Return the transposed matrix."""
    return matrix3(*a).T


def vanishes(a: Triple) -> bool:
    """Return True if all components are the exact constant 0."""
    return a[0].is_zero and a[1].is_zero and a[2].is_zero
