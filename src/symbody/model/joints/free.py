"""`Free`: a position and an orientation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import RATES, Joint, QuasiSpeeds, Turn
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

_TWIST: Final = "twist"


@final
@dataclass(frozen=True, slots=True, init=False)
class Free(Joint):
    """Prevents nothing; its coordinates are the position of end in start axes, then the orientation.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames; end moves relative to start.
    angles : str
        Successive turns about axes of the body, such as "123" or "xyz"; "space 123" about axes fixed in
        start; or "quaternion", Euler parameters with the scalar first.
    coordinates : (6,) or (7,) str, optional
        Names of the position [m] and of the angles [rad] or Euler parameters; without them ``<joint>_x`` to
        ``_z``, then ``_1`` to ``_3`` or ``_qw`` to ``_qz``.
    speeds : str, optional
        "rates" of the coordinates; or the rate of the position in axes of start and the angular velocity
        in axes of "start" or "end"; or both in axes of end, "twist". By default "rates" of angles and "end"
        with a quaternion.
    speed_names : (6,) str, optional
        Names of those components [m/s, rad/s]; without them ``<joint>_vx`` to ``_wz``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : mapping of coordinate to Drive, optional
        What acts along the components of the position.
    torque : mapping of angle to Drive, optional
        What acts along the angles.
    motion : mapping of coordinate to number or formula, optional
        The coordinates that are prescribed, in parameters and t [m, rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, a sequence or a formula.

    Examples
    --------
    >>> base = Free("base", "ground", "Trunk", speeds="twist")
    >>> base.coordinates
    ('base_x', 'base_y', 'base_z', 'base_qw', 'base_qx', 'base_qy', 'base_qz')
    """

    angles: str
    coordinates: tuple[str, ...]
    speeds: str
    speed_names: tuple[str, ...] | None
    force: Table[Drive]
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
        force: Mapping[str, Drive] | None = None,
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
            force=force,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Letters of the position, then those of the orientation."""
        return ("_x", "_y", "_z", *orientation_suffixes(self.angles))

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """The last four coordinates, where they are Euler parameters."""
        return orientation_quaternion(self.angles, self.coordinates[3:])

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The components of the angular velocity, or None."""
        return quasi_speeds(self, "w", self.speeds)

    @property
    def translation_speeds(self) -> QuasiSpeeds | None:
        """The components of the rate of the position, or None."""
        return quasi_speeds(self, "v", "end" if self.speeds == _TWIST else "start")

    def turns(self) -> tuple[Turn, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[3:])

    def shift(self) -> Triple:
        """Return the position."""
        x, y, z = (Formula.of(name) for name in self.coordinates[:3])
        return (x, y, z)


_OWN: Final[Mapping[str, Reader]] = MappingProxyType(
    {
        "angles": angles_from,
        "speeds": partial(speeds_from, known=(RATES, "start", "end", _TWIST)),
        "speed_names": partial(speed_names_from, kinds="vw"),
    }
)
