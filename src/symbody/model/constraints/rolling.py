"""Wheels, balls and blades: constraints on velocities that no constraint on positions replaces."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.constraint import Contact
from symbody.model.constraints.words import axis_or_none, take
from symbody.model.door import Value
from symbody.model.turn import Axis
from symbody.model.uses import Scope, Use


@final
@dataclass(frozen=True, slots=True, init=False)
class KnifeEdge(Contact):
    """A blade on end that does not slide sideways on start.

    The velocity of end's origin relative to start has no component along the blade's normal.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        What the blade cuts, and the frame of the blade.
    axis : str or (3,) number or formula
        Normal of the blade, fixed in end.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a direction.
    """

    multiplier_unit: ClassVar[str] = "N"

    axis: Axis

    def __init__(self, name: str, start: Place, end: Place, axis: str | Iterable[Value] = "y") -> None:
        take(self, name, start=start, end=end, axis=axis)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The blade's normal."""
        return {"axis": self.axis}


@final
@dataclass(frozen=True, slots=True, init=False)
class Rolling(Contact):
    """A disc or a sphere on end that rolls without slipping on a plane of start.

    Of its three rows the first holds the point of contact in the plane, the others hold the velocity there:
    forward, then sideways. The multipliers are the contact force on end along the normal, forward and to the
    left [N].

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frame whose origin is in the plane, and the frame in the centre of disc or sphere.
    radius : number or formula
        Of the disc or sphere, above zero [m].
    normal : str or (3,) number or formula
        Of the plane, towards the wheel, in start.
    axis : str or (3,) number or formula, optional
        Axle of a disc, in end; a disc that spins positively about it rolls forward. Left out: a sphere,
        whose forward direction is fixed in start.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, a direction or a formula.
    """

    multiplier_unit: ClassVar[str] = "N"

    radius: Formula
    normal: Axis
    axis: Axis | None

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        radius: Value,
        normal: str | Iterable[Value] = "z",
        axis: str | Iterable[Value] | None = None,
    ) -> None:
        own = {"axis": axis_or_none}
        take(self, name, own, start=start, end=end, radius=radius, normal=normal, axis=axis)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Normal and axle."""
        return {"normal": self.normal} if self.axis is None else {"normal": self.normal, "axis": self.axis}

    def own_uses(self) -> Iterable[Use]:
        """Return where the radius stands."""
        return (Use("radius", self.radius, Scope.CONSTANT),)
