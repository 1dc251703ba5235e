"""Euler parameters (unit quaternions), scalar first, taking end components to start components.

Nikravesh, Computer-Aided Analysis of Mechanical Systems (1988), chapter 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.vectors.matrix import Matrix, Triple

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

    def matrix(self, graph: Graph) -> Matrix:
        """Return ``R`` with quadratic entries: off the unit sphere the norm squared times a rotation."""
        e0, e1, e2, e3 = self.e0, self.e1, self.e2, self.e3
        s0, s1, s2, s3 = e0 * e0, e1 * e1, e2 * e2, e3 * e3
        return (
            (s0 + s1 - s2 - s3, 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)),
            (2 * (e1 * e2 + e0 * e3), s0 - s1 + s2 - s3, 2 * (e2 * e3 - e0 * e1)),
            (2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), s0 - s1 - s2 + s3),
        )


def euler_parameter_rates(parameters: EulerParameters, omega: Triple, resolved_in: Side = "end") -> Four:
    """Return q' from the angular velocity of end relative to start.

    In end axes ``q' = q (0, omega) / 2``, in start axes ``q' = (0, omega) q / 2``.
    """
    e0, e1, e2, e3 = parameters.e0, parameters.e1, parameters.e2, parameters.e3
    x, y, z = omega
    if resolved_in == "start":  # the factors change places: their vector product changes its sign
        x_part, y_part, z_part = y * e3 - z * e2, z * e1 - x * e3, x * e2 - y * e1
    else:
        x_part, y_part, z_part = e2 * z - e3 * y, e3 * x - e1 * z, e1 * y - e2 * x
    return (
        -(e1 * x + e2 * y + e3 * z) / 2,
        (e0 * x + x_part) / 2,
        (e0 * y + y_part) / 2,
        (e0 * z + z_part) / 2,
    )


def euler_parameter_omega(parameters: EulerParameters, rates: Four, resolved_in: Side = "end") -> Triple:
    """Return the angular velocity from q': the vector part of ``2 q* q'`` (end) or ``2 q' q*`` (start).

    Off the unit sphere, too, this is the one linear in q' with these coefficients.
    """
    e0, e1, e2, e3 = parameters.e0, parameters.e1, parameters.e2, parameters.e3
    r0, r1, r2, r3 = rates
    x, y, z = e2 * r3 - e3 * r2, e3 * r1 - e1 * r3, e1 * r2 - e2 * r1
    if resolved_in == "end":
        x, y, z = -x, -y, -z
    return (
        2 * (e0 * r1 - e1 * r0 + x),
        2 * (e0 * r2 - e2 * r0 + y),
        2 * (e0 * r3 - e3 * r0 + z),
    )
