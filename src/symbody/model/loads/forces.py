"""Drives of joint coordinates, and forces, torques and springs between frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place, address_from
from symbody.model.door import Door, Value
from symbody.model.element import Address, Element
from symbody.model.loads.curve import Curve, Law, LawValue, law_from
from symbody.model.uses import Scope, Triple, Use, triple_uses

# What the law of a spring between points may read beside the names of loads.
LENGTH: Final = ("length", "length_rate")


@final
@dataclass(frozen=True, slots=True, init=False)
class Drive:
    """What acts along a joint coordinate: ``applied + law - stiffness*(x - free) - damping*x_dot``.

    Parameters
    ----------
    applied : number or formula
        Effort on the end body along the positive coordinate [N, N m].
    stiffness : number or formula
        [N/m, N m/rad]
    damping : number or formula
        [N s/m, N m s/rad]
    free : number or formula
        Coordinate at which the spring is relaxed [m, rad].
    law : number, formula or Curve
        Further effort; a curve is one over the coordinate [N, N m].

    Raises
    ------
    ModelError
        If an entry is not a formula.
    """

    applied: Formula
    stiffness: Formula
    damping: Formula
    free: Formula
    law: Law

    def __init__(
        self,
        applied: Value = 0,
        stiffness: Value = 0,
        damping: Value = 0,
        free: Value = 0,
        law: LawValue = 0,
    ) -> None:
        door = Door("drive")
        object.__setattr__(self, "applied", door.formula(applied, "applied"))
        object.__setattr__(self, "stiffness", door.formula(stiffness, "stiffness"))
        object.__setattr__(self, "damping", door.formula(damping, "damping"))
        object.__setattr__(self, "free", door.angle(free, "free"))
        object.__setattr__(self, "law", law_from(door, law, "law"))
        door.close()

    @property
    def reads_coordinate(self) -> bool:
        """Whether the effort depends on the coordinate itself, by spring or curve."""
        return self.stiffness.constant() != 0 or isinstance(self.law, Curve)

    def uses(self, path: str) -> Iterator[Use]:
        """Return where the formulas stand, below `path`."""
        yield Use(f"{path}.applied", self.applied, Scope.LOAD)
        yield Use(f"{path}.stiffness", self.stiffness, Scope.LOAD)
        yield Use(f"{path}.damping", self.damping, Scope.LOAD)
        yield Use(f"{path}.free", self.free, Scope.LOAD)
        yield from law_uses(f"{path}.law", self.law)


def law_uses(path: str, law: Law, own: tuple[str, ...] = ()) -> Iterator[Use]:
    """Return where the formula of a law stands; `own` are the names that mean something in it alone."""
    if not isinstance(law, Curve):
        yield Use(path, law, Scope.LOAD, own)


def drive_from(door: Door, value: object, path: str) -> Drive | None:
    """Return a drive, or None where there is none."""
    if value is None or isinstance(value, Drive):
        return value
    door.refuse(
        "model.not_a_drive",
        path,
        f"{value!r} is not a drive",
        "",
        "write Drive(applied=.., stiffness=.., damping=.., free=..)",
    )
    return None


@final
@dataclass(frozen=True, slots=True, init=False)
class Force(Element):
    """A force in a point, and its reaction.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    on : Body, frame or name
        Where it acts.
    vector : (3,) number or formula
        Components [N].
    resolved_in : Body, frame or name
        The axes of the components.
    reaction_on : Body, frame or name
        The body that gets the opposite force, in the same point.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    kind: ClassVar[str] = "force"

    name: str
    on: Address
    vector: Triple
    resolved_in: Address
    reaction_on: Address

    def __init__(
        self,
        name: str,
        on: Place,
        vector: Iterable[Value],
        resolved_in: Place = "ground",
        reaction_on: Place = "ground",
    ) -> None:
        _set_vector_load(self, Door(f"force {name}"), name, on, vector, resolved_in, reaction_on)

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        return triple_uses("vector", self.vector, Scope.LOAD)


@final
@dataclass(frozen=True, slots=True, init=False)
class Torque(Element):
    """A torque on a body, and its reaction.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    on : Body, frame or name
        The body it acts on.
    vector : (3,) number or formula
        Components [N m].
    resolved_in : Body, frame or name
        The axes of the components.
    reaction_on : Body, frame or name
        The body that gets the opposite torque.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    kind: ClassVar[str] = "torque"

    name: str
    on: Address
    vector: Triple
    resolved_in: Address
    reaction_on: Address

    def __init__(
        self,
        name: str,
        on: Place,
        vector: Iterable[Value],
        resolved_in: Place = "ground",
        reaction_on: Place = "ground",
    ) -> None:
        _set_vector_load(self, Door(f"torque {name}"), name, on, vector, resolved_in, reaction_on)

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        return triple_uses("vector", self.vector, Scope.LOAD)


@final
@dataclass(frozen=True, slots=True, init=False)
class SpringDamper(Element):
    """A spring and damper on the line between two points; a free length of exactly 0 is a vector law.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The points it connects.
    stiffness, damping : number or formula
        [N/m], [N s/m]
    free : number or formula
        Length at which the spring is relaxed [m].
    applied : number or formula
        Further force that pushes the ends apart [N].
    law : number, formula or Curve
        Further force that pushes the ends apart, in `length` and `length_rate` beside the names of loads; a
        curve is one over the length [N].

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    kind: ClassVar[str] = "spring"

    name: str
    start: Address
    end: Address
    stiffness: Formula
    damping: Formula
    free: Formula
    applied: Formula
    law: Law

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        stiffness: Value = 0,
        damping: Value = 0,
        free: Value = 0,
        applied: Value = 0,
        law: LawValue = 0,
    ) -> None:
        door = Door(f"spring {name}")
        object.__setattr__(self, "name", door.element_name(name))
        object.__setattr__(self, "start", address_from(door, start, "between[0]"))
        object.__setattr__(self, "end", address_from(door, end, "between[1]"))
        object.__setattr__(self, "stiffness", door.formula(stiffness, "stiffness"))
        object.__setattr__(self, "damping", door.formula(damping, "damping"))
        object.__setattr__(self, "free", door.formula(free, "free"))
        object.__setattr__(self, "applied", door.formula(applied, "applied"))
        object.__setattr__(self, "law", law_from(door, law, "law"))
        door.close()

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        yield Use("stiffness", self.stiffness, Scope.LOAD)
        yield Use("damping", self.damping, Scope.LOAD)
        yield Use("free", self.free, Scope.LOAD)
        yield Use("applied", self.applied, Scope.LOAD)
        yield from law_uses("law", self.law, LENGTH)


def _set_vector_load(
    load: Force | Torque,
    door: Door,
    name: str,
    on: Place,
    vector: Iterable[Value],
    resolved_in: Place,
    reaction_on: Place,
) -> None:
    object.__setattr__(load, "name", door.element_name(name))
    object.__setattr__(load, "on", address_from(door, on, "on"))
    object.__setattr__(load, "vector", door.triple(vector, "vector"))
    object.__setattr__(load, "resolved_in", address_from(door, resolved_in, "resolved_in"))
    object.__setattr__(load, "reaction_on", address_from(door, reaction_on, "reaction_on"))
    door.close()
