"""`PseudoInertia`: mass, first moment and second moment of a mass distribution about one point.

The second moment ``K = sum of r r^T dm`` takes the place of the tensor ``I = tr(K) 1 - K``: it adds up and
shifts like a distribution of points, so that what of a link may be reckoned to its parent is read off it.
"""

from __future__ import annotations

from typing import NamedTuple

from symbody.equations.recursive.turned import (
    Steps,
    Symmetric,
    dyad,
    square,
    tensor_to_parent,
    to_parent,
)
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.vectors.matrix import Triple, outer


class PseudoInertia(NamedTuple):
    """A mass distribution, seen from the origin of some axes.

    Attributes
    ----------
    second : Symmetric
        ``K``, sum of ``r r^T dm`` [kg m^2].
    first : (3,) Expr
        ``h``, sum of ``r dm`` [kg m].
    mass : Expr
        [kg].
    """

    second: Symmetric
    first: Triple
    mass: Expr

    def plus(self, other: PseudoInertia) -> PseudoInertia:
        """Return both distributions together."""
        return PseudoInertia(
            self.second.plus(other.second), added(self.first, other.first), self.mass + other.mass
        )

    def moved(self, steps: Steps, r: Triple) -> PseudoInertia:
        """Return the same distribution in the axes before `steps`, about the point that r leads from."""
        h = to_parent(steps, self.first)
        m = self.mass
        second = tensor_to_parent(steps, self.second).plus(dyad(h, r)).plus(square(r).times(m))
        return PseudoInertia(second, added(h, scaled(r, m)), m)

    def wrench(self, alpha: Triple, a: Triple) -> tuple[Triple, Triple]:
        """Return force and moment about the origin for accelerations from rest."""
        h, k = self.first, self.second
        force = added(scaled(a, self.mass), outer(alpha, h))
        return force, added(_inertia(k, alpha), outer(h, a))

    def bias_wrench(self, u: Triple3, a: Triple) -> tuple[Triple, Triple]:
        """Return force and moment for the acceleration ``a + U r`` of the points, ``U = alpha~ + w~ w~``.

        The moment is that of the skew part of ``U K`` (Khalil & Kleinfinger 1987 with I in place of K).
        """
        h, k = self.first, self.second
        force = added(scaled(a, self.mass), tuple_of(u, h))
        moment = tuple(_twist(u, k, *pair) for pair in ((1, 2), (2, 0), (0, 1)))
        return force, added((moment[0], moment[1], moment[2]), outer(h, a))

    def split(self, turning: str, sliding: bool) -> tuple[PseudoInertia, PseudoInertia]:
        """Return what stays with a link, and what its parent can as well carry: base parameters.

        What lies on the axis of a hinge z is at rest in both bodies; so is the center of a spherical joint. A
        link that only slides turns with its parent. [Gautier & Khalil 1990]

        Parameters
        ----------
        turning : str
            "none", "z" or "any": about what the link turns relative to its parent.
        sliding : bool
            Whether its origin moves relative to the parent.
        """
        zero = self.mass * 0
        none, still = Symmetric(*[zero] * 6), (zero, zero, zero)
        k, h, m = self
        if turning == "none":
            second, kept = k, none
        elif turning == "z":
            second = Symmetric(zero, zero, k.zz, zero, zero, zero)
            kept = k._replace(zz=zero)
        else:
            second, kept = none, k
        if sliding:
            return PseudoInertia(kept, h, m), PseudoInertia(second, still, zero)
        if turning == "none":
            return PseudoInertia(none, still, zero), self
        along = (zero, zero, h[2] if turning == "z" else zero)
        rest = (h[0], h[1], zero if turning == "z" else h[2])
        return PseudoInertia(kept, rest, zero), PseudoInertia(second, along, m)


Triple3 = tuple[Triple, Triple, Triple]


def empty(graph: Graph) -> PseudoInertia:
    """Return no mass at all."""
    zero = number(graph, 0)
    return PseudoInertia(Symmetric(*[zero] * 6), (zero, zero, zero), zero)


def of_body(tensor: Symmetric, mass: Expr) -> PseudoInertia:
    """Return the distribution of a body about its center of mass, from its inertia tensor."""
    xx, yy, zz, xy, xz, yz = tensor
    half = (xx + yy + zz) / 2
    zero = mass * 0
    return PseudoInertia(Symmetric(half - xx, half - yy, half - zz, -xy, -xz, -yz), (zero, zero, zero), mass)


def swirl(w: Triple, alpha: Triple) -> Triple3:
    """Return ``alpha~ + w~ w~``, whose product with an arm is the acceleration that turning gives its end."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return (
        (-(yy + zz), xy - alpha[2], xz + alpha[1]),
        (xy + alpha[2], -(xx + zz), yz - alpha[0]),
        (xz - alpha[1], yz + alpha[0], -(xx + yy)),
    )


def added(a: Triple, b: Triple) -> Triple:
    """Return the sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scaled(a: Triple, factor: Expr | int) -> Triple:
    """Return the multiple of a vector."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def tuple_of(u: Triple3, r: Triple) -> Triple:
    """Return ``U r``."""
    x, y, z = (row[0] * r[0] + row[1] * r[1] + row[2] * r[2] for row in u)
    return (x, y, z)


def _inertia(k: Symmetric, alpha: Triple) -> Triple:
    """Return ``(tr K) alpha - K alpha``."""
    moments = Symmetric(k.yy + k.zz, k.xx + k.zz, k.xx + k.yy, -k.xy, -k.xz, -k.yz)
    return moments.apply(alpha)


def _twist(u: Triple3, k: Symmetric, i: int, j: int) -> Expr:
    """Return ``(U K)_ji - (U K)_ij``, with i, j the axes across the component."""
    n = 3 - i - j
    across = u[j][n] * k.entry(n, i) - u[i][n] * k.entry(n, j)
    return u[j][i] * k[i] - u[i][j] * k[j] + (u[j][j] - u[i][i]) * k.entry(i, j) + across
