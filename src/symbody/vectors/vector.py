"""Vectors as sums of terms, each with components in its own frame.

A term is moved to another frame only when a product needs it, and then by the relative rotation
along the tree. That is what keeps products of sines and cosines from ever being formed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from symbody.expr.expression import Expr
from symbody.vectors.frame import FrameTree
from symbody.vectors.rotation import Triple, apply_matrix


@dataclass(frozen=True, slots=True)
class Vector:
    """A sum of terms: components (x, y, z) in each of several frames; no terms is the zero vector."""

    terms: Mapping[str, Triple]

    def __add__(self, other: Vector) -> Vector:
        terms = dict(self.terms)
        for frame, b in other.terms.items():
            a = terms.get(frame)
            terms[frame] = b if a is None else (a[0] + b[0], a[1] + b[1], a[2] + b[2])
        return _without_zeros(terms)

    def __sub__(self, other: Vector) -> Vector:
        return self + -other

    def __neg__(self) -> Vector:
        return self.map(lambda x: -x)

    def __mul__(self, factor: Expr | int) -> Vector:
        return self.map(lambda x: x * factor)

    __rmul__ = __mul__

    def map(self, function: Callable[[Expr], Expr]) -> Vector:
        """Return the vector with `function` applied to every component."""
        return _without_zeros(
            {f: (function(c[0]), function(c[1]), function(c[2])) for f, c in self.terms.items()}
        )

    @property
    def is_zero(self) -> bool:
        """True if there is no term."""
        return not self.terms


NULL: Final = Vector({})


def vector(frame: str, components: Triple) -> Vector:
    """Return the vector with `components` in `frame`."""
    return _without_zeros({frame: components})


def express(tree: FrameTree, a: Vector, frame: str) -> Vector:
    """Return the vector with all its components in one frame."""
    result = NULL
    for home, components in a.terms.items():
        result = result + vector(frame, _moved(tree, components, home, frame))
    return result


def components(tree: FrameTree, a: Vector, frame: str) -> Triple:
    """Return the components of the vector in `frame`."""
    zero = Expr(tree.graph, 0)
    return express(tree, a, frame).terms.get(frame, (zero, zero, zero))


def dot(tree: FrameTree, a: Vector, b: Vector) -> Expr:
    """Return the scalar product."""
    total = Expr(tree.graph, 0)
    for home, x in a.terms.items():
        for other, y in b.terms.items():
            z = _moved(tree, y, other, home)
            total = total + (x[0] * z[0] + x[1] * z[1] + x[2] * z[2])
    return total


def cross(tree: FrameTree, a: Vector, b: Vector) -> Vector:
    """Return the vector product; each product of two terms stands in the frame farther from the root."""
    result = NULL
    for home, x in a.terms.items():
        for other, y in b.terms.items():
            frame = home if tree.depth(home) >= tree.depth(other) else other
            p, q = _moved(tree, x, home, frame), _moved(tree, y, other, frame)
            result = result + vector(
                frame, (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
            )
    return result


def _moved(tree: FrameTree, x: Triple, home: str, frame: str) -> Triple:
    return x if home == frame else apply_matrix(tree.matrix(frame, home), x)


def _without_zeros(terms: Mapping[str, Triple]) -> Vector:
    return Vector({frame: c for frame, c in terms.items() if not all(component.is_zero for component in c)})
