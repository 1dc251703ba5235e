"""`Velocity`: a velocity or an angular velocity by its coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from symbody.spatial.vector import ZERO, Vector


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity or angular velocity, affine in the speeds; with ``+`` and ``-``.

    Attributes
    ----------
    partials : mapping of node to Vector
        The coefficient of each speed that has one.
    drift : Vector
        The part that explicit time contributes.
    value : Vector
        The whole.
    bias : Vector
        Its time derivative as seen from ground with all u' = 0: the part of an acceleration without them.
    """

    partials: Mapping[int, Vector]
    drift: Vector
    value: Vector
    bias: Vector

    def __add__(self, other: Velocity) -> Velocity:
        partials = dict(self.partials)
        for u, partial in other.partials.items():
            partials[u] = partials.get(u, ZERO) + partial
        return Velocity(partials, self.drift + other.drift, self.value + other.value, self.bias + other.bias)

    def __neg__(self) -> Velocity:
        partials = {u: -partial for u, partial in self.partials.items()}
        return Velocity(partials, -self.drift, -self.value, -self.bias)

    def __sub__(self, other: Velocity) -> Velocity:
        return self + -other

    def partial(self, u: int) -> Vector:
        """Return the coefficient of a speed."""
        return self.partials.get(u, ZERO)


AT_REST: Final = Velocity({}, ZERO, ZERO, ZERO)
