"""The structure of the model file as pydantic classes; `schema.json` beside this file is made from them.

They check keys and types. What the values mean is checked by the Model.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Final

from pydantic import Field, WithJsonSchema
from pydantic.functional_validators import PlainValidator
from pydantic_core import PydanticCustomError

from symbody.formats.schema_constraints import ConstraintEntry
from symbody.formats.schema_joints import JointEntry
from symbody.formats.schema_shapes import ShapeEntry
from symbody.formats.schema_types import Angle, Axis, Between, Entry, Expression, Law, Triple, Turn

VERSION: Final = 1


def _version(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise PydanticCustomError("version", "a whole number")
    if value > VERSION:
        raise PydanticCustomError("newer", "a version this symbody knows")
    return value


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
    shape: list[ShapeEntry] = Field(default=[], description="What is seen of it.")


class BodyEntry(Entry):
    """A rigid body."""

    name: str
    mass: Expression = Field(default=0, description="Mass [kg].")
    inertia: Triple = Field(default=[0, 0, 0], description="xx, yy, zz about the centre of mass [kg m^2].")
    products: Triple = Field(default=[0, 0, 0], description="Tensor entries xy, xz, yz [kg m^2].")
    frames: dict[str, FrameEntry] = Field(default={}, description="Frames fixed on the body.")
    unphysical: bool = Field(default=False, description="Whether an impossible inertia is taken as it is.")
    shape: list[ShapeEntry] = Field(default=[], description="What is seen of it.")


class SpringEntry(Entry):
    """A spring and damper on the line between two points."""

    name: str
    between: Between
    stiffness: Expression = Field(default=0, description="[N/m]")
    damping: Expression = Field(default=0, description="[N s/m]")
    free: Expression = Field(default=0, description="Length at which it is relaxed [m].")
    applied: Expression = Field(default=0, description="Further force, pushing the ends apart [N].")
    law: Law = Field(
        default=0,
        description="Further force, pushing the ends apart, in length and length_rate; a curve is one over "
        "the length [N].",
    )


class TorsionSpringEntry(Entry):
    """A spring and damper about an axis."""

    name: str
    between: Between
    axis: Axis = Field(default="z", description="In the start frame.")
    stiffness: Expression = Field(default=0, description="[N m/rad]")
    damping: Expression = Field(default=0, description="[N m s/rad]")
    free: Angle = Field(default=0, description="Angle at which it is relaxed [rad].")
    applied: Expression = Field(default=0, description="Further torque on end along the axis [N m].")
    law: Law = Field(
        default=0,
        description="Further torque on end, in angle and angle_rate; a curve is one over the angle [N m].",
    )


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
    torsion_spring: list[TorsionSpringEntry] = []
    force: list[ForceEntry] = []
    torque: list[TorqueEntry] = []
    constraint: list[ConstraintEntry] = []
    initial: dict[str, Angle] = Field(default={}, description="Initial values of coordinates and speeds.")
    layout: dict[str, Any] = Field(default={}, description="The diagram; of no meaning to the mechanism.")


def schema_text() -> str:
    """Return the JSON Schema of the model file, as it stands in `schema.json`."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ModelFile.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"
