"""`Universal`: two angles about perpendicular axes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import ORIGIN, Joint, Turn
from symbody.model.joints.directions import Axes, perpendicular_axes
from symbody.model.joints.words import Reader, Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.turn import Axis, unit_axis
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Universal(Joint):
    """Turns about an axis of start, then about one of end that stays perpendicular to it.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose origins coincide.
    axes : (axis, axis)
        The first fixed in start, the second in end, each a letter or three components; perpendicular.
    coordinates : (2,) str, optional
        Names of the angles about the first and the second axis [rad]; without them ``<joint>_1`` and
        ``_2``.
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
        With everything that is not a name, a place, two perpendicular axes or a formula.

    Examples
    --------
    >>> cross = Universal("cross", "ground", "Shaft", axes=["x", "y"], coordinates=["a", "b"])
    >>> [turn.angle.text for turn in cross.turns()]
    ['a', 'b']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2")

    axes: tuple[Axis, Axis]
    coordinates: tuple[str, ...]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axes: Axes = ("x", "y"),
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
            axes=axes,
            coordinates=coordinates,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Both axes."""
        return {f"axes[{k}]": axis for k, axis in enumerate(self.axes)}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn about the axis of start, then that about the axis of end."""
        pairs = zip(self.axes, self.coordinates, strict=True)
        return tuple(Turn(unit_axis(axis), Formula.of(name)) for axis, name in pairs)

    def shift(self) -> Triple:
        """Return zero."""
        return ORIGIN


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"axes": perpendicular_axes})
