"""What acts on bodies: forces, moments, pulls between points, and efforts along joint coordinates."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.expression import Expr
from symbody.vectors.vector import NULL, Vector, cross


@dataclass(frozen=True, slots=True)
class PointForce:
    """A force on a body.

    Attributes
    ----------
    frame : str
        A frame of the body.
    arm : Vector
        From the frame's origin to the point the force acts in.
    """

    frame: str
    force: Vector
    arm: Vector = NULL


@dataclass(frozen=True, slots=True)
class Moment:
    """A torque on a body, by one of its frames."""

    frame: str
    torque: Vector


@dataclass(frozen=True, slots=True)
class Pull:
    """Opposite forces on two points along the line between them.

    Attributes
    ----------
    start, end : str
        Frames whose origins are the points.
    arm : Vector
        From start to end.
    factor : Expr
        The force on end is `factor` times `arm`.
    """

    start: str
    end: str
    arm: Vector
    factor: Expr


@dataclass(frozen=True, slots=True)
class Effort:
    """A force or torque along a scalar rate, that of a driven joint coordinate."""

    rate: Expr
    effort: Expr


Load = PointForce | Moment | Pull | Effort


def wrenches(kinematics: Kinematics, load: Load) -> list[tuple[str, Vector, Vector]]:
    """Return (frame, force, torque) for each body on which a load acts, the torque about the frame's origin.

    An effort has none: it is inside its joint.
    """
    if isinstance(load, Effort):
        return []
    if isinstance(load, Moment):
        return [(load.frame, NULL, load.torque)]
    if isinstance(load, Pull):
        force = load.arm * load.factor
        return [(load.end, force, NULL), (load.start, -force, NULL)]
    return [(load.frame, load.force, cross(kinematics.tree, load.arm, load.force))]
