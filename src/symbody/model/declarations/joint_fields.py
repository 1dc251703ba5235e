"""The roles that arguments of joints have: coordinates, drives and motions by coordinate, axes, trees."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Final, TypeVar

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.declaration import Field, Given
from symbody.model.declarations.element_fields import Directions
from symbody.model.declarations.fields import Flag
from symbody.model.declarations.formula_site import FormulaSite, Scope
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joint import InTrees, Joint
from symbody.model.loads.forces import Drive, read_drive
from symbody.model.loads.friction import Friction, check_friction, read_friction
from symbody.model.numbers import as_float, formula_value
from symbody.model.numeric_checks import NumericChecks
from symbody.model.simple_rotation import LETTERS, Axis, not_perpendicular, read_axis

T = TypeVar("T")
TreeChoice = InTrees | bool | Mapping[str, bool] | None


@dataclass(frozen=True, eq=False, repr=False)
class TreeMembership(Field[TreeChoice, InTrees]):
    """The choice of trees."""

    role: ClassVar[str] = "tree"
    takes: ClassVar[str] = "bool or mapping"
    annotation: ClassVar[str] = "TreeChoice"

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> InTrees:
        """Return the choice from None, a bool, or a mapping rotation/translation to bool."""
        if isinstance(value, InTrees):
            return value
        if value is None:
            return InTrees()
        if isinstance(value, bool):
            return InTrees(value, value)
        if isinstance(value, Mapping) and set(value) <= {"rotation", "translation"}:
            if all(isinstance(flag, bool) for flag in value.values()):
                return InTrees(value.get("rotation"), value.get("translation"))
        arguments.add(
            "model.bad_tree",
            path,
            f"{value!r} is not a valid choice of trees",
            "",
            "write true, false, or { rotation = true, translation = false }; leave it out for automatic",
        )
        return InTrees()


@dataclass(frozen=True, eq=False, repr=False)
class Coordinate(Field[str | None, str | None]):
    """The name of the only coordinate."""

    role: ClassVar[str] = "coordinate"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str | None"

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> str | None:
        """Return the name, or None for that of the joint."""
        return None if value is None else _symbol(arguments, value, path, owner.default_coordinates[0])


@dataclass(frozen=True, eq=False, repr=False)
class Coordinates(Field[Iterable[str] | None, tuple[str, ...]]):
    """The names of several coordinates."""

    role: ClassVar[str] = "coordinates"
    takes: ClassVar[str] = "list of str"
    annotation: ClassVar[str] = "Iterable[str] | None"
    explanation: ClassVar[str] = "Without names they are named after the joint."

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> tuple[str, ...]:
        """Return the names."""
        return read_names(arguments, value, path, owner.default_coordinates)


@dataclass(frozen=True, eq=False, repr=False)
class _Drives(Field[Given, FrozenMapping[Drive]]):
    """What both roles of drives do."""

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> FrozenMapping[Drive]:
        """Return the drives by coordinate."""
        return _read_by_coordinate(
            owner, arguments, value, path, lambda item, place: read_drive(arguments, item, place)
        )

    def formula_sites(self, owner: Joint, value: FrozenMapping[Drive], path: str) -> Iterator[FormulaSite]:
        """Return where the formulas of the drives stand."""
        for coordinate, drive in value.items():
            yield from drive.formula_sites(owner.coordinate_path(path, coordinate))

    def check_numbers(
        self, check: NumericChecks, owner: Joint, value: FrozenMapping[Drive], where: str
    ) -> None:
        """Note coefficients that look odd."""
        for coordinate, drive in value.items():
            drive.check_numbers(check, owner.coordinate_path(where, coordinate))


class CoordinateDrive(_Drives[Drive | None]):
    """What acts along the only coordinate."""

    role: ClassVar[str] = "drive"
    takes: ClassVar[str] = "Drive"
    annotation: ClassVar[str] = "Drive | None"


class CoordinateDrives(_Drives[Mapping[str, Drive] | None]):
    """What acts along coordinates, by their names."""

    role: ClassVar[str] = "drives"
    takes: ClassVar[str] = "mapping of coordinate to Drive"
    annotation: ClassVar[str] = "Mapping[str, Drive] | None"


@dataclass(frozen=True, eq=False, repr=False)
class _Motions(Field[Given, FrozenMapping[Formula]]):
    """What both roles of prescribed motions do."""

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> FrozenMapping[Formula]:
        """Return the motions by coordinate."""
        return _read_by_coordinate(owner, arguments, value, path, arguments.formula)

    def formula_sites(self, owner: Joint, value: FrozenMapping[Formula], path: str) -> Iterator[FormulaSite]:
        """Return where the motions stand."""
        for coordinate, motion in value.items():
            yield FormulaSite(owner.coordinate_path(path, coordinate), motion, Scope.PRESCRIBED)

    def check_numbers(
        self, check: NumericChecks, owner: Joint, value: FrozenMapping[Formula], where: str
    ) -> None:
        """Refuse motions whose value is not finite."""
        for coordinate, motion in value.items():
            check.value(motion, owner.coordinate_path(where, coordinate))


class PrescribedAngle(_Motions[Value | None]):
    """The only coordinate as a formula, an angle."""

    role: ClassVar[str] = "motion"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value | None"


class PrescribedDisplacement(PrescribedAngle):
    """The only coordinate as a formula, a displacement."""


class PrescribedMotions(_Motions[Mapping[str, Value] | None]):
    """Coordinates as formulas, by their names."""

    role: ClassVar[str] = "motions"
    takes: ClassVar[str] = "mapping of coordinate to number or formula"
    annotation: ClassVar[str] = "Mapping[str, Value] | None"


class Armature(Field[Value, FrozenMapping[Formula]]):
    """The rotor inertia along the only coordinate."""

    role: ClassVar[str] = "quantity"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value"

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> FrozenMapping[Formula]:
        """Return the inertia by coordinate; none if it is 0."""
        inertias = _read_by_coordinate(owner, arguments, value, path, arguments.formula)
        return FrozenMapping({name: inertia for name, inertia in inertias.items() if inertia.constant() != 0})

    def formula_sites(self, owner: Joint, value: FrozenMapping[Formula], path: str) -> Iterator[FormulaSite]:
        """Return where the inertia stands."""
        for coordinate, inertia in value.items():
            yield FormulaSite(owner.coordinate_path(path, coordinate), inertia, Scope.CONSTANT)

    def check_numbers(
        self, check: NumericChecks, owner: Joint, value: FrozenMapping[Formula], where: str
    ) -> None:
        """Refuse a negative inertia."""
        for coordinate, formula in value.items():
            place = owner.coordinate_path(where, coordinate)
            inertia = check.value(formula, place)
            if inertia is not None and inertia < 0:
                check.refuse(
                    "model.negative_armature",
                    place,
                    f"the inertia of the rotor is {inertia:g}",
                    "a sign is wrong",
                    "give a positive inertia, or leave armature out",
                )


@dataclass(frozen=True, eq=False, repr=False)
class DryFriction(Field[Friction | None, Friction | None]):
    """Dry friction along the only coordinate."""

    role: ClassVar[str] = "friction"
    takes: ClassVar[str] = "Friction"
    annotation: ClassVar[str] = "Friction | None"

    _: KW_ONLY
    default: Any = None

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> Friction | None:
        """Return the friction; it is refused where there are several free directions."""
        friction = read_friction(arguments, value, path)
        if friction is None or len(owner.coordinates) == 1:
            return friction
        arguments.add(
            "model.friction_directions",
            path,
            f"the joint has {len(owner.coordinates)} free directions",
            "friction is defined for one direction only",
            "replace the joint by joints with one coordinate each, with massless bodies between them",
        )
        return None

    def formula_sites(self, owner: Joint, value: Friction | None, path: str) -> Iterator[FormulaSite]:
        """Return where its formulas stand."""
        return iter(()) if value is None else value.formula_sites(path)

    def check_numbers(self, check: NumericChecks, owner: Joint, value: Friction | None, where: str) -> None:
        """Refuse impossible coefficients."""
        if value is not None:
            check_friction(check, value, where, bool(owner.rotation_coordinates))


class Letter(Field[str, str]):
    """An axis that must be a letter, because others follow it in cyclic order."""

    role: ClassVar[str] = "letter"
    takes: ClassVar[str] = "str"
    annotation: ClassVar[str] = "str"
    explanation: ClassVar[str] = '"x", "y" or "z".'

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> str:
        """Return the letter."""
        if isinstance(value, str) and value in LETTERS:
            return value
        arguments.add(
            "model.axis_letter",
            path,
            f"{value!r} is not an axis of the start frame",
            "the coordinates are along or about the other two axes",
            'write "x", "y" or "z"; for another direction rotate the connected frames',
        )
        return "z"


class PerpendicularAxes(Directions):
    """Two perpendicular directions."""

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> tuple[Axis, Axis]:
        """Return two axes; those that are numbers are refused unless they are perpendicular."""
        items = arguments.items(value, path)
        if len(items) != 2:
            arguments.add(
                "model.wrong_number",
                path,
                f"{len(items)} axes instead of two",
                "",
                'write two perpendicular axes, such as ["x", "y"]',
            )
            return ("x", "y")
        first, second = (read_axis(arguments, item, f"{path}[{k}]") for k, item in enumerate(items))
        values = _numbers(first), _numbers(second)
        if values[0] is not None and values[1] is not None:
            skew = not_perpendicular(values[0], values[1])
            if skew:
                arguments.add("model.skew_axes", path, *skew)
        return first, second

    def check_numbers(self, check: NumericChecks, owner: Any, value: tuple[Axis, Axis], where: str) -> None:
        """Refuse directions of length zero, and those that are not perpendicular."""
        super().check_numbers(check, owner, value, where)
        vectors = [check.values(LETTERS[axis] if isinstance(axis, str) else axis, where) for axis in value]
        if vectors[0] is not None and vectors[1] is not None:
            skew = not_perpendicular(vectors[0], vectors[1])
            if skew:
                check.refuse("model.skew_axes", where, *skew)


# Arguments that many joints share.
TREE: Final = TreeMembership(
    "Whether the joint is in the rotation tree and the translation tree; leave it out for automatic."
)
MOTIONS: Final = PrescribedMotions(
    "Prescribed coordinates, as formulas in parameters and t [m, rad], by coordinate."
)
AS_CONSTRAINT: Final = Flag("Whether prescribed motions become constraints.", default=False)
FRICTION: Final = DryFriction("Friction in the joint.")


def read_names(arguments: Arguments, value: object, path: str, default: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of symbols, as many as `default` has, which stands where none or a bad one is given."""
    if value is None:
        return default
    items = arguments.items(value, path)
    if len(items) != len(default):
        arguments.add(
            "model.wrong_number",
            path,
            f"{len(items)} names instead of {len(default)}",
            f"the default names are {', '.join(default)}",
            f"give {len(default)} names, or none",
        )
        return default
    pairs = zip(items, default, strict=True)
    return tuple(_symbol(arguments, item, f"{path}[{k}]", other) for k, (item, other) in enumerate(pairs))


def _numbers(axis: Axis) -> list[float] | None:
    """Return the components of an axis, or None where one has no value without parameters."""
    components = LETTERS[axis] if isinstance(axis, str) else axis
    values = [formula_value(component) for component in components]
    known = [as_float(value) for value in values if value is not None]
    return known if len(known) == 3 else None


def _read_by_coordinate(
    joint: Joint, arguments: Arguments, value: object, path: str, read: Callable[[object, str], T | None]
) -> FrozenMapping[T]:
    """Return what `read` makes of the value for each coordinate; a joint with one takes it without name."""
    names = joint.coordinates
    if len(names) == 1:
        if isinstance(value, FrozenMapping):  # of a joint that is copied, perhaps with another coordinate
            value = next(iter(value.values()), None)
        value = {} if value is None else {names[0]: value}
    if value is None:
        return FrozenMapping()
    if not isinstance(value, Mapping):
        arguments.add(
            "model.not_by_coordinate",
            path,
            f"{value!r} needs the coordinate that it belongs to",
            f"the joint has {len(names)} coordinates: {', '.join(names)}",
            f"write {{ {names[-1]} = .. }}, in Python {{{names[-1]!r}: ..}}",
        )
        return FrozenMapping()
    found = {str(key): read(item, joint.coordinate_path(path, str(key))) for key, item in value.items()}
    return FrozenMapping({key: item for key, item in found.items() if item is not None})


def _symbol(arguments: Arguments, value: object, path: str, default: str) -> str:
    count = len(arguments.problems)
    name = arguments.symbol_name(value, path)
    return name if len(arguments.problems) == count else default
