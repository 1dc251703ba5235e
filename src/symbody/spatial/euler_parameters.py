"""Euler parameters (unit quaternions), scalar first, taking end components to start components.

Nikravesh, Computer-Aided Analysis of Mechanical Systems (1988), chapter 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.spatial.matrix import Matrix3, Triple, Vector3, matrix3

Four = tuple[Expr, Expr, Expr, Expr]
Side = Literal["start", "end"]


@dataclass(frozen=True, slots=True)
class EulerParameters:
    """A rotation by four parameters of unit norm.

    Attributes
    ----------
    e0, e1, e2, e3 : Expr
        ``cos(phi/2)`` and ``sin(phi/2)`` times the axis; the opposite four are the same rotation.
    """

    e0: Expr
    e1: Expr
    e2: Expr
    e3: Expr

    @property
    def vector(self) -> Vector3[Expr]:
        """The vector part, e1 to e3."""
        return Vector3((self.e1, self.e2, self.e3))

    @property
    def inverse(self) -> EulerParameters:
        """The conjugate."""
        return EulerParameters(self.e0, -self.e1, -self.e2, -self.e3)

    @property
    def is_identity(self) -> bool:
        """True if the vector part is exactly 0."""
        return self.e1.is_zero and self.e2.is_zero and self.e3.is_zero

    def undoes(self, other: EulerParameters) -> bool:
        """Return True if this is the conjugate of `other`, or its opposite."""
        back = other.inverse
        return self == back or self == EulerParameters(-back.e0, -back.e1, -back.e2, -back.e3)

    def matrix(self, graph: Graph) -> Matrix3[Expr]:
        """Return ``R`` with quadratic entries: off the unit sphere the norm squared times a rotation."""
        e0, e1, e2, e3 = self.e0, self.e1, self.e2, self.e3
        s0, s1, s2, s3 = e0 * e0, e1 * e1, e2 * e2, e3 * e3
        return matrix3(
            (s0 + s1 - s2 - s3, 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)),
            (2 * (e1 * e2 + e0 * e3), s0 - s1 + s2 - s3, 2 * (e2 * e3 - e0 * e1)),
            (2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), s0 - s1 - s2 + s3),
        )


def euler_parameter_rates(parameters: EulerParameters, omega: Triple, resolved_in: Side = "end") -> Four:
    """Return q' from the angular velocity of end relative to start.

    In end axes ``q' = q (0, omega) / 2``, in start axes ``q' = (0, omega) q / 2``.
    """
    e0, e, w = parameters.e0, parameters.vector, Vector3(omega)
    x, y, z = w * e0 + (w.cross(e) if resolved_in == "start" else e.cross(w))
    return (-e.dot(w) / 2, x / 2, y / 2, z / 2)


def euler_parameter_omega(
    parameters: EulerParameters, rates: Four, resolved_in: Side = "end"
) -> Vector3[Expr]:
    """Return the angular velocity from q': the vector part of ``2 q* q'`` (end) or ``2 q' q*`` (start).

    Off the unit sphere, too, this is the one linear in q' with these coefficients.
    """
    e0, e = parameters.e0, parameters.vector
    r0, r = rates[0], Vector3(rates[1:])
    across = e.cross(r)
    return (r * e0 - e * r0 + (-across if resolved_in == "end" else across)) * 2
