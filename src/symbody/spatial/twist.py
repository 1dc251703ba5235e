"""Twists and wrenches: the spatial vectors of Featherstone (2008), chapter 2.

Both are written with the velocity of the point that passes through the origin, and the moment about it. The
linear part stands first, as everywhere (docs/notation.md).
"""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar

from symbody.spatial.matrix import S, Vector3


class VectorLike(Protocol):
    """A vector of any kind: components in one frame, or a sum of terms in several."""

    def __add__(self, other: Any, /) -> Self:
        """Return the sum."""

    def __sub__(self, other: Any, /) -> Self:
        """Return the difference."""

    def __mul__(self, factor: Any, /) -> Self:
        """Return the multiple."""

    def __neg__(self) -> Self:
        """Return the opposite."""


V = TypeVar("V", bound=VectorLike)


class Wrench(NamedTuple, Generic[V]):
    """A force in a point and a moment about it, with ``+``, ``-`` and ``* scalar``."""

    force: V
    moment: V

    def __add__(self, other: tuple[Any, ...]) -> Wrench[V]:
        return Wrench(self.force + other[0], self.moment + other[1])

    def __sub__(self, other: tuple[Any, ...]) -> Wrench[V]:
        return Wrench(self.force - other[0], self.moment - other[1])

    def __mul__(self, factor: Any) -> Wrench[V]:
        return Wrench(self.force * factor, self.moment * factor)

    def __neg__(self) -> Wrench[V]:
        return Wrench(-self.force, -self.moment)


class Twist(NamedTuple, Generic[S]):
    """A velocity and an angular velocity, or their rates, with ``+``, ``-`` and ``* scalar``."""

    linear: Vector3[S]
    angular: Vector3[S]

    def __add__(self, other: tuple[Any, ...]) -> Twist[S]:
        return Twist(self.linear + other[0], self.angular + other[1])

    def __sub__(self, other: tuple[Any, ...]) -> Twist[S]:
        return Twist(self.linear - other[0], self.angular - other[1])

    def __mul__(self, factor: Any) -> Twist[S]:
        return Twist(self.linear * factor, self.angular * factor)

    def dot(self, wrench: Wrench[Vector3[S]]) -> S:
        """Return the power of a wrench on this twist."""
        power: S = self.angular.dot(wrench.moment) + self.linear.dot(wrench.force)
        return power

    def cross(self, other: Twist[S]) -> Twist[S]:
        """Return the rate of a twist fixed in what moves so: ``v x m`` (Featherstone, section 2.9)."""
        w, v = self.angular, self.linear
        return Twist(w.cross(other.linear) + v.cross(other.angular), w.cross(other.angular))

    def cross_force(self, wrench: Wrench[Vector3[S]]) -> Wrench[Vector3[S]]:
        """Return the rate of a wrench fixed in what moves so: ``v x* f`` (Featherstone, section 2.9)."""
        w, v = self.angular, self.linear
        return Wrench(w.cross(wrench.force), w.cross(wrench.moment) + v.cross(wrench.force))
