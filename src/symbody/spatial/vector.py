"""Vectors as sums of terms, each with components in its own frame.

A term is moved to another frame only when a product needs it, and then by the relative rotation
along the tree. So products of sines and cosines are never formed.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Final

from symbody.expr.expression import Expr
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Triple, Vector3, vanishes
from symbody.spatial.rotation import AxisRotation

Rank = tuple[int, str]  # depth and name of a frame: an order that begins at the root


@dataclass(frozen=True, slots=True)
class Vector:
    """A sum of terms: components (x, y, z) in each of several frames; no terms is the zero vector."""

    terms: Mapping[str, Vector3[Expr]]

    def __add__(self, other: Vector) -> Vector:
        terms = dict(self.terms)
        for frame, b in other.terms.items():
            terms[frame] = terms[frame] + b if frame in terms else b
        return _nonzero(terms)

    def __sub__(self, other: Vector) -> Vector:
        return self + -other

    def __neg__(self) -> Vector:
        return Vector({frame: -parts for frame, parts in self.terms.items()})

    def __mul__(self, factor: Expr | int) -> Vector:
        return _nonzero({frame: parts * factor for frame, parts in self.terms.items()})

    __rmul__ = __mul__

    def map(self, function: Callable[[Expr], Expr]) -> Vector:
        """Return the vector with `function` applied to every component."""
        terms = {
            frame: Vector3((function(x), function(y), function(z))) for frame, (x, y, z) in self.terms.items()
        }
        return _nonzero(terms)

    @property
    def is_zero(self) -> bool:
        """True if there is no term."""
        return not self.terms


ZERO: Final = Vector({})


def vector(frame: str, components: Triple) -> Vector:
    """Return the vector with `components` in `frame`."""
    return _nonzero({frame: Vector3(components)})


def express(tree: FrameTree, a: Vector, frame: str) -> Vector:
    """Return the vector with all its components in one frame."""
    result = ZERO
    for home, parts in a.terms.items():
        result = result + vector(frame, _in_frame(tree, parts, home, frame))
    return result


def components(tree: FrameTree, a: Vector, frame: str) -> Vector3[Expr]:
    """Return the components of the vector in `frame`."""
    zero = Expr(tree.graph, 0)
    return express(tree, a, frame).terms.get(frame, Vector3((zero, zero, zero)))


def express_near(tree: FrameTree, a: Vector, frame: str) -> Vector:
    """Return the vector in `frame`, unless it is one term in a frame turned by several parallel turns.

    Products of sums cost as many rotations as there are pairs of terms, and products with a frame far
    away as many as there are turns between. Parallel turns are one turn by the sum of the angles, and a
    single term there is better left.
    """
    homes = list(a.terms)
    if len(homes) == 1 and tree.is_parallel(frame, homes[0]):
        return a
    return express(tree, a, frame)


def in_simplest_frame(tree: FrameTree, a: Vector, kept: Collection[str] = ()) -> Vector:
    """Return the vector with each term in a frame turned about its own direction expressed before that turn.

    Products with it then never hold the angle, which makes no difference to them. Nothing leaves the frames
    in `kept`.
    """
    result = ZERO
    for home, parts in a.terms.items():
        frame = tree.orientation_frame(home)
        while frame in tree.parents and frame not in kept:
            parent, rotation = tree.parents[frame]
            (step,) = rotation.turns if len(rotation.turns) == 1 else (None,)
            if not isinstance(step, AxisRotation) or not vanishes(Vector3(step.axis).cross(parts)):
                break
            frame = tree.orientation_frame(parent)
        result = result + Vector({frame: parts})
    return result


def dot(tree: FrameTree, a: Vector, b: Vector) -> Expr:
    """Return the scalar product; the order of the factors does not matter, not even for the nodes."""
    totals: dict[tuple[Rank, Rank], Expr] = {}
    for home, x in a.terms.items():
        for other, y in b.terms.items():
            first, second = (_rank(tree, home), x), (_rank(tree, other), y)
            if first[0] > second[0]:
                first, second = second, first
            pair = (first[0], second[0])
            term = _product_of_terms(tree, pair, first[1], second[1])
            totals[pair] = totals[pair] + term if pair in totals else term
    total = Expr(tree.graph, 0)
    for pair in sorted(totals):
        total = total + totals[pair]
    return total


def cross(tree: FrameTree, a: Vector, b: Vector) -> Vector:
    """Return the vector product; each product of two terms stands in the frame farther from the root."""
    result = ZERO
    for home, x in a.terms.items():
        for other, y in b.terms.items():
            frame = home if tree.depth(home) >= tree.depth(other) else other
            p, q = _in_frame(tree, x, home, frame), _in_frame(tree, y, other, frame)
            result = result + vector(frame, p.cross(q))
    return result


def _rank(tree: FrameTree, frame: str) -> Rank:
    return (tree.depth(frame), frame)


def _product_of_terms(tree: FrameTree, frames: tuple[Rank, Rank], x: Vector3[Expr], y: Vector3[Expr]) -> Expr:
    """Return ``x . R y`` with R from the frame nearer the root; rows that x does not need are not formed."""
    (_, home), (_, other) = frames
    if home == other:
        return x.dot(y)
    total = Expr(tree.graph, 0)
    for component, row in zip(x, tree.matrix(home, other), strict=True):
        if not component.is_zero:
            total = total + component * row.dot(y)
    return total


def _in_frame(tree: FrameTree, x: Vector3[Expr], home: str, frame: str) -> Vector3[Expr]:
    return x if home == frame else tree.matrix(frame, home) @ x


def _nonzero(terms: Mapping[str, Vector3[Expr]]) -> Vector:
    """Return the vector of the terms that are not the constant 0."""
    if not any(map(vanishes, terms.values())):
        return Vector(terms)
    return Vector({frame: parts for frame, parts in terms.items() if not vanishes(parts)})
