"""`Spherical`: an orientation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import ORIGIN, Joint, QuasiSpeeds, Turn
from symbody.model.joints.orientation import (
    QUATERNION,
    angles_from,
    orientation_quaternion,
    orientation_suffixes,
    orientation_turns,
    quasi_speeds,
    speed_names_from,
    speeds_from,
)
from symbody.model.joints.words import Reader, Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Spherical(Joint):
    """Turns in any direction about a point.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose origins coincide.
    angles : str
        Successive turns about axes of the body, such as "313" or "zxz"; "space 313" about axes fixed in
        start; or "quaternion", Euler parameters with the scalar first.
    coordinates : (3,) or (4,) str, optional
        Names of the angles [rad] or Euler parameters; without them ``<joint>_1`` to ``_3``, or ``_qw`` to
        ``_qz``.
    speeds : str, optional
        "rates" of the angles, or the components of the angular velocity along axes of "start" or "end";
        by default "rates" of angles and "end" with a quaternion.
    speed_names : (3,) str, optional
        Names of those components [rad/s]; without them ``<joint>_wx`` to ``_wz``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    torque : mapping of angle to Drive, optional
        What acts along the angles.
    motion : mapping of angle to number or formula, optional
        The angles that are prescribed, in parameters and t [rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the angles.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, a sequence or a formula.

    Examples
    --------
    >>> pivot = Spherical("pivot", "ground", "Top", angles="313", coordinates=["zeta", "eta", "xi"])
    >>> [turn.angle.text for turn in pivot.turns()]
    ['zeta', 'eta', 'xi']
    """

    angles: str
    coordinates: tuple[str, ...]
    speeds: str
    speed_names: tuple[str, ...] | None
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        angles: str = QUATERNION,
        coordinates: Iterable[str] | None = None,
        speeds: str | None = None,
        speed_names: Iterable[str] | None = None,
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
            speeds=speeds,
            speed_names=speed_names,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Numbers of the angles, or letters of the Euler parameters."""
        return orientation_suffixes(self.angles)

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """The coordinates, where they are Euler parameters."""
        return orientation_quaternion(self.angles, self.coordinates)

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The components of the angular velocity, or None."""
        return quasi_speeds(self, "w", self.speeds)

    def turns(self) -> tuple[Turn, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates)

    def shift(self) -> Triple:
        """Return zero."""
        return ORIGIN


_OWN: Final[Mapping[str, Reader]] = MappingProxyType(
    {"angles": angles_from, "speeds": speeds_from, "speed_names": speed_names_from}
)
