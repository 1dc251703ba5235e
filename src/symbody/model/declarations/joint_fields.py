"""The roles that arguments of joints have: coordinates, drives and motions by coordinate, axes, trees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, TypeAlias

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import AlongCoordinate, ByCoordinate, ListOf, OptionalField
from symbody.model.declarations.element_fields import Directions
from symbody.model.declarations.field import FileTarget, Node, PlainField
from symbody.model.declarations.fields import (
    AngleQuantity,
    DeclaredPart,
    Flag,
    Quantity,
    Refusal,
    SymbolName,
    TextField,
)
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import Misfit, Path, Schema, wrong_type
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joint import InTrees, Joint
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction, check_friction
from symbody.model.loads.gap_laws import GapLawPart, Limits
from symbody.model.numbers import as_float, formula_value
from symbody.model.numeric_checks import FINITE, Domain, NumericChecks
from symbody.model.simple_rotation import LETTERS, Axis, not_perpendicular

TreeChoice = InTrees | bool | Mapping[str, bool] | None
_TREES: Final = ("rotation", "translation")


@dataclass(frozen=True, eq=False, repr=False)
class TreeMembership(PlainField[TreeChoice, InTrees]):
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
        if isinstance(value, Mapping) and not _tree_misfits(value, ()):
            return InTrees(value.get("rotation"), value.get("translation"))
        fix = "write true, false, or { rotation = true, translation = false }; leave it out for automatic"
        arguments.add("model.bad_tree", path, f"{value!r} is not a valid choice of trees", "", fix)
        return InTrees()

    def schema(self) -> Schema:
        """Return a boolean, or one for each tree."""
        flags = {tree: {"type": "boolean"} for tree in _TREES}
        table = {"type": "object", "properties": flags, "additionalProperties": False}
        return {"anyOf": [{"type": "boolean"}, table]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a choice of trees."""
        return _tree_misfits(entry, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return one flag for both trees where that says it."""
        if value.rotation is not None and value.rotation == value.translation:
            flag: bool = value.rotation
            return flag
        choices = {tree: getattr(value, tree) for tree in _TREES}
        return {tree: flag for tree, flag in choices.items() if flag is not None}


def _tree_misfits(entry: object, path: Path) -> Iterable[Misfit]:
    if isinstance(entry, bool):
        return ()
    if isinstance(entry, Mapping) and set(entry) <= set(_TREES):
        if all(isinstance(flag, bool) for flag in entry.values()):
            return ()
    return wrong_type(entry, path, "true, false, or { rotation = true, translation = false }")


@dataclass(frozen=True, eq=False, repr=False)
class Coordinate(OptionalField[str, str]):
    """The name of the only coordinate."""

    annotation: ClassVar[str]

    _: KW_ONLY
    inner: Any = field(default_factory=SymbolName)
    is_nullable: bool = True

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> str | None:
        """Return the name, or None for that of the joint."""
        return None if value is None else _symbol(arguments, value, path, owner.default_coordinates[0])


@dataclass(frozen=True, eq=False, repr=False)
class Coordinates(ListOf[Iterable[str] | None, tuple[str, ...]]):
    """The names of several coordinates."""

    role: ClassVar[str] = "coordinates"
    takes: ClassVar[str] = "list of str"
    annotation: ClassVar[str] = "Iterable[str] | None"
    explanation: ClassVar[str] = "Without names they are named after the joint."

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=SymbolName)
    is_nullable: bool = True

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> tuple[str, ...]:
        """Return the names."""
        return read_names(arguments, value, path, owner.default_coordinates)


def _drive() -> DeclaredPart[Drive]:
    refusal = Refusal(
        "model.not_a_drive",
        what="{value} is not a drive",
        fix="write Drive(applied=.., stiffness=.., damping=.., free=..)",
    )
    return DeclaredPart(kind=Drive, refusal=refusal)


@dataclass(frozen=True, eq=False, repr=False)
class CoordinateDrive(AlongCoordinate[Drive | None, Drive]):
    """What acts along the only coordinate."""

    role: ClassVar[str] = "drive"
    takes: ClassVar[str] = "Drive"
    annotation: ClassVar[str] = "Drive | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_drive)
    is_nullable: bool = True

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of a drive."""
        return _applied_alone(entry, path) if isinstance(entry, str) else self.item.misfits(entry, path)


@dataclass(frozen=True, eq=False, repr=False)
class CoordinateDrives(ByCoordinate[Mapping[str, Drive] | None, Drive]):
    """What acts along coordinates, by their names."""

    role: ClassVar[str] = "drives"
    takes: ClassVar[str] = "mapping of coordinate to Drive"
    annotation: ClassVar[str] = "Mapping[str, Drive] | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_drive)

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the drives; one that does not say which coordinate it drives is one."""
        if isinstance(entry, str):
            return _applied_alone(entry, path)
        if isinstance(entry, dict) and any(
            key in Drive.fields and not isinstance(item, dict) for key, item in entry.items()
        ):
            return wrong_type(entry, path, "a table by coordinate, such as { theta = { stiffness = .. } }")
        return ByCoordinate.misfits(self, entry, path)


def _applied_alone(entry: str, path: Path) -> Iterable[Misfit]:
    return wrong_type(entry, path, "a table", f'write {path[-1]} = {{ applied = "{entry}" }}')


LimitsLike: TypeAlias = Limits | Mapping[str, Any]


def _limits() -> GapLawPart[Limits]:
    refusal = Refusal(
        "model.not_limits",
        what="{value} is not a pair of limits",
        fix="write Limits(low=.., high=.., rigid=True), or stiffness=.. instead of rigid",
    )
    return GapLawPart(kind=Limits, refusal=refusal)


@dataclass(frozen=True, eq=False, repr=False)
class CoordinateLimits(AlongCoordinate[LimitsLike | None, Limits]):
    """The ends of the only coordinate."""

    role: ClassVar[str] = "limits"
    takes: ClassVar[str] = "Limits or mapping"
    annotation: ClassVar[str] = "LimitsLike | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_limits)
    is_nullable: bool = True


@dataclass(frozen=True, eq=False, repr=False)
class AllLimits(ByCoordinate[Mapping[str, LimitsLike] | None, Limits]):
    """The ends of coordinates, by their names."""

    role: ClassVar[str] = "limits_by_coordinate"
    takes: ClassVar[str] = "mapping of coordinate to Limits"
    annotation: ClassVar[str] = "Mapping[str, LimitsLike] | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_limits)

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the limits; those that do not say of which coordinate are one."""
        if isinstance(entry, dict) and any(
            key in Limits.fields and not isinstance(item, dict) for key, item in entry.items()
        ):
            return wrong_type(
                entry, path, "a table by coordinate, such as { theta = { high = .., rigid = true } }"
            )
        return ByCoordinate.misfits(self, entry, path)


def _prescribed_formula() -> Quantity:
    return AngleQuantity(scope=Scope.PRESCRIBED, fits=FINITE)


@dataclass(frozen=True, eq=False, repr=False)
class PrescribedCoordinate(AlongCoordinate[Value | None, Formula]):
    """The only coordinate as a formula."""

    role: ClassVar[str] = "motion"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_prescribed_formula)


@dataclass(frozen=True, eq=False, repr=False)
class PrescribedMotions(ByCoordinate[Mapping[str, Value] | None, Formula]):
    """Coordinates as formulas, by their names."""

    role: ClassVar[str] = "motions"
    takes: ClassVar[str] = "mapping of coordinate to number or formula"
    annotation: ClassVar[str] = "Mapping[str, Value] | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=_prescribed_formula)


_ARMATURES: Final = Domain(
    "model.negative_armature", "the inertia of the rotor is {value}", "a sign is wrong",
    "give a positive inertia, or leave armature out", 0.0,
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Armature(AlongCoordinate[Value, Formula]):
    """The rotor inertia along the only coordinate."""

    role: ClassVar[str] = "quantity"
    takes: ClassVar[str] = "number or formula"
    annotation: ClassVar[str] = "Value"

    _: KW_ONLY
    item: Any = field(default_factory=lambda: Quantity(fits=_ARMATURES))

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> FrozenMapping[Formula]:
        """Return the inertia by coordinate; none if it is 0."""
        inertias = ByCoordinate.read(self, owner, arguments, value, path)
        return FrozenMapping({name: inertia for name, inertia in inertias.items() if inertia.constant() != 0})


_NO_FRICTION: Final = Refusal("model.not_friction", what="{value} is not friction",
                              fix="write Friction(mu=.., v0=..), or Friction(force=.., v0=..)")  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class DryFriction(OptionalField[Friction, Friction]):
    """Dry friction along the only coordinate."""

    _: KW_ONLY
    inner: Any = field(default_factory=lambda: DeclaredPart(kind=Friction, refusal=_NO_FRICTION))
    is_nullable: bool = True

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> Friction | None:
        """Return the friction; it is refused where there are several free directions."""
        friction = OptionalField.read(self, owner, arguments, value, path)
        has_bristles = friction is not None and friction.has_bristles
        for name in ("mu_y",) if has_bristles else ("mu_y", "stribeck"):
            if friction is not None and getattr(friction, name) is not None:
                what, why = (
                    f"{name} is for contacts",
                    "a joint slides along one direction, by one coefficient",
                )
                arguments.add("contact.friction", f"{path}.{name}", what, why, "leave it out")
        if friction is None or len(owner.coordinates) == 1:
            return friction
        what = f"the joint has {len(owner.coordinates)} free directions"
        why = "friction is defined for one direction only"
        fix = "replace the joint by joints with one coordinate each, with massless bodies between them"
        arguments.add("model.friction_directions", path, what, why, fix)
        return None

    def check_numbers(self, check: NumericChecks, owner: Joint, value: Any, where: str) -> None:
        """Refuse impossible coefficients."""
        if value is not None:
            check_friction(check, value, where, bool(owner.rotation_coordinates))


class Letter(TextField[str, str]):
    """An axis that must be a letter, because others follow it in cyclic order."""

    role: ClassVar[str] = "letter"
    explanation: ClassVar[str] = '"x", "y" or "z".'

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> str:
        """Return the letter."""
        if isinstance(value, str) and value in LETTERS:
            return value
        why = "the coordinates are along or about the other two axes"
        fix = 'write "x", "y" or "z"; for another direction rotate the connected frames'
        arguments.add("model.axis_letter", path, f"{value!r} is not an axis of the start frame", why, fix)
        return "z"

    def schema(self) -> Schema:
        """Return one of the letters."""
        return {"type": "string", "enum": [*LETTERS]}


@dataclass(frozen=True, eq=False, repr=False)
class PerpendicularAxes(Directions):
    """Two perpendicular directions."""

    _: KW_ONLY
    why: str = ""
    fix: str = 'write two perpendicular axes, such as ["x", "y"]'
    instead: tuple[object, ...] = ("x", "y")

    def read(self, owner: Joint, arguments: Arguments, value: object, path: str) -> tuple[Axis, Axis]:
        """Return two axes; those that are numbers are refused unless they are perpendicular."""
        first, second = Directions.read(self, owner, arguments, value, path)
        values = _numbers(first), _numbers(second)
        if values[0] is not None and values[1] is not None:
            skew = not_perpendicular(values[0], values[1])
            if skew:
                arguments.add("model.skew_axes", path, *skew)
        return first, second

    def check_numbers(self, check: NumericChecks, owner: Any, value: tuple[Axis, Axis], where: str) -> None:
        """Refuse directions of length zero, and those that are not perpendicular."""
        Directions.check_numbers(self, check, owner, value, where)
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
LIMITS: Final = CoordinateLimits("Ends of the coordinate: rigid, or a force that pushes back.")
ALL_LIMITS: Final = AllLimits("Ends of coordinates, by coordinate: rigid, or a force that pushes back.")


def read_names(arguments: Arguments, value: object, path: str, default: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of symbols, as many as `default` has, which stands where none or a bad one is given."""
    if value is None:
        return default
    items = arguments.items(value, path)
    if len(items) != len(default):
        what = f"{len(items)} names instead of {len(default)}"
        why = f"the default names are {', '.join(default)}"
        arguments.add("model.wrong_number", path, what, why, f"give {len(default)} names, or none")
        return default
    pairs = zip(items, default, strict=True)
    return tuple(_symbol(arguments, item, f"{path}[{k}]", other) for k, (item, other) in enumerate(pairs))


def _numbers(axis: Axis) -> list[float] | None:
    """Return the components of an axis, or None where one has no value without parameters."""
    components = LETTERS[axis] if isinstance(axis, str) else axis
    values = [formula_value(component) for component in components]
    known = [as_float(value) for value in values if value is not None]
    return known if len(known) == 3 else None


def _symbol(arguments: Arguments, value: object, path: str, default: str) -> str:
    count = len(arguments.problems)
    name = arguments.symbol_name(value, path)
    return name if len(arguments.problems) == count else default
