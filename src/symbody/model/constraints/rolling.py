"""Wheels, balls and blades: constraints on velocities that no constraint on positions replaces."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.constraint import FrameConstraint
from symbody.model.declarations.combinators import OptionalField, optional
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import AxisLike, Direction, Quantity
from symbody.model.numeric_checks import positive_length
from symbody.model.simple_rotation import Axis


@final
@element
class KnifeEdge(FrameConstraint):
    """A blade on end that does not slide sideways on start.

    The velocity of end's origin relative to start has no component along the blade's normal.

    Examples
    --------
    >>> import symbody as sb
    >>> skate = sb.KnifeEdge("skate", "ground", "Sled", axis="y")
    >>> skate.axis
    'y'
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "the velocity of the end origin relative to start has no component along the axis"
    multiplier: ClassVar[str] = "the force on end along the axis"
    multiplier_unit: ClassVar[str] = "N"

    axis: Direction = Direction("Normal of the blade, in the end frame.", default="y")


@final
@element
class Rolling(FrameConstraint):
    """A disc or a sphere on end that rolls without slipping on a plane of start.

    The origin of start is in the plane, that of end in the centre of disc or sphere. A disc that spins
    positively about its axle rolls forward; the forward direction of a sphere is fixed in start.
    Of its three rows the first holds the point of contact in the plane, the others hold the velocity there:
    forward, then sideways. The multipliers are the contact force on end along the normal, forward and to the
    left [N].

    Examples
    --------
    >>> import symbody as sb
    >>> wheel = sb.Rolling("contact", "ground", "Wheel", radius="R", axis="y")
    >>> ball = sb.Rolling("contact", "ground", "Ball", radius="R")
    >>> wheel.axis, ball.axis
    ('y', None)
    """

    rows: ClassVar[str] = "3"
    holds: ClassVar[str] = "height of the point of contact; its velocity forward and to the left"
    multiplier: ClassVar[str] = "the force on end along normal, forward, left"
    multiplier_unit: ClassVar[str] = "N"
    has_frame: ClassVar[bool] = True

    radius: Quantity = Quantity(
        "Radius of the disc or sphere.", unit="m", fits=positive_length("a point cannot roll")
    )
    normal: Direction = Direction("Normal of the plane, towards the wheel, in the start frame.", default="z")
    axis: OptionalField[AxisLike, Axis] = optional(
        Direction("Axle of a disc, in the end frame; leave it out for a sphere.")
    )
