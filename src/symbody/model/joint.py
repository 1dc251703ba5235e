"""`Joint`: what every joint answers, and what follows from it for all of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from symbody.expr.language.formula import Formula
from symbody.model.door import Door
from symbody.model.element import Address, Element
from symbody.model.forces import Drive
from symbody.model.naming import symbol_from
from symbody.model.turn import Axis, Turn
from symbody.model.uses import Scope, Triple, Use, triple_uses

__all__ = ["InTrees", "Joint", "Turn"]


@dataclass(frozen=True, slots=True)
class InTrees:
    """Whether a joint is to be in the rotation tree and in the translation tree; None: automatic."""

    rotation: bool | None = None
    translation: bool | None = None


class Joint(Element):
    """A connection of two frames; `end` moves relative to `start`.

    A concrete joint states its law: the turns from start to end and the shift of the origin, in its
    coordinates. Everything else is derived here.

    Attributes
    ----------
    start, end : Address
        The frames it connects.
    tree : InTrees
        The user's choice of coordinates.
    """

    __slots__ = ()

    kind: ClassVar[str] = "joint"

    start: Address
    end: Address
    tree: InTrees

    @property
    @abstractmethod
    def names_given(self) -> tuple[str | None, ...]:
        """The user's name for each coordinate, or None where there is none."""

    @property
    @abstractmethod
    def drives(self) -> Mapping[str, Drive]:
        """What acts along each driven coordinate."""

    @property
    @abstractmethod
    def motions(self) -> Mapping[str, Formula]:
        """Each prescribed coordinate as a formula in parameters and t."""

    @property
    @abstractmethod
    def axes(self) -> Mapping[str, Axis]:
        """Each axis by field name, in the start frame."""

    @abstractmethod
    def turns(self) -> tuple[Turn, ...]:
        """Return the successive simple rotations from the start frame to the end frame."""

    @abstractmethod
    def shift(self) -> Triple:
        """Return the position of the end frame's origin, from the start frame's, in start axes [m]."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates; those without a name of their own are named after the joint."""
        given = self.names_given
        own = symbol_from(self.name)
        default = [own] if len(given) == 1 else [f"{own}_{k + 1}" for k in range(len(given))]
        return tuple(name or other for name, other in zip(given, default, strict=True))

    @property
    def has_named_coordinates(self) -> bool:
        """Whether the user named every coordinate."""
        return None not in self.names_given

    @property
    def rotation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that turn the end frame."""
        inside = {name for turn in self.turns() for name in turn.angle.names}
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def translation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that shift the end frame's origin."""
        inside = {name for component in self.shift() for name in component.names}
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def locked_rotations(self) -> int:
        """Number of rotations the joint prevents."""
        return 3 - len(self.rotation_coordinates)

    @property
    def locked_translations(self) -> int:
        """Number of translations the joint prevents; one tied to a rotation, as in a screw, is prevented."""
        return 3 - len(set(self.translation_coordinates) - set(self.rotation_coordinates))

    @property
    def locked_directions(self) -> int:
        """Number of directions the joint prevents."""
        return self.locked_rotations + self.locked_translations

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        for path, axis in self.axes.items():
            if not isinstance(axis, str):
                yield from triple_uses(path, axis, Scope.CONSTANT)
        for coordinate, drive in self.drives.items():
            word = "torque" if coordinate in self.rotation_coordinates else "force"
            yield from drive.uses(word if len(self.coordinates) == 1 else f"{word}.{coordinate}")
        for coordinate, motion in self.motions.items():
            path = "motion" if len(self.coordinates) == 1 else f"motion.{coordinate}"
            yield Use(path, motion, Scope.PRESCRIBED)


def trees_from(door: Door, value: object) -> InTrees:
    """Return the user's choice of trees from None, a bool, or a mapping rotation/translation to bool."""
    if isinstance(value, InTrees):
        return value
    if value is None:
        return InTrees()
    if isinstance(value, bool):
        return InTrees(value, value)
    if isinstance(value, Mapping) and set(value) <= {"rotation", "translation"}:
        if all(isinstance(flag, bool) for flag in value.values()):
            return InTrees(value.get("rotation"), value.get("translation"))
    door.refuse(
        "model.bad_tree",
        "tree",
        f"{value!r} is no choice of trees",
        "",
        "write true, false, or { rotation = true, translation = false }; leave it out for automatic",
    )
    return InTrees()
