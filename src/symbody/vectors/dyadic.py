"""Symmetric tensors fixed in a frame, kept so that their symmetry is used and not discovered again.

A body with two equal principal moments has ``I = A 1 + (C - A) n n^T``: its products with vectors
need one scalar product, and a turn about n leaves it as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.vectors.frame import FrameTree
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, opposite, outer, vanishes
from symbody.vectors.rotation import Turn
from symbody.vectors.vector import NULL, Vector, components, cross, dot, vector


@dataclass(frozen=True, slots=True)
class Dyadic:
    """``isotropic 1 + factor axis axis^T + rest``, of which unneeded parts are left out.

    Attributes
    ----------
    frame : str
        Frame of the components.
    isotropic : Expr
        Factor of the unit tensor.
    axial : (Expr, (3,) Expr) or None
        Factor, and unit vector of the symmetry.
    rest : (3, 3) Expr or None
        What has no symmetry.
    """

    frame: str
    isotropic: Expr
    axial: tuple[Expr, Triple] | None = None
    rest: Matrix | None = None

    def resting_frame(self, tree: FrameTree) -> str:
        """Return the frame nearest the root in which the tensor has the same constant components.

        An isotropic tensor rests in the root. One with an axis is passed up across turns about this axis.
        """
        if self.rest is not None:
            return tree.home(self.frame)
        if self.axial is None:
            return tree.path(self.frame)[-1]
        frame, axis = self.frame, self.axial[1]
        back = opposite(axis)
        while tree.depth(frame):
            parent, rotation = tree.parents[frame]
            for step in rotation.turns:
                if not (isinstance(step, Turn) and step.axis in (axis, back)):
                    return frame
            frame = parent
        return frame

    def at_rest(self, tree: FrameTree) -> Dyadic:
        """Return the same tensor in its resting frame."""
        return replace(self, frame=self.resting_frame(tree))


def symmetric_split(frame: str, tensor: Matrix) -> Dyadic:
    """Return a symmetric tensor (entries on and above the diagonal are read) split by its symmetry.

    Moments count as equal if they are one node, products as absent if they are the constant 0. A planar
    body, two of its moments 0, has an axis and no isotropic part.
    """
    graph = tensor[0][0].graph
    zero = number(graph, 0)
    moments = (tensor[0][0], tensor[1][1], tensor[2][2])
    products = (tensor[0][1], tensor[0][2], tensor[1][2])
    if not vanishes(products):
        xy, xz, yz = products
        full = ((moments[0], xy, xz), (xy, moments[1], yz), (xz, yz, moments[2]))
        return Dyadic(frame, zero, rest=full)
    if moments[0] == moments[1] == moments[2]:
        return Dyadic(frame, moments[0])
    for k in range(3):
        across = moments[k - 2]
        if across == moments[k - 1]:
            return Dyadic(frame, across, (moments[k] - across, _unit(graph, k)))
    diagonal = (
        (moments[0], zero, zero),
        (zero, moments[1], zero),
        (zero, zero, moments[2]),
    )
    return Dyadic(frame, zero, rest=diagonal)


def apply(tree: FrameTree, dyadic: Dyadic, a: Vector) -> Vector:
    """Return ``D a``; terms stay in their frames as far as the symmetry allows."""
    here = dyadic.at_rest(tree)
    result = a * here.isotropic
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        result = result + n * (factor * dot(tree, n, a))
    if here.rest is not None:
        result = result + vector(here.frame, apply_matrix(here.rest, components(tree, a, here.frame)))
    return result


def quadratic(tree: FrameTree, a: Vector, dyadic: Dyadic, b: Vector) -> Expr:
    """Return ``a . D b`` as a sum of products of scalar products."""
    here = dyadic.at_rest(tree)
    total = number(tree.graph, 0)
    if not here.isotropic.is_zero:
        total = here.isotropic * dot(tree, a, b)
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        total = total + factor * (dot(tree, n, a) * dot(tree, n, b))
    if here.rest is not None:
        p, q = components(tree, a, here.frame), components(tree, b, here.frame)
        total = total + _bilinear(here.rest, p, q)
    return total


def gyroscopic(tree: FrameTree, w: Vector, dyadic: Dyadic) -> Vector:
    """Return ``w x D w``; the isotropic part, whose product is zero, is never formed."""
    here = dyadic.at_rest(tree)
    result = NULL
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        result = cross(tree, w, n) * (factor * dot(tree, n, w))
    if here.rest is not None:
        p = components(tree, w, here.frame)
        result = result + vector(here.frame, _swirl(here.rest, p))
    return result


def _bilinear(matrix: Matrix, p: Triple, q: Triple) -> Expr:
    """Return ``p . M q``, symmetric in p and q: each product of inertia is multiplied once."""
    diagonal = (matrix[0][0] * (p[0] * q[0]), matrix[1][1] * (p[1] * q[1]), matrix[2][2] * (p[2] * q[2]))
    total = diagonal[0] + diagonal[1] + diagonal[2]
    for i, j in ((0, 1), (0, 2), (1, 2)):
        total = total + matrix[i][j] * (p[i] * q[j] + p[j] * q[i])
    return total


def _swirl(matrix: Matrix, p: Triple) -> Triple:
    """Return ``p x M p``; without products of inertia in Euler's form ``(C - B) p_y p_z``."""
    if vanishes((matrix[0][1], matrix[0][2], matrix[1][2])):
        a, b, c = matrix[0][0], matrix[1][1], matrix[2][2]
        return ((c - b) * (p[1] * p[2]), (a - c) * (p[2] * p[0]), (b - a) * (p[0] * p[1]))
    return outer(p, apply_matrix(matrix, p))


def _unit(graph: Graph, k: int) -> Triple:
    return (number(graph, int(k == 0)), number(graph, int(k == 1)), number(graph, int(k == 2)))
