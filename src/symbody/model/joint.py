"""`Joint`: what every joint answers, and what follows from it for all of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

from symbody.expr.language.formula import Formula
from symbody.model.door import ZERO
from symbody.model.element import Address, Element
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.naming import symbol_from
from symbody.model.table import Table
from symbody.model.turn import Axis, Turn
from symbody.model.uses import Scope, Triple, Use, triple_uses

__all__ = ["ORIGIN", "RATES", "InTrees", "Joint", "QuasiSpeeds", "Turn"]

ORIGIN: Final[Triple] = (ZERO, ZERO, ZERO)
RATES: Final = "rates"


@dataclass(frozen=True, slots=True)
class InTrees:
    """Whether a joint is to be in the rotation tree and in the translation tree; None: automatic."""

    rotation: bool | None = None
    translation: bool | None = None


@dataclass(frozen=True, slots=True)
class QuasiSpeeds:
    """Speeds that are components of a velocity of end relative to start.

    For rotation the velocity is the angular velocity, for translation the rate of the position of end's
    origin as seen from start.

    Attributes
    ----------
    names : (3,) str
        The components along x, y and z.
    resolved_in : str
        The axes of the components.
    """

    names: tuple[str, str, str]
    resolved_in: Literal["start", "end"]


@dataclass(frozen=True, slots=True, init=False)
class Joint(Element):
    """A connection of two frames; `end` moves relative to `start`.

    A concrete joint states its law: the turns from start to end and the shift of the origin, in its
    coordinates. What it has besides is a field called like a property below that says "nothing", whose
    place it takes. Everything else is derived here.

    Attributes
    ----------
    start, end : Address
        The frames it connects.
    tree : InTrees
        The user's choice of coordinates.
    """

    kind: ClassVar[str] = "joint"

    name: str
    start: Address
    end: Address
    tree: InTrees

    # The law.

    @property
    @abstractmethod
    def suffixes(self) -> tuple[str, ...]:
        """What follows the joint's name in the name of each coordinate without one of its own."""

    @abstractmethod
    def turns(self) -> tuple[Turn, ...]:
        """Return the successive simple rotations from the start frame to the end frame."""

    @abstractmethod
    def shift(self) -> Triple:
        """Return the position of end's origin from start's, in axes of `shift_in` [m]."""

    # What a joint may have besides.

    @property
    def coordinate(self) -> str | None:
        """The user's name for the only coordinate, or None."""
        return None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates; those without a name of their own are named after the joint."""
        return tuple(self.coordinate or name for name in self.default_coordinates)

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Each axis by the place where it stands."""
        return {}

    @property
    def constants(self) -> Mapping[str, Formula]:
        """Each further constant of the law by its word."""
        return {}

    @property
    def shift_in(self) -> Literal["start", "end"]:
        """The axes in which the shift has its components."""
        return "start"

    @property
    def force(self) -> Table[Drive]:
        """What acts along each driven displacement."""
        return Table()

    @property
    def torque(self) -> Table[Drive]:
        """What acts along each driven angle."""
        return Table()

    @property
    def motion(self) -> Table[Formula]:
        """Each prescribed coordinate as a formula in parameters and t."""
        return Table()

    @property
    def as_constraint(self) -> bool:
        """Whether prescribed motions become constraints instead of replacing the coordinate."""
        return False

    @property
    def armature(self) -> Mapping[str, Formula]:
        """Rotor inertia along a coordinate [kg, kg m^2]."""
        return {}

    @property
    def friction(self) -> Friction | None:
        """Dry friction along the only coordinate."""
        return None

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """Names of the Euler parameters, scalar first, end to start, where they give the orientation.

        `turns` is then empty.
        """
        return None

    @property
    def speeds(self) -> str:
        """What the speeds are: ``"rates"`` of the coordinates, or components of velocities."""
        return RATES

    @property
    def speed_names(self) -> tuple[str, ...] | None:
        """The user's names of the quasi-speeds, translation first, or None."""
        return None

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The speeds of the rotation; None: the rates of its coordinates."""
        return None

    @property
    def translation_speeds(self) -> QuasiSpeeds | None:
        """The speeds of the translation; None: the rates of its coordinates."""
        return None

    # What follows.

    @property
    def default_coordinates(self) -> tuple[str, ...]:
        """The names of coordinates that the user gives none."""
        own = symbol_from(self.name)
        return tuple(f"{own}{suffix}" for suffix in self.suffixes)

    @property
    def names_given(self) -> tuple[str | None, ...]:
        """The user's name for each coordinate, or None where there is none."""
        if len(self.suffixes) == 1:
            return (self.coordinate,)
        pairs = zip(self.coordinates, self.default_coordinates, strict=True)
        return tuple(None if name == default else name for name, default in pairs)

    @property
    def has_named_coordinates(self) -> bool:
        """Whether the user named every coordinate."""
        return None not in self.names_given

    @property
    def quasi_speed_names(self) -> tuple[str, ...]:
        """Names of the speeds that are no rates of coordinates, translation first."""
        both = (self.translation_speeds, self.rotation_speeds)
        return tuple(name for speeds in both if speeds is not None for name in speeds.names)

    @property
    def drives(self) -> Mapping[str, Drive]:
        """What acts along each driven coordinate."""
        return {**self.force, **self.torque}

    @property
    def motions(self) -> Mapping[str, Formula]:
        """Each prescribed coordinate as a formula in parameters and t."""
        return self.motion

    @property
    def rotation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that turn the end frame."""
        inside = {name for turn in self.turns() for name in turn.angle.names} | set(self.quaternion or ())
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def angle_coordinates(self) -> tuple[str, ...]:
        """The rotation coordinates that are angles, no parts of a quaternion."""
        return tuple(name for name in self.rotation_coordinates if name not in (self.quaternion or ()))

    @property
    def translation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that shift the end frame's origin."""
        inside = {name for component in self.shift() for name in component.names}
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def coupled_coordinates(self) -> tuple[str, ...]:
        """The coordinates that turn the end frame and shift its origin, as in a screw."""
        both = set(self.translation_coordinates)
        return tuple(name for name in self.rotation_coordinates if name in both)

    @property
    def is_untwisted(self) -> bool:
        """Whether the last turn takes the first one back, so that end never turns about its shaft."""
        return len(self.turns()) == 3 and len(self.rotation_coordinates) == 2

    @property
    def locked_rotations(self) -> int:
        """Number of rotations the joint prevents."""
        return 0 if self.quaternion else 3 - len(self.rotation_coordinates)

    @property
    def locked_translations(self) -> int:
        """Number of translations the joint prevents; one tied to a rotation, as in a screw, is prevented."""
        return 3 - len(set(self.translation_coordinates) - set(self.rotation_coordinates))

    @property
    def locked_directions(self) -> int:
        """Number of directions the joint prevents."""
        return self.locked_rotations + self.locked_translations

    def path_of(self, word: str, coordinate: str) -> str:
        """Return where `word` stands for a coordinate: ``"torque"``, or ``"torque.theta"`` of several."""
        return word if len(self.coordinates) == 1 else f"{word}.{coordinate}"

    def placed_drives(self) -> Iterator[tuple[str, str, Drive]]:
        """Return each drive after its place and its coordinate."""
        for word, drives in (("force", self.force), ("torque", self.torque)):
            for coordinate, drive in drives.items():
                yield self.path_of(word, coordinate), coordinate, drive

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        for path, axis in self.directions.items():
            if not isinstance(axis, str):
                yield from triple_uses(path, axis, Scope.CONSTANT)
        for path, constant in self.constants.items():
            yield Use(path, constant, Scope.CONSTANT)
        for path, _, drive in self.placed_drives():
            yield from drive.uses(path)
        for coordinate, motion in self.motion.items():
            yield Use(self.path_of("motion", coordinate), motion, Scope.PRESCRIBED)
        for coordinate, inertia in self.armature.items():
            yield Use(self.path_of("armature", coordinate), inertia, Scope.CONSTANT)
        if self.friction is not None:
            yield from self.friction.uses("friction")
