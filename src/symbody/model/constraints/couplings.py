"""Coordinates of joints coupled by wheels, racks and belts; and any equation."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.constraint import Condition
from symbody.model.constraints.words import symbols, take
from symbody.model.door import Door, Value
from symbody.model.uses import Scope, Use

_ONE: Final = Formula.of(1)


@dataclass(frozen=True, slots=True, init=False)
class Coupling(Condition):
    """A linear equation between coordinates of joints: the sum of factors times coordinates is the offset.

    Attributes
    ----------
    displacements : int
        How many of the first coordinates are displacements; all others are angles.
    coupled : tuple of str
        The coordinates.
    offset : Formula
        In parameters and t.
    """

    displacements: ClassVar[int] = 0

    coupled: tuple[str, ...]
    offset: Formula

    @property
    @abstractmethod
    def factors(self) -> tuple[Formula, ...]:
        """The factor of each coordinate, in parameters."""

    def uses(self) -> Iterator[Use]:
        """Return where names and formulas stand."""
        for k, name in enumerate(self.coupled):
            yield Use(f"coupled[{k}]", Formula.of(name), Scope.COORDINATE)
        yield Use("offset", self.offset, Scope.PRESCRIBED)
        yield from self.own_uses()

    def own_uses(self) -> Iterable[Use]:
        """Return where the formulas beside the offset stand."""
        return ()


@final
@dataclass(frozen=True, slots=True, init=False)
class Gear(Coupling):
    """Two wheels in mesh: ``first = ratio second + offset``.

    Wheels that mesh on the outside turn against each other: their ratio is negative. The multiplier is the
    torque on the first wheel about its axis [N m].

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    coupled : (2,) str
        The angles of two joints.
    ratio : number or formula
        Turns of the first for one of the second, in parameters.
    offset : number or formula
        The first angle where the second is 0 [rad].

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.
    """

    multiplier_unit: ClassVar[str] = "N m"

    ratio: Formula

    def __init__(self, name: str, coupled: Iterable[str], ratio: Value, offset: Value = 0) -> None:
        own = {"coupled": symbols(2), "offset": Door.angle}
        take(self, name, own, coupled=coupled, offset=offset, ratio=ratio)

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``1, -ratio``."""
        return (_ONE, _negative(self.ratio))

    def own_uses(self) -> Iterable[Use]:
        """Return where the ratio stands."""
        return (Use("ratio", self.ratio, Scope.CONSTANT),)


@final
@dataclass(frozen=True, slots=True, init=False)
class RackPinion(Coupling):
    """A rack moved by a wheel: ``displacement = radius angle + offset``.

    The multiplier is the force on the rack along its displacement [N].

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    coupled : (2,) str
        The displacement of a joint and the angle of another.
    radius : number or formula
        Of the pinion, in parameters; negative where a positive angle moves the rack back [m].
    offset : number or formula
        The displacement where the angle is 0 [m].

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.
    """

    multiplier_unit: ClassVar[str] = "N"

    displacements: ClassVar[int] = 1

    radius: Formula

    def __init__(self, name: str, coupled: Iterable[str], radius: Value, offset: Value = 0) -> None:
        take(self, name, {"coupled": symbols(2)}, coupled=coupled, offset=offset, radius=radius)

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``1, -radius``."""
        return (_ONE, _negative(self.radius))

    def own_uses(self) -> Iterable[Use]:
        """Return where the radius stands."""
        return (Use("radius", self.radius, Scope.CONSTANT),)


@final
@dataclass(frozen=True, slots=True, init=False)
class Belt(Coupling):
    """Two pulleys and a belt that does not slip: ``radius1 first = radius2 second + offset``.

    The multiplier is the pull of the belt at the rim of the first pulley, in the sense of its angle [N].

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    coupled : (2,) str
        The angles of two joints.
    radii : (2,) number or formula
        Of the pulleys, in parameters [m].
    crossed : bool
        Whether the belt is crossed, so that the pulleys turn against each other.
    offset : number or formula
        Length of belt wound off the second where the first angle is 0 [m].

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.
    """

    multiplier_unit: ClassVar[str] = "N"

    radii: tuple[Formula, ...]
    crossed: bool

    def __init__(
        self,
        name: str,
        coupled: Iterable[str],
        radii: Iterable[Value],
        crossed: bool = False,
        offset: Value = 0,
    ) -> None:
        take(
            self, name, {"coupled": symbols(2)}, coupled=coupled, offset=offset, radii=radii, crossed=crossed
        )

    @property
    def factors(self) -> tuple[Formula, ...]:
        """The first radius, and the second with the sign of the belt."""
        first, second = self.radii
        return (first, second if self.crossed else _negative(second))

    def own_uses(self) -> Iterable[Use]:
        """Return where the radii stand."""
        return (Use(f"radii[{k}]", radius, Scope.CONSTANT) for k, radius in enumerate(self.radii))


@final
@dataclass(frozen=True, slots=True, init=False)
class Differential(Coupling):
    """A differential: the carrier turns by the mean of its two shafts, ``2 carrier = left + right + offset``.

    The multiplier is half the torque on the carrier about its axis [N m].

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    coupled : (3,) str
        The angles of carrier, left and right shaft.
    offset : number or formula
        Twice the carrier's angle where the shafts are at 0 [rad].

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.
    """

    multiplier_unit: ClassVar[str] = "N m"

    def __init__(self, name: str, coupled: Iterable[str], offset: Value = 0) -> None:
        take(self, name, {"coupled": symbols(3), "offset": Door.angle}, coupled=coupled, offset=offset)

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``2, -1, -1``."""
        return (Formula.of(2), Formula.of(-1), Formula.of(-1))


@final
@dataclass(frozen=True, slots=True, init=False)
class Constraint(Condition):
    """Equations in coordinates, or affine in speeds.

    One with rates or speeds is a constraint on velocities, taken as it stands: nonholonomic, unless it is the
    rate of one on positions. The multiplier times the derivative of the equation by a coordinate, or by its
    rate, is the effort along that coordinate.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    equations : formula or list of formula
        What vanishes, in coordinates, parameters and t; or also in rates and speeds, of first degree.

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.
    """

    equations: tuple[Formula, ...]

    def __init__(self, name: str, equations: Value | Iterable[Value]) -> None:
        take(self, name, equations=equations)

    def uses(self) -> Iterator[Use]:
        """Return where the equations stand."""
        return (Use(f"equations[{k}]", formula, Scope.MOTION) for k, formula in enumerate(self.equations))


def _negative(formula: Formula) -> Formula:
    return Formula.of(f"-({formula.text})")
