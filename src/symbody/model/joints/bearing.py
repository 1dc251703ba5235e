"""`Bearing`: a displacement and three angles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.arguments import checked_arguments
from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.orientation import orientation_turns, three_angles_from
from symbody.model.joints.words import Reader, Trees, along, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.turn import Axis, unit_axis
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Bearing(Joint):
    """Slides along an axis of start and turns in any direction.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; the origin of end stays on the axis.
    axis : str or (3,) number or formula
        "x", "y", "z", or components in start of any length.
    angles : str
        Successive turns about axes of the body, such as "xyz" or "123"; "space 123" about axes fixed in
        start.
    coordinates : (4,) str, optional
        Names of the displacement [m], then of the angles [rad]; without them ``<joint>_1`` to ``_4``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : mapping of coordinate to Drive, optional
        What acts along the displacement.
    torque : mapping of coordinate to Drive, optional
        What acts along the angles.
    motion : mapping of coordinate to number or formula, optional
        The coordinates that are prescribed, in parameters and t [m, rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis, a sequence or a formula.

    Examples
    --------
    >>> Bearing("bush", "ground", "Shaft", coordinates=["s", "a", "b", "c"]).shift()[2].text
    's'
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2", "_3", "_4")

    axis: Axis
    angles: str
    coordinates: tuple[str, ...]
    force: Table[Drive]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    @checked_arguments
    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str | Iterable[Value] = "z",
        angles: str = "xyz",
        coordinates: Iterable[str] | None = None,
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
            axis=axis,
            angles=angles,
            coordinates=coordinates,
            force=force,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The axis."""
        return {"axis": self.axis}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turns by the angles."""
        return orientation_turns(self.angles, self.coordinates[1:])

    def shift(self) -> Triple:
        """Return the axis times the displacement."""
        x, y, z = (along(component, self.coordinates[0]) for component in unit_axis(self.axis))
        return (x, y, z)


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"angles": three_angles_from})
