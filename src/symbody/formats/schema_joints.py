"""The joints of a model file as pydantic classes, called like those of the model with ``Entry`` behind."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from symbody.formats.schema_types import Angle, Axis, Between, Entry, Expression, Trees

_MOTIONS: Final = "Prescribed coordinates in parameters and t [m, rad], by coordinate."
_KEYED: Final = "{ theta = { stiffness = .. } }"


class DriveEntry(Entry):
    """What acts along a joint coordinate."""

    applied: Expression = Field(default=0, description="Effort on the end body [N, N m].")
    stiffness: Expression = Field(default=0, description="[N/m, N m/rad]")
    damping: Expression = Field(default=0, description="[N s/m, N m s/rad]")
    free: Angle = Field(default=0, description="Coordinate at which the spring is relaxed [m, rad].")


def _by_coordinate(value: object) -> object:
    """Refuse a drive that does not say which coordinate it drives."""
    if isinstance(value, dict) and any(
        key in DriveEntry.model_fields and not isinstance(item, dict) for key, item in value.items()
    ):
        raise PydanticCustomError("drives", "a table by coordinate, such as {shown}", {"shown": _KEYED})
    return value


Drives = Annotated[dict[str, DriveEntry], BeforeValidator(_by_coordinate)]
Names = list[str] | None
Angles = Annotated[
    str,
    Field(
        description='Successive turns about body axes such as "313", about fixed axes such as "space 313", '
        'or "quaternion" (Euler parameters, scalar first).',
        json_schema_extra={"pattern": "^((space )?[1-3xyz]{3}|quaternion)$"},
    ),
]
AsConstraint = Annotated[bool, Field(description="Whether prescribed motions become constraints.")]


class Connection(Entry):
    """What every joint has."""

    name: str
    between: Between
    tree: Trees = None


class WeldEntry(Connection):
    """Holds two frames together."""

    type: Literal["weld"]


class RevoluteEntry(Connection):
    """Turns about an axis."""

    type: Literal["revolute"]
    axis: Axis = Field(default="z", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the angle [rad].")
    torque: DriveEntry | None = Field(default=None, description="What acts about the axis.")
    motion: Angle = Field(default=None, description="Prescribed angle in parameters and t [rad].")
    as_constraint: AsConstraint = False
    armature: Expression = Field(default=0, description="Inertia of the drive's rotor [kg m^2].")


class PrismaticEntry(Connection):
    """Slides along an axis."""

    type: Literal["prismatic"]
    axis: Axis = Field(default="x", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the displacement [m].")
    force: DriveEntry | None = Field(default=None, description="What acts along the axis.")
    motion: Expression = Field(default=None, description="Prescribed displacement in parameters and t [m].")
    as_constraint: AsConstraint = False
    armature: Expression = Field(default=0, description="Inertia of the drive's rotor [kg].")


class PlanarEntry(Connection):
    """Slides in a plane of the start frame and turns about its normal."""

    type: Literal["planar"]
    axis: str = Field(
        default="z",
        description="The normal, an axis of the start frame; the displacements follow in cyclic order.",
        json_schema_extra={"enum": ["x", "y", "z"]},
    )
    coordinates: Names = Field(
        default=None, description="Names of the two displacements [m] and of the angle [rad]."
    )
    force: Drives = Field(default={}, description="What acts along the displacements, by coordinate.")
    torque: Drives = Field(default={}, description="What acts about the normal, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class SphericalEntry(Connection):
    """Turns in any direction about a point."""

    type: Literal["spherical"]
    angles: Angles = "quaternion"
    coordinates: Names = Field(default=None, description="Names of the angles [rad] or Euler parameters.")
    speeds: str | None = Field(
        default=None,
        description="Rates of the angles, or the angular velocity along axes of start or end.",
        json_schema_extra={"enum": ["rates", "start", "end"]},
    )
    speed_names: Names = Field(default=None, description="Names of the components x, y, z [rad/s].")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class FreeEntry(Connection):
    """Prevents nothing; position of end in start axes, then orientation."""

    type: Literal["free"]
    angles: Angles = "quaternion"
    coordinates: Names = Field(
        default=None, description="Names of the position [m], then of the angles [rad] or Euler parameters."
    )
    speeds: str | None = Field(
        default=None,
        description="Rates; or velocity along start axes and angular velocity along axes of start or end; "
        "or both along end axes (twist).",
        json_schema_extra={"enum": ["rates", "start", "end", "twist"]},
    )
    speed_names: Names = Field(
        default=None, description="Names of the velocity [m/s], then of the angular velocity [rad/s]."
    )
    force: Drives = Field(default={}, description="What acts along the position, by coordinate.")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


JointEntry = Annotated[
    WeldEntry | RevoluteEntry | PrismaticEntry | PlanarEntry | SphericalEntry | FreeEntry,
    Field(discriminator="type"),
]
