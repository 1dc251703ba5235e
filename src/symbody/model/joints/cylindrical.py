"""`Cylindrical`: an angle and a displacement along its axis."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.words import Trees, along, take
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.table import Table
from symbody.model.turn import Axis, unit_axis
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Cylindrical(Joint):
    """Turns about an axis and slides along it.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; end moves relative to start.
    axis : str or (3,) number or formula
        "x", "y", "z", or components in start of any length.
    coordinates : (2,) str, optional
        Names of the angle [rad] and of the displacement [m]; without them ``<joint>_1`` and
        ``_2``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : mapping of coordinate to Drive, optional
        What acts along the displacement.
    torque : mapping of coordinate to Drive, optional
        What acts about the axis.
    motion : mapping of coordinate to number or formula, optional
        The coordinates that are prescribed, in parameters and t [m, rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.
    friction : Friction, optional
        Refused: friction acts along one free direction, a sleeve has two.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> sleeve = Cylindrical("sleeve", "ground", "Rod", coordinates=["theta", "s"])
    >>> [component.text for component in sleeve.shift()]
    ['0', '0', 's']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2")

    axis: Axis
    coordinates: tuple[str, ...]
    force: Table[Drive]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool
    friction: Friction | None

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str | Iterable[Value] = "z",
        coordinates: Iterable[str] | None = None,
        tree: Trees = None,
        force: Mapping[str, Drive] | None = None,
        torque: Mapping[str, Drive] | None = None,
        motion: Mapping[str, Value] | None = None,
        as_constraint: bool = False,
        friction: Friction | None = None,
    ) -> None:
        take(
            self,
            name,
            start,
            end,
            tree,
            axis=axis,
            coordinates=coordinates,
            force=force,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
            friction=friction,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The axis."""
        return {"axis": self.axis}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn about the axis."""
        return (Turn(unit_axis(self.axis), Formula.of(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        x, y, z = (along(component, self.coordinates[1]) for component in unit_axis(self.axis))
        return (x, y, z)
