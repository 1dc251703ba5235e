"""`Velocity`: a velocity or an angular velocity by its coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from symbody.vectors.vector import NULL, Vector


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity or angular velocity, affine in the speeds.

    Attributes
    ----------
    partials : mapping of node to Vector
        The coefficient of each speed that has one.
    rest : Vector
        What explicit time contributes.
    value : Vector
        The whole.
    bias : Vector
        Its time derivative as seen from ground with all u' = 0.
    """

    partials: Mapping[int, Vector]
    rest: Vector
    value: Vector
    bias: Vector

    def combined(self, other: Velocity, sign: int = 1) -> Velocity:
        """Return this velocity plus, or minus, another."""
        partials = dict(self.partials)
        for u, partial in other.partials.items():
            partials[u] = partials.get(u, NULL) + partial * sign
        return Velocity(
            partials,
            self.rest + other.rest * sign,
            self.value + other.value * sign,
            self.bias + other.bias * sign,
        )

    def partial(self, u: int) -> Vector:
        """Return the coefficient of a speed."""
        return self.partials.get(u, NULL)


AT_REST: Final = Velocity({}, NULL, NULL, NULL)
