"""Directions across the normal of a contact in which anything can slip."""

from __future__ import annotations

from collections.abc import Iterator

from symbody.equations.contacts.contact_geometry import ContactGeometry
from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.spatial.vector import Vector, dot


def slip_directions(
    kinematics: Kinematics, geometry: ContactGeometry, slip: Vector
) -> Iterator[tuple[str, Vector, Expr]]:
    """Yield the directions across the normal in which anything moves, with the slip along them."""
    for letter, axis in zip("xy", geometry.axes(kinematics), strict=False):
        rate = dot(kinematics.tree, axis, slip)
        parts = [slope.index for slope in kinematics.speed_partials(rate).values()]
        parts.append(kinematics.at_zero_speeds(rate).index)
        if not all(find_zeros(kinematics.graph, parts)):
            yield letter, axis, rate
