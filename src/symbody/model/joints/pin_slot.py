"""`PinSlot`: an angle and a displacement across its axis."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.directions import Axes, perpendicular_axes
from symbody.model.joints.words import Reader, Trees, along, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.turn import Axis, unit_axis
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class PinSlot(Joint):
    """A pin of end that turns in a slot of start and slides along it.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; start has the slot, end the pin.
    axes : (axis, axis)
        The pin and the slot, each a letter or three components in start; perpendicular.
    coordinates : (2,) str, optional
        Names of the angle [rad] and of the displacement [m]; without them ``<joint>_1`` and
        ``_2``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : mapping of coordinate to Drive, optional
        What acts along the slot.
    torque : mapping of coordinate to Drive, optional
        What acts about the pin.
    motion : mapping of coordinate to number or formula, optional
        The coordinates that are prescribed, in parameters and t [m, rad].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, two perpendicular axes or a formula.

    Examples
    --------
    >>> follower = PinSlot("follower", "Cam", "Rod", axes=["z", "x"], coordinates=["theta", "s"])
    >>> follower.shift()[0].text
    's'
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2")

    axes: tuple[Axis, Axis]
    coordinates: tuple[str, ...]
    force: Table[Drive]
    torque: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axes: Axes = ("z", "x"),
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
            axes=axes,
            coordinates=coordinates,
            force=force,
            torque=torque,
            motion=motion,
            as_constraint=as_constraint,
        )

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Both axes."""
        return {f"axes[{k}]": axis for k, axis in enumerate(self.axes)}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn about the pin."""
        return (Turn(unit_axis(self.axes[0]), Formula.of(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the direction of the slot times the displacement."""
        x, y, z = (along(component, self.coordinates[1]) for component in unit_axis(self.axes[1]))
        return (x, y, z)


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"axes": perpendicular_axes})
