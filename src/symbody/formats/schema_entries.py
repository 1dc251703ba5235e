"""The entries of the model file as pydantic classes, made from what elements declare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import or_
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import BeforeValidator, Field, StrictInt, StrictStr, create_model
from pydantic_core import PydanticCustomError

from symbody.formats import schema_types as values
from symbody.formats.schema_types import Angle, Axis, Expression, FileEntry, Triple
from symbody.model.body import Frames
from symbody.model.declarations import declaration, element_fields, fields, joint_fields
from symbody.model.declarations.declaration import Declared
from symbody.model.frame import Frame, RotationMatrix, Turns
from symbody.model.joints import orientation
from symbody.model.loads.curve import SpringLaw
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.loads.springs import Six, SixOrMatrix
from symbody.model.registry import definition_name, element_types, shape_types
from symbody.model.shapes.mesh import ScaleFactors
from symbody.model.shapes.shape import Color, Shapes
from symbody.model.signals import block_fields
from symbody.model.tables import lookup

Role: TypeAlias = type[declaration.Field[Any, Any]]

_KEYED: Final = "{ theta = { stiffness = .. } }"
# The keys that stand first in an entry.
_FIRST: Final = ("name", "between", "tree", "type")
# The type of a value in the file by its role; a role without a row takes that of the role it is derived from.
_PLAIN: Final[Mapping[Role, Any]] = MappingProxyType(
    {
        fields.ElementName: str,
        fields.SymbolName: str,
        fields.FilePath: str,
        fields.Text: str,
        lookup.ColumnChoice: Annotated[list[StrictInt | StrictStr], Field(min_length=2, max_length=2)],
        lookup.UnitPair: Annotated[list[str], Field(min_length=2, max_length=2)],
        lookup.TablePoints: list[Annotated[list[Expression], Field(min_length=2, max_length=2)]] | None,
        fields.Quantity: Expression,
        fields.AngleQuantity: Angle,
        fields.OptionalQuantity: Expression,
        fields.OptionalText: str | None,
        fields.VectorQuantity: Triple,
        fields.Direction: Axis,
        fields.OptionalDirection: Axis,
        fields.Flag: bool,
        element_fields.AttachedFrame: str,
        element_fields.Directions: Annotated[list[Axis], Field(min_length=2, max_length=2)],
        element_fields.VanishingFormulas: Expression | list[Expression],
        element_fields.Radii: Annotated[list[Expression], Field(min_length=2, max_length=2)],
        joint_fields.TreeMembership: values.Trees,
        joint_fields.Letter: Annotated[str, Field(json_schema_extra={"enum": ["x", "y", "z"]})],
        joint_fields.Coordinate: str | None,
        joint_fields.Coordinates: list[str] | None,
        joint_fields.PrescribedAngle: Angle,
        joint_fields.PrescribedDisplacement: Expression,
        joint_fields.PrescribedMotions: dict[str, Angle],
        joint_fields.Armature: Expression,
        orientation.SpeedNames: list[str] | None,
        block_fields.NamedGains: dict[str, Expression],
        block_fields.OutputLimits: Annotated[list[Expression], Field(min_length=2, max_length=2)] | None,
        block_fields.Coefficients: list[Expression],
        block_fields.MatrixRows: list[list[Expression]],
        SpringLaw: values.Law,
        SixOrMatrix: values.Six,
        Six: values.Six,
        Turns: list[values.Turn],
        RotationMatrix: Annotated[list[Triple], Field(min_length=3, max_length=3)] | None,
        Color: str,
        ScaleFactors: values.Factors,
    }
)
# Roles whose values are tables, which are empty where they are left out.
_TABLES: Final = (joint_fields.CoordinateDrives, joint_fields.PrescribedMotions, Frames)


def make_entry(kind: type[Declared], name: str, types: Mapping[Role, Any], word: str = "") -> type[FileEntry]:
    """Return the entry of what declares its fields; `word` is its type, if it has one."""
    keys: dict[str, Any] = {"type": (Literal[word], ...)} if word else {}
    for key, field in kind.fields.items():
        place = field.place.partition("[")[0] or key
        if place == "between":
            keys[place] = (values.Between, ...)
        elif field.is_content:
            keys[place] = (_value_type(field, types), _key(field))
    first = {key: keys.pop(key) for key in _FIRST if key in keys}
    return create_model(name, __base__=FileEntry, __doc__=kind.summary(), **first, **keys)


def _value_type(field: declaration.Field[Any, Any], types: Mapping[Role, Any]) -> Any:
    """Return the type of a value in the file, by its role."""
    if isinstance(field, element_fields.Coupled):
        return Annotated[list[str], Field(min_length=field.count, max_length=field.count)]
    if isinstance(field, orientation.AngleSequence):
        return Annotated[str, Field(json_schema_extra={"pattern": field.pattern})]
    if isinstance(field, fields.WordChoice):
        return Annotated[str, Field(json_schema_extra={"enum": [*field.words]})]
    if isinstance(field, block_fields.NamedGains):
        words: dict[str, Any] = {"propertyNames": {"enum": [*field.words]}}
        return Annotated[dict[str, Expression], Field(json_schema_extra=words)]
    if isinstance(field, orientation.SpeedChoice):
        return Annotated[str | None, Field(json_schema_extra={"enum": [*field.words]})]
    return next(types[role] for role in type(field).__mro__ if role in types)


def _key(field: declaration.Field[Any, Any]) -> Any:
    """Return default and description of a key."""
    default = list(field.default) if isinstance(field.default, tuple) else field.default
    if isinstance(field, _TABLES):
        default = {}
    return Field(default=... if field.is_required else default, description=field.description or None)


def _refuse_single_drive(value: object) -> object:
    """Refuse a drive that does not say which coordinate it drives."""
    if isinstance(value, dict) and any(
        key in Drive.fields and not isinstance(item, dict) for key, item in value.items()
    ):
        raise PydanticCustomError("drives", "a table by coordinate, such as {shown}", {"shown": _KEYED})
    return value


def _list_type(entries: Sequence[Any]) -> Any:
    """Return the type of a list of entries; if there are several types, `type` says which one each has."""
    union: Any = reduce(or_, entries)
    entry: Any = Annotated[union, Field(discriminator="type")] if len(entries) > 1 else union
    return list[entry]


def _parts() -> Mapping[Role, Any]:
    """Return the types of parts of elements, which are entries of their own, beside those of plain values."""
    drive: Any = make_entry(Drive, "DriveEntry", _PLAIN)
    frame: Any = make_entry(Frame, "FrameEntry", _PLAIN)
    shapes = [make_entry(each, definition_name(word), _PLAIN, word) for word, each in shape_types().items()]
    return {
        **_PLAIN,
        joint_fields.CoordinateDrive: drive | None,
        joint_fields.CoordinateDrives: Annotated[dict[str, drive], BeforeValidator(_refuse_single_drive)],
        joint_fields.DryFriction: make_entry(Friction, "FrictionEntry", _PLAIN) | None,
        Frames: dict[str, frame],
        Shapes: _list_type(shapes),
    }


TYPES: Final[Mapping[Role, Any]] = MappingProxyType(_parts())


def entry_list_type(kind: str) -> Any:
    """Return the type of the list of all entries of a kind."""
    return _list_type(
        [
            make_entry(each, definition_name(word or kind), TYPES, word)
            for word, each in element_types(kind).items()
        ]
    )
