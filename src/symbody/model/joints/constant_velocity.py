"""`ConstantVelocity`: a bend and its direction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import ORIGIN, Joint, Turn
from symbody.model.joints.directions import bend_axis, letter_from
from symbody.model.joints.words import Reader, Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.turn import LETTERS
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class ConstantVelocity(Joint):
    """Bends in any direction, without twist: two shafts turn at the same rate.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose origins coincide.
    axis : str
        The axis of both shafts, "x", "y" or "z" of start and of end. With "z" the rotation is
        ``Rz(azimuth) Ry(bend) Rz(-azimuth)``; with others in cyclic order.
    coordinates : (2,) str, optional
        Names of the bend and of its azimuth [rad]; without them ``<joint>_1`` and ``_2``. At zero
        bend the azimuth has no meaning: the equations are singular there.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    torque : mapping of coordinate to Drive, optional
        What acts along the angles.
    motion : mapping of coordinate to number or formula, optional
        The angles that are prescribed, in parameters and t [rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> joint = ConstantVelocity("cv", "ground", "Shaft", coordinates=["bend", "azimuth"])
    >>> [turn.angle.text for turn in joint.turns()]
    ['azimuth', 'bend', '-azimuth']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2")

    axis: str
    coordinates: tuple[str, ...]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str = "z",
        coordinates: Iterable[str] | None = None,
        tree: Trees = None,
        torque: Mapping[str, Drive] | None = None,
        motion: Mapping[str, Value] | None = None,
        as_constraint: bool = False,
    ) -> None:
        take(
            self,
            name,
            start,
            end,
            tree,
            own=_OWN,
            axis=axis,
            coordinates=coordinates,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn to the direction of the bend, the bend, and the turn back."""
        bend, azimuth = self.coordinates
        axis, across = LETTERS[self.axis], LETTERS[bend_axis(self.axis)]
        return (
            Turn(axis, Formula.of(azimuth)),
            Turn(across, Formula.of(bend)),
            Turn(axis, Formula.of(f"-{azimuth}")),
        )

    def shift(self) -> Triple:
        """Return zero."""
        return ORIGIN


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"axis": letter_from})
