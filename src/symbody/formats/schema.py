"""The structure of the model file as pydantic classes; `schema.json` beside this file is made from them.

They check keys and types. What the values mean is checked by the Model.
"""

from __future__ import annotations

import json
from decimal import Decimal
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, Strict, WithJsonSchema
from pydantic.functional_validators import PlainValidator
from pydantic_core import PydanticCustomError

VERSION: Final = 1


def _expression(value: object) -> str | int | float | Decimal:
    if isinstance(value, bool) or not isinstance(value, str | int | float | Decimal):
        raise PydanticCustomError("expression", "a number or an expression")
    if not isinstance(value, str) and not Decimal(value).is_finite():
        raise PydanticCustomError("not_finite", "a finite number")
    return value


def _axis(value: object) -> object:
    if isinstance(value, str):
        return value
    if isinstance(value, list) and len(value) == 3:
        return [_expression(item) for item in value]
    raise PydanticCustomError("axis", '"x", "y", "z", or three components')


def _trees(value: object) -> object:
    if isinstance(value, bool):
        return value
    if isinstance(value, dict) and set(value) <= {"rotation", "translation"}:
        if all(isinstance(flag, bool) for flag in value.values()):
            return value
    raise PydanticCustomError("trees", "true, false, or { rotation = true, translation = false }")


def _version(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise PydanticCustomError("version", "a whole number")
    if value > VERSION:
        raise PydanticCustomError("newer", "a version this symbody knows")
    return value


_TEXT_OR_NUMBER: Final = {"type": ["string", "number"]}
Expression = Annotated[
    Any,
    PlainValidator(_expression),
    WithJsonSchema({**_TEXT_OR_NUMBER, "description": "A number, or a formula in the names allowed there."}),
]
Angle = Annotated[
    Any,
    PlainValidator(_expression),
    WithJsonSchema({**_TEXT_OR_NUMBER, "description": 'An angle in rad, or such as "30 deg".'}),
]
Triple = Annotated[list[Expression], Field(min_length=3, max_length=3)]
Axis = Annotated[
    Any,
    PlainValidator(_axis),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": ["x", "y", "z"]},
                {"type": "array", "items": _TEXT_OR_NUMBER, "minItems": 3, "maxItems": 3},
            ],
            "description": "A letter, or components of a vector of any length.",
        }
    ),
]
Trees = Annotated[
    Any,
    PlainValidator(_trees),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "boolean"},
                {
                    "type": "object",
                    "properties": {"rotation": {"type": "boolean"}, "translation": {"type": "boolean"}},
                    "additionalProperties": False,
                },
            ],
            "description": "Whether the joint is in the rotation and translation tree; left out: automatic.",
        }
    ),
]
Turn = Annotated[tuple[Axis, Angle], Strict(False)]
Between = Annotated[list[str], Field(min_length=2, max_length=2, description="Start and end frame.")]


class Entry(BaseModel):
    """A table of the file: only the keys listed, no conversion of types."""

    model_config: ClassVar[ConfigDict] = ConfigDict(extra="forbid", strict=True, frozen=True)


class FrameEntry(Entry):
    """Axes with an origin, fixed on a body."""

    at: Triple = Field(
        default=[0, 0, 0], description="Origin [m], in the body's axes from its centre of mass."
    )
    rotate: list[Turn] = Field(default=[], description="Successive body-fixed turns: axis and angle.")
    matrix: Annotated[list[Triple], Field(min_length=3, max_length=3)] | None = Field(
        default=None,
        description="Rotation matrix instead of turns; takes components in the frame to the body.",
    )


class GroundEntry(Entry):
    """What is fixed."""

    frames: dict[str, FrameEntry] = Field(default={}, description="Frames fixed on the ground.")


class BodyEntry(Entry):
    """A rigid body."""

    name: str
    mass: Expression = Field(default=0, description="Mass [kg].")
    inertia: Triple = Field(default=[0, 0, 0], description="xx, yy, zz about the centre of mass [kg m^2].")
    products: Triple = Field(default=[0, 0, 0], description="Tensor entries xy, xz, yz [kg m^2].")
    frames: dict[str, FrameEntry] = Field(default={}, description="Frames fixed on the body.")


class DriveEntry(Entry):
    """What acts along a joint coordinate."""

    applied: Expression = Field(default=0, description="Effort on the end body [N, N m].")
    stiffness: Expression = Field(default=0, description="[N/m, N m/rad]")
    damping: Expression = Field(default=0, description="[N s/m, N m s/rad]")
    free: Angle = Field(default=0, description="Coordinate at which the spring is relaxed [m, rad].")


class WeldEntry(Entry):
    """Holds two frames together."""

    name: str
    type: Literal["weld"]
    between: Between
    tree: Trees = None


class RevoluteEntry(Entry):
    """Turns about an axis."""

    name: str
    type: Literal["revolute"]
    between: Between
    axis: Axis = Field(default="z", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the angle [rad].")
    tree: Trees = None
    torque: DriveEntry | None = Field(default=None, description="What acts about the axis.")
    motion: Angle = Field(default=None, description="Prescribed angle in parameters and t [rad].")


class PrismaticEntry(Entry):
    """Slides along an axis."""

    name: str
    type: Literal["prismatic"]
    between: Between
    axis: Axis = Field(default="x", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the displacement [m].")
    tree: Trees = None
    force: DriveEntry | None = Field(default=None, description="What acts along the axis.")
    motion: Expression = Field(default=None, description="Prescribed displacement in parameters and t [m].")


class SpringEntry(Entry):
    """A spring and damper on the line between two points."""

    name: str
    between: Between
    stiffness: Expression = Field(default=0, description="[N/m]")
    damping: Expression = Field(default=0, description="[N s/m]")
    free: Expression = Field(default=0, description="Length at which it is relaxed [m].")
    applied: Expression = Field(default=0, description="Further force, pushing the ends apart [N].")


class ForceEntry(Entry):
    """A force in a point."""

    name: str
    on: str = Field(description="The point.")
    vector: Triple = Field(description="Components [N].")
    resolved_in: str = Field(default="ground", description="The axes of the components.")
    reaction_on: str = Field(default="ground", description="The body that gets the opposite force.")


class TorqueEntry(Entry):
    """A torque on a body."""

    name: str
    on: str = Field(description="The body.")
    vector: Triple = Field(description="Components [N m].")
    resolved_in: str = Field(default="ground", description="The axes of the components.")
    reaction_on: str = Field(default="ground", description="The body that gets the opposite torque.")


JointEntry = Annotated[WeldEntry | RevoluteEntry | PrismaticEntry, Field(discriminator="type")]


class ModelFile(Entry):
    """A mechanism. SI units, radians."""

    version: Annotated[
        Any, PlainValidator(_version), WithJsonSchema({"type": "integer", "minimum": 1, "maximum": VERSION})
    ] = Field(default=VERSION, description="Version of the file format.")
    name: str = Field(description="Title.")
    gravity: Triple = Field(
        default=[0, 0, 0], description="Acceleration of free fall in ground axes [m/s^2]."
    )
    inputs: list[str] = Field(default=[], description="Quantities given from outside while it moves.")
    parameters: dict[str, Angle] = Field(
        default={}, description='Values, or formulas of other parameters; "" where there is no value yet.'
    )
    ground: GroundEntry = Field(default_factory=GroundEntry)
    body: list[BodyEntry] = []
    joint: list[JointEntry] = []
    spring: list[SpringEntry] = []
    force: list[ForceEntry] = []
    torque: list[TorqueEntry] = []
    initial: dict[str, Angle] = Field(default={}, description="Initial values of coordinates and rates.")
    layout: dict[str, Any] = Field(default={}, description="The diagram; of no meaning to the mechanism.")


def schema_text() -> str:
    """Return the JSON Schema of the model file, as it stands in `schema.json`."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ModelFile.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"
