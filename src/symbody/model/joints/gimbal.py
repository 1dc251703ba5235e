"""`Gimbal`: three angles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.arguments import checked_arguments
from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import ORIGIN, Joint, Turn
from symbody.model.joints.orientation import orientation_turns, three_angles_from
from symbody.model.joints.words import Reader, Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Gimbal(Joint):
    """Turns about three axes in succession, as in three rings.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose origins coincide.
    angles : str
        Successive turns about axes of the body, such as "xyz" or "123"; "space 123" about axes fixed in
        start. Where the first axis meets the third, the gimbal is locked.
    coordinates : (3,) str, optional
        Names of the angles [rad]; without them ``<joint>_1`` to ``_3``.
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
        With everything that is not a name, a place, a sequence or a formula.

    Examples
    --------
    >>> rings = Gimbal("rings", "ground", "Rotor", angles="zxy", coordinates=["yaw", "roll", "pitch"])
    >>> [turn.angle.text for turn in rings.turns()]
    ['yaw', 'roll', 'pitch']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2", "_3")

    angles: str
    coordinates: tuple[str, ...]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    @checked_arguments
    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        angles: str = "xyz",
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
            angles=angles,
            coordinates=coordinates,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    def turns(self) -> tuple[Turn, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates)

    def shift(self) -> Triple:
        """Return zero."""
        return ORIGIN


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"angles": three_angles_from})
