"""Directions held parallel, perpendicular, or at an angle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.constraint import Contact
from symbody.model.constraints.words import take
from symbody.model.door import Value
from symbody.model.turn import Axis
from symbody.model.uses import Scope, Use

Axes = Iterable[str | Iterable[Value]]


@final
@dataclass(frozen=True, slots=True, init=False)
class Parallel(Contact):
    """Holds a direction of end parallel to one of start.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames.
    axes : [axis, axis]
        The direction in start and the one in end, each a letter or three components.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a direction.
    """

    multiplier_unit: ClassVar[str] = "N m"

    axes: tuple[Axis, Axis]

    def __init__(self, name: str, start: Place, end: Place, axes: Axes = ("z", "z")) -> None:
        take(self, name, start=start, end=end, axes=axes)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Both."""
        return {f"axes[{k}]": axis for k, axis in enumerate(self.axes)}


@final
@dataclass(frozen=True, slots=True, init=False)
class Perpendicular(Contact):
    """Holds a direction of end perpendicular to one of start.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames.
    axes : [axis, axis]
        The direction in start and the one in end, each a letter or three components.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a direction.
    """

    multiplier_unit: ClassVar[str] = "N m"

    axes: tuple[Axis, Axis]

    def __init__(self, name: str, start: Place, end: Place, axes: Axes) -> None:
        take(self, name, start=start, end=end, axes=axes)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Both."""
        return {f"axes[{k}]": axis for k, axis in enumerate(self.axes)}


@final
@dataclass(frozen=True, slots=True, init=False)
class Angle(Contact):
    """Holds the angle between a direction of start and one of end: its cosine is kept.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames.
    axes : [axis, axis]
        The direction in start and the one in end, each a letter or three components.
    value : number or formula
        The angle in parameters and t [rad], off 0 and pi, where the cosine stands still.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, a direction or a formula.
    """

    multiplier_unit: ClassVar[str] = "N m"

    axes: tuple[Axis, Axis]
    value: Formula

    def __init__(self, name: str, start: Place, end: Place, axes: Axes, value: Value) -> None:
        take(self, name, start=start, end=end, axes=axes, value=value)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Both."""
        return {f"axes[{k}]": axis for k, axis in enumerate(self.axes)}

    def own_uses(self) -> Iterable[Use]:
        """Return where the angle stands."""
        return (Use("value", self.value, Scope.PRESCRIBED),)
