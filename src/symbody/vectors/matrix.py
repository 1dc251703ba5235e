"""Three components and 3 x 3 matrices of expressions, as plain tuples."""

from __future__ import annotations

from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph

Triple = tuple[Expr, Expr, Expr]
Matrix = tuple[Triple, Triple, Triple]


def identity(graph: Graph) -> Matrix:
    """Return the unit matrix."""
    zero, one = number(graph, 0), number(graph, 1)
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return ``a b``."""
    columns = transpose(b)
    return (apply_matrix(columns, a[0]), apply_matrix(columns, a[1]), apply_matrix(columns, a[2]))


def transpose(a: Matrix) -> Matrix:
    """Return the transposed matrix."""
    return (
        (a[0][0], a[1][0], a[2][0]),
        (a[0][1], a[1][1], a[2][1]),
        (a[0][2], a[1][2], a[2][2]),
    )


def apply_matrix(a: Matrix, x: Triple) -> Triple:
    """Return ``a x``."""
    return (inner(a[0], x), inner(a[1], x), inner(a[2], x))


def inner(a: Triple, b: Triple) -> Expr:
    """Return ``a . b`` of components in one frame."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def outer(a: Triple, b: Triple) -> Triple:
    """Return ``a x b`` of components in one frame."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def opposite(a: Triple) -> Triple:
    """Return ``-a``."""
    return (-a[0], -a[1], -a[2])


def vanishes(a: Triple) -> bool:
    """Return True if all components are the exact constant 0."""
    return a[0].is_zero and a[1].is_zero and a[2].is_zero
