"""Symmetric tensors fixed in a frame, split by their symmetry, which saves operations.

A body with two equal principal moments has ``I = A 1 + (C - A) n n^T``: its products with vectors
need one scalar product, and a turn about n leaves it as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symbody.expr.expression import Expr, number
from symbody.spatial.frame import FrameTree
from symbody.spatial.matrix import Matrix, SymmetricTensor, Triple, Vector3, identity, symmetric_tensor
from symbody.spatial.rotation import AxisRotation
from symbody.spatial.vector import ZERO, Vector, components, cross, dot, vector


@dataclass(frozen=True, slots=True)
class Dyadic:
    """``isotropic 1 + factor axis axis^T + unresolved``, of which unneeded parts are left out.

    Attributes
    ----------
    frame : str
        Frame of the components.
    isotropic : Expr
        Factor of the unit tensor.
    axial : (Expr, (3,) Expr) or None
        Factor, and unit vector of the symmetry.
    unresolved : SymmetricTensor or None
        The part without symmetry.
    """

    frame: str
    isotropic: Expr
    axial: tuple[Expr, Triple] | None = None
    unresolved: SymmetricTensor[Expr] | None = None

    def simplest_frame(self, tree: FrameTree) -> str:
        """Return the frame nearest the root in which the tensor has the same constant components.

        For an isotropic tensor it is the root. One with an axis is passed up across turns about this axis.
        """
        if self.unresolved is not None:
            return tree.orientation_frame(self.frame)
        if self.axial is None:
            return tree.path(self.frame)[-1]
        frame, axis = self.frame, self.axial[1]
        back = -Vector3(axis)
        while tree.depth(frame):
            parent, rotation = tree.parents[frame]
            for step in rotation.turns:
                if not (isinstance(step, AxisRotation) and step.axis in (axis, back)):
                    return frame
            frame = parent
        return frame

    def in_simplest_frame(self, tree: FrameTree) -> Dyadic:
        """Return the same tensor in the frame nearest the root in which its components are constant."""
        return replace(self, frame=self.simplest_frame(tree))


def symmetric_split(frame: str, tensor: Matrix) -> Dyadic:
    """Return a symmetric tensor (entries on and above the diagonal are read) split by its symmetry.

    Moments count as equal if they are one node, products as absent if they are the constant 0. A planar
    body, two of its moments 0, has an axis and no isotropic part.
    """
    graph = tensor[0][0].graph
    whole = symmetric_tensor(tensor)
    moments = whole[:3]
    if all(product.is_zero for product in whole[3:]):
        if moments[0] == moments[1] == moments[2]:
            return Dyadic(frame, moments[0])
        for k in range(3):
            across = moments[k - 2]
            if across == moments[k - 1]:
                return Dyadic(frame, across, (moments[k] - across, identity(graph)[k]))
    return Dyadic(frame, number(graph, 0), unresolved=whole)


def times_vector(tree: FrameTree, dyadic: Dyadic, a: Vector) -> Vector:
    """Return ``D a``; terms stay in their frames as far as the symmetry allows."""
    here = dyadic.in_simplest_frame(tree)
    result = a * here.isotropic
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        result = result + n * (factor * dot(tree, n, a))
    if here.unresolved is not None:
        result = result + vector(here.frame, here.unresolved @ components(tree, a, here.frame))
    return result


def quadratic(tree: FrameTree, a: Vector, dyadic: Dyadic, b: Vector) -> Expr:
    """Return ``a . D b`` as a sum of products of scalar products."""
    here = dyadic.in_simplest_frame(tree)
    total = number(tree.graph, 0)
    if not here.isotropic.is_zero:
        total = here.isotropic * dot(tree, a, b)
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        total = total + factor * (dot(tree, n, a) * dot(tree, n, b))
    if here.unresolved is not None:
        p, q = components(tree, a, here.frame), components(tree, b, here.frame)
        total = total + _bilinear(here.unresolved, p, q)
    return total


def gyroscopic(tree: FrameTree, w: Vector, dyadic: Dyadic) -> Vector:
    """Return ``w x D w``; the isotropic part, whose product is zero, is never formed."""
    here = dyadic.in_simplest_frame(tree)
    result = ZERO
    if here.axial is not None:
        factor, axis = here.axial
        n = vector(here.frame, axis)
        result = cross(tree, w, n) * (factor * dot(tree, n, w))
    if here.unresolved is not None:
        p = components(tree, w, here.frame)
        result = result + vector(here.frame, _gyroscopic(here.unresolved, p))
    return result


def _bilinear(tensor: SymmetricTensor[Expr], p: Triple, q: Triple) -> Expr:
    """Return ``p . M q``, symmetric in p and q: each product of inertia is multiplied once."""
    diagonal = [moment * (x * y) for moment, x, y in zip(tensor, p, q, strict=False)]
    total = diagonal[0] + diagonal[1] + diagonal[2]
    for i, j in ((0, 1), (0, 2), (1, 2)):
        total = total + tensor.entry(i, j) * (p[i] * q[j] + p[j] * q[i])
    return total


def _gyroscopic(tensor: SymmetricTensor[Expr], w: Vector3[Expr]) -> Vector3[Expr]:
    """Return ``w x M w``; without products of inertia in Euler's form ``(C - B) w_y w_z``."""
    if not all(product.is_zero for product in tensor[3:]):
        return w.cross(tensor @ w)
    a, b, c = tensor[:3]
    x, y, z = w
    return Vector3(((c - b) * (y * z), (a - c) * (z * x), (b - a) * (x * y)))
