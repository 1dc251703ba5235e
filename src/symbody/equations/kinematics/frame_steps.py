"""Steps from one frame to the next: what kinematics is formed from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.rotation import AxisRotation, DirectionCosines
from symbody.spatial.vector import Vector


@dataclass(frozen=True, slots=True)
class RotationStep:
    """How one frame is turned in another.

    Attributes
    ----------
    steps : tuple of AxisRotation, EulerParameters or DirectionCosines
        From the parent's axes to the child's; each leads to a frame of its own.
    angular_velocity : Vector or None
        Of the child relative to the parent, with components in the axes of either; None: that of the turns.
    """

    child: str
    parent: str
    steps: tuple[AxisRotation | EulerParameters | DirectionCosines, ...]
    angular_velocity: Vector | None = None

    @property
    def frames(self) -> Iterator[tuple[str, AxisRotation | EulerParameters | DirectionCosines]]:
        """The frame that each step leads to, with the step."""
        last = len(self.steps) - 1
        for k, step in enumerate(self.steps):
            yield self.child if k == last else f"{self.child}#{k + 1}", step


@dataclass(frozen=True, slots=True)
class TranslationStep:
    """Where one origin stands from another.

    Attributes
    ----------
    axes : str
        The frame in which terms far away are expressed.
    shift : Vector
        From the parent's origin to the child's.
    velocity : (frame, Vector) or None
        The rate of the shift as seen from a frame, in speeds; None: that of its components.
    """

    child: str
    parent: str
    axes: str
    shift: Vector
    velocity: tuple[str, Vector] | None = None
