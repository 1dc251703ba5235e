"""Points held at a distance, on a line, a plane, a curve or a surface."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.constraint import Contact
from symbody.model.constraints.words import take
from symbody.model.door import Door, Value
from symbody.model.turn import Axis
from symbody.model.uses import Scope, Triple, Use


@final
@dataclass(frozen=True, slots=True, init=False)
class Distance(Contact):
    """Holds two points at a distance: a massless rod; or a rope, which may be shorter.

    Its one multiplier is the force with which it pushes the points apart [N]; in a rope it is never positive.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The points.
    value : number or formula
        The distance in parameters and t, above zero [m].
    rope : bool
        Whether the points may come closer: the rope is slack then, and does nothing.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    multiplier_unit: ClassVar[str] = "N"

    value: Formula
    rope: bool

    def __init__(self, name: str, start: Place, end: Place, value: Value, rope: bool = False) -> None:
        take(self, name, {"value": Door.formula}, start=start, end=end, value=value, rope=rope)

    def own_uses(self) -> Iterable[Use]:
        """Return where the distance stands."""
        return (Use("value", self.value, Scope.PRESCRIBED),)


@final
@dataclass(frozen=True, slots=True, init=False)
class PointOnLine(Contact):
    """Holds the origin of end on a line through the origin of start.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frame the line is fixed in, and the point.
    axis : str or (3,) number or formula
        Direction of the line, in start.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a direction.
    """

    multiplier_unit: ClassVar[str] = "N"

    axis: Axis

    def __init__(self, name: str, start: Place, end: Place, axis: str | Iterable[Value] = "x") -> None:
        take(self, name, start=start, end=end, axis=axis)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The line's."""
        return {"axis": self.axis}


@final
@dataclass(frozen=True, slots=True, init=False)
class PointOnPlane(Contact):
    """Holds the origin of end in a plane through the origin of start.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frame the plane is fixed in, and the point.
    axis : str or (3,) number or formula
        Normal of the plane, in start.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a direction.
    """

    multiplier_unit: ClassVar[str] = "N"

    axis: Axis

    def __init__(self, name: str, start: Place, end: Place, axis: str | Iterable[Value] = "z") -> None:
        take(self, name, start=start, end=end, axis=axis)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """The normal."""
        return {"axis": self.axis}


@final
@dataclass(frozen=True, slots=True, init=False)
class PointOnCurve(Contact):
    """Holds the origin of end on a curve fixed in start.

    The curve's parameter becomes a coordinate of the mechanism, without mass.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frame the curve is fixed in, and the point.
    curve : (3,) formula
        Position on the curve in start axes, in the parameter, the model's parameters and t [m].
    parameter : str
        Name of the curve's parameter; its derivative of the curve must vanish nowhere.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    multiplier_unit: ClassVar[str] = "N"

    curve: Triple
    parameter: str

    def __init__(self, name: str, start: Place, end: Place, curve: Iterable[Value], parameter: str) -> None:
        take(self, name, start=start, end=end, curve=curve, parameter=parameter)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The curve's parameter."""
        return (self.parameter,)

    def own_uses(self) -> Iterator[Use]:
        """Return where the formulas of the curve stand."""
        for k, formula in enumerate(self.curve):
            yield Use(f"curve[{k}]", formula, Scope.PRESCRIBED, (self.parameter,))


@final
@dataclass(frozen=True, slots=True, init=False)
class PointOnSurface(Contact):
    """Holds the origin of end on a surface fixed in start; several equations make a curve.

    A multiplier times the gradient of its equation is the force on end.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frame the surface is fixed in, and the point.
    equations : formula or list of formula
        What vanishes on the surface, in x, y, z (the point in start axes [m]), parameters and t.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    equations: tuple[Formula, ...]

    def __init__(self, name: str, start: Place, end: Place, equations: Value | Iterable[Value]) -> None:
        take(self, name, start=start, end=end, equations=equations)

    def own_uses(self) -> Iterator[Use]:
        """Return where the equations stand."""
        return (Use(f"equations[{k}]", formula, Scope.POINT) for k, formula in enumerate(self.equations))
