"""The joints; each states only its own law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place, address_from
from symbody.model.door import ZERO, Door, Value
from symbody.model.element import Address
from symbody.model.forces import Drive, drive_from
from symbody.model.joint import InTrees, Joint, trees_from
from symbody.model.turn import Axis, Turn, axis_from, unit_axis
from symbody.model.uses import Triple

Trees = InTrees | bool | Mapping[str, bool] | None

_ORIGIN: Final[Triple] = (ZERO, ZERO, ZERO)


@final
@dataclass(frozen=True, slots=True, init=False)
class Weld(Joint):
    """Holds two frames together.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames that coincide.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.

    Raises
    ------
    ModelError
        With everything that is not a name or a place.
    """

    name: str
    start: Address
    end: Address
    tree: InTrees

    def __init__(self, name: str, start: Place, end: Place, tree: Trees = None) -> None:
        door = Door(f"joint {name}")
        _set_ends(self, door, name, start, end, tree)
        door.close()

    @property
    def names_given(self) -> tuple[str | None, ...]:
        """Nothing."""
        return ()

    @property
    def drives(self) -> Mapping[str, Drive]:
        """Nothing."""
        return {}

    @property
    def motions(self) -> Mapping[str, Formula]:
        """Nothing."""
        return {}

    @property
    def axes(self) -> Mapping[str, Axis]:
        """Nothing."""
        return {}

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return zero."""
        return _ORIGIN


@final
@dataclass(frozen=True, slots=True, init=False)
class Revolute(Joint):
    """Turns about an axis.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects; end turns by the coordinate relative to start.
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

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.
    """

    name: str
    start: Address
    end: Address
    axis: Axis
    coordinate: str | None
    tree: InTrees
    torque: Drive | None
    motion: Formula | None

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str | Iterable[Value] = "z",
        coordinate: str | None = None,
        tree: Trees = None,
        torque: Drive | None = None,
        motion: Value | None = None,
    ) -> None:
        door = Door(f"joint {name}")
        _set_ends(self, door, name, start, end, tree)
        _set_coordinate(self, door, axis, coordinate)
        object.__setattr__(self, "torque", drive_from(door, torque, "torque"))
        object.__setattr__(self, "motion", None if motion is None else door.angle(motion, "motion"))
        door.close()

    @property
    def names_given(self) -> tuple[str | None, ...]:
        """The name of the angle."""
        return (self.coordinate,)

    @property
    def drives(self) -> Mapping[str, Drive]:
        """The torque about the axis."""
        return {} if self.torque is None else {self.coordinates[0]: self.torque}

    @property
    def motions(self) -> Mapping[str, Formula]:
        """The prescribed angle."""
        return {} if self.motion is None else {self.coordinates[0]: self.motion}

    @property
    def axes(self) -> Mapping[str, Axis]:
        """The axis of the turn."""
        return {"axis": self.axis}

    def turns(self) -> tuple[Turn, ...]:
        """Return the turn about the axis."""
        return (Turn(unit_axis(self.axis), Formula.of(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return zero."""
        return _ORIGIN


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

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> Prismatic("slider", "ground", "Mass", coordinate="x").shift()[0].text
    'x'
    """

    name: str
    start: Address
    end: Address
    axis: Axis
    coordinate: str | None
    tree: InTrees
    force: Drive | None
    motion: Formula | None

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
    ) -> None:
        door = Door(f"joint {name}")
        _set_ends(self, door, name, start, end, tree)
        _set_coordinate(self, door, axis, coordinate)
        object.__setattr__(self, "force", drive_from(door, force, "force"))
        object.__setattr__(self, "motion", None if motion is None else door.formula(motion, "motion"))
        door.close()

    @property
    def names_given(self) -> tuple[str | None, ...]:
        """The name of the displacement."""
        return (self.coordinate,)

    @property
    def drives(self) -> Mapping[str, Drive]:
        """The force along the axis."""
        return {} if self.force is None else {self.coordinates[0]: self.force}

    @property
    def motions(self) -> Mapping[str, Formula]:
        """The prescribed displacement."""
        return {} if self.motion is None else {self.coordinates[0]: self.motion}

    @property
    def axes(self) -> Mapping[str, Axis]:
        """The axis of the motion."""
        return {"axis": self.axis}

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return the axis times the coordinate."""
        x, y, z = (_along(component, self.coordinates[0]) for component in unit_axis(self.axis))
        return (x, y, z)


def _set_ends(joint: Joint, door: Door, name: str, start: Place, end: Place, tree: Trees) -> None:
    object.__setattr__(joint, "name", door.element_name(name))
    object.__setattr__(joint, "start", address_from(door, start, "between[0]"))
    object.__setattr__(joint, "end", address_from(door, end, "between[1]"))
    object.__setattr__(joint, "tree", trees_from(door, tree))


def _set_coordinate(joint: Joint, door: Door, axis: str | Iterable[Value], coordinate: str | None) -> None:
    name = None if coordinate is None else door.symbol_name(coordinate, "coordinate")
    object.__setattr__(joint, "axis", axis_from(door, axis, "axis"))
    object.__setattr__(joint, "coordinate", name)


def _along(component: Formula, coordinate: str) -> Formula:
    """Return the product of a component and a coordinate, short where the component is 0 or 1."""
    if component.text in ("0", "1"):
        return Formula.of(coordinate if component.text == "1" else 0)
    return Formula.of(f"({component.text})*{coordinate}")
