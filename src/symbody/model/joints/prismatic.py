"""`Prismatic`: one displacement."""

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
class Prismatic(Joint):
    """Slides along an axis.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; end moves by the coordinate relative to start.
    axis : str or (3,) number or formula
        "x", "y", "z", or components in start of any length.
    coordinate : str, optional
        Name of the displacement [m]; without it the joint's name.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : Drive, optional
        What acts along the axis.
    motion : number or formula, optional
        The displacement in parameters and t, if it is prescribed [m].
    as_constraint : bool
        Whether the prescribed motion becomes a constraint instead of replacing the displacement.
    armature : number or formula
        Inertia of the drive's rotor as felt at the displacement [kg].
    friction : Friction, optional
        What holds the displacement back, from the reaction or of given strength.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> Prismatic("slider", "ground", "Mass", coordinate="x").shift()[0].text
    'x'
    """

    suffixes: ClassVar[tuple[str, ...]] = ("",)

    axis: Axis
    coordinate: str | None
    force: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool
    armature: Table[Formula]
    friction: Friction | None

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str | Iterable[Value] = "x",
        coordinate: str | None = None,
        tree: Trees = None,
        force: Drive | None = None,
        motion: Value | None = None,
        as_constraint: bool = False,
        armature: Value = 0,
        friction: Friction | None = None,
    ) -> None:
        take(
            self,
            name,
            start,
            end,
            tree,
            axis=axis,
            coordinate=coordinate,
            force=force,
            motion=motion,
            as_constraint=as_constraint,
            armature=armature,
            friction=friction,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The axis of the motion."""
        return {"axis": self.axis}

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return the axis times the coordinate."""
        x, y, z = (along(component, self.coordinates[0]) for component in unit_axis(self.axis))
        return (x, y, z)
