"""`Screw`: an angle that brings a displacement with it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.directions import pitch_from
from symbody.model.joints.words import Reader, Trees, along, take
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.table import Table
from symbody.model.turn import Axis, unit_axis
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Screw(Joint):
    """Turns about an axis and moves along it in proportion.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; end moves relative to start.
    pitch : number or formula
        Displacement of end along the axis in a full turn [m]; negative for a left-hand thread.
    axis : str or (3,) number or formula
        "x", "y", "z", or components in start of any length.
    coordinate : str, optional
        Name of the angle [rad]; without it the joint's name.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    torque : Drive, optional
        What acts about the axis.
    motion : number or formula, optional
        The angle in parameters and t, if it is prescribed [rad].
    as_constraint : bool
        Whether the prescribed motion becomes a constraint instead of replacing the angle.
    friction : Friction, optional
        What holds the angle back, a torque; its `radius` is that of the thread.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> Screw("nut", "ground", "Nut", pitch="p", coordinate="theta").shift()[2].text
    '(p)*theta/(2*pi)'
    """

    suffixes: ClassVar[tuple[str, ...]] = ("",)

    pitch: Formula
    axis: Axis
    coordinate: str | None
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool
    friction: Friction | None

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        pitch: Value,
        axis: str | Iterable[Value] = "z",
        coordinate: str | None = None,
        tree: Trees = None,
        torque: Drive | None = None,
        motion: Value | None = None,
        as_constraint: bool = False,
        friction: Friction | None = None,
    ) -> None:
        take(
            self,
            name,
            start,
            end,
            tree,
            own=_OWN,
            pitch=pitch,
            axis=axis,
            coordinate=coordinate,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
            friction=friction,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The axis."""
        return {"axis": self.axis}

    @property
    def constants(self) -> Mapping[str, Formula]:
        """The pitch."""
        return {"pitch": self.pitch}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn about the axis."""
        return (Turn(unit_axis(self.axis), Formula.of(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the pitch for each full turn."""
        length = f"({self.pitch.text})*{self.coordinates[0]}/(2*pi)"
        x, y, z = (along(component, length) for component in unit_axis(self.axis))
        return (x, y, z)


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"pitch": pitch_from})
