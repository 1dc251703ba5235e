"""The joints of a model file as pydantic classes, called like those of the model with ``Entry`` behind."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from symbody.formats.schema_types import Angle, Axis, Between, Entry, Expression, Law, Six, Trees

_MOTIONS: Final = "Prescribed coordinates in parameters and t [m, rad], by coordinate."
_KEYED: Final = "{ theta = { stiffness = .. } }"


class DriveEntry(Entry):
    """What acts along a joint coordinate."""

    applied: Expression = Field(default=0, description="Effort on the end body [N, N m].")
    stiffness: Expression = Field(default=0, description="[N/m, N m/rad]")
    damping: Expression = Field(default=0, description="[N s/m, N m s/rad]")
    free: Angle = Field(default=0, description="Coordinate at which the spring is relaxed [m, rad].")
    law: Law = Field(default=0, description="Further effort; a curve is one over the coordinate [N, N m].")


class FrictionEntry(Entry):
    """Dry friction along the free direction of a joint."""

    mu: Expression = Field(default=0, description="Coefficient on the joint's own reaction while it slides.")
    mu_static: Expression = Field(
        default=None, description="Coefficient up to which it sticks; left out: mu."
    )
    radius: Expression = Field(default=None, description="Of the bearing [m]; a revolute joint needs it.")
    v0: Expression = Field(
        default=None,
        description="Speed of a smooth law [m/s, rad/s]; left out, the joint sticks and slips by events.",
    )
    force: Expression = Field(default=None, description="Strength whatever the reaction [N, N m].")
    static: Expression = Field(default=None, description="Strength up to which it sticks [N, N m].")


Dry = Annotated[FrictionEntry | None, Field(description="What holds the joint back.")]


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
ThreeAngles = Annotated[
    str,
    Field(
        description='Successive turns about body axes such as "123", about fixed axes such as "space 123".',
        json_schema_extra={"pattern": "^(space )?[1-3xyz]{3}$"},
    ),
]
Letter = Annotated[str, Field(json_schema_extra={"enum": ["x", "y", "z"]})]
Axes = Annotated[list[Axis], Field(min_length=2, max_length=2)]
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
    friction: Dry = None


class PrismaticEntry(Connection):
    """Slides along an axis."""

    type: Literal["prismatic"]
    axis: Axis = Field(default="x", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the displacement [m].")
    force: DriveEntry | None = Field(default=None, description="What acts along the axis.")
    motion: Expression = Field(default=None, description="Prescribed displacement in parameters and t [m].")
    as_constraint: AsConstraint = False
    armature: Expression = Field(default=0, description="Inertia of the drive's rotor [kg].")
    friction: Dry = None


class ScrewEntry(Connection):
    """Turns about an axis and moves along it in proportion."""

    type: Literal["screw"]
    pitch: Expression = Field(description="Displacement of end in a full turn [m].")
    axis: Axis = Field(default="z", description="In the start frame.")
    coordinate: str | None = Field(default=None, description="Name of the angle [rad].")
    torque: DriveEntry | None = Field(default=None, description="What acts about the axis.")
    motion: Angle = Field(default=None, description="Prescribed angle in parameters and t [rad].")
    as_constraint: AsConstraint = False
    friction: Dry = None


class CylindricalEntry(Connection):
    """Turns about an axis and slides along it."""

    type: Literal["cylindrical"]
    axis: Axis = Field(default="z", description="In the start frame.")
    coordinates: Names = Field(default=None, description="Names of angle [rad] and displacement [m].")
    force: Drives = Field(default={}, description="What acts along the displacement, by coordinate.")
    torque: Drives = Field(default={}, description="What acts about the axis, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False
    friction: Dry = None


class UniversalEntry(Connection):
    """Turns about an axis of start, then about a perpendicular one of end."""

    type: Literal["universal"]
    axes: Axes = Field(default=["x", "y"], description="First in start, second in end; perpendicular.")
    coordinates: Names = Field(default=None, description="Names of the two angles [rad].")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class ConstantVelocityEntry(Connection):
    """Bends in any direction, without twist."""

    type: Literal["constant_velocity"]
    axis: Letter = Field(default="z", description="The axis of both shafts.")
    coordinates: Names = Field(default=None, description="Names of the bend and of its azimuth [rad].")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class PinSlotEntry(Connection):
    """A pin of end that turns in a slot of start and slides along it."""

    type: Literal["pin_slot"]
    axes: Axes = Field(default=["z", "x"], description="Pin and slot, in start; perpendicular.")
    coordinates: Names = Field(default=None, description="Names of angle [rad] and displacement [m].")
    force: Drives = Field(default={}, description="What acts along the slot, by coordinate.")
    torque: Drives = Field(default={}, description="What acts about the pin, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


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


class RectangularEntry(Connection):
    """Slides in a plane of the start frame, without turning."""

    type: Literal["rectangular"]
    axis: Letter = Field(default="z", description="The normal; the displacements follow in cyclic order.")
    coordinates: Names = Field(default=None, description="Names of the two displacements [m].")
    force: Drives = Field(default={}, description="What acts along the displacements, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class CartesianEntry(Connection):
    """Slides in all directions, without turning."""

    type: Literal["cartesian"]
    coordinates: Names = Field(default=None, description="Names of the displacements along x, y, z [m].")
    force: Drives = Field(default={}, description="What acts along the displacements, by coordinate.")
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


class GimbalEntry(Connection):
    """Turns about three axes in succession."""

    type: Literal["gimbal"]
    angles: ThreeAngles = "xyz"
    coordinates: Names = Field(default=None, description="Names of the angles [rad].")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class BearingEntry(Connection):
    """Slides along an axis of start and turns in any direction."""

    type: Literal["bearing"]
    axis: Axis = Field(default="z", description="In the start frame.")
    angles: ThreeAngles = "xyz"
    coordinates: Names = Field(
        default=None, description="Names of the displacement [m] and the angles [rad]."
    )
    force: Drives = Field(default={}, description="What acts along the displacement, by coordinate.")
    torque: Drives = Field(default={}, description="What acts along the angles, by coordinate.")
    motion: dict[str, Angle] = Field(default={}, description=_MOTIONS)
    as_constraint: AsConstraint = False


class TelescopingEntry(Connection):
    """Turns in any direction and slides along an axis of end."""

    type: Literal["telescoping"]
    axis: Axis = Field(default="z", description="In the end frame.")
    angles: ThreeAngles = "xyz"
    coordinates: Names = Field(
        default=None, description="Names of the angles [rad] and the displacement [m]."
    )
    force: Drives = Field(default={}, description="What acts along the displacement, by coordinate.")
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


class BushingEntry(Entry):
    """Gives way in all directions and prevents nothing: along and about x, y, z of the start frame."""

    type: Literal["bushing"]
    name: str
    between: Between
    stiffness: Six = Field(default=[0] * 6, description="[N/m, N m/rad]")
    damping: Six = Field(default=[0] * 6, description="[N s/m, N m s/rad]")
    free: Six = Field(default=[0] * 6, description="Where it is relaxed: position [m] and angles [rad].")


JointEntry = Annotated[
    WeldEntry
    | RevoluteEntry
    | PrismaticEntry
    | ScrewEntry
    | CylindricalEntry
    | UniversalEntry
    | ConstantVelocityEntry
    | PinSlotEntry
    | PlanarEntry
    | RectangularEntry
    | CartesianEntry
    | SphericalEntry
    | GimbalEntry
    | BearingEntry
    | TelescopingEntry
    | FreeEntry
    | BushingEntry,
    Field(discriminator="type"),
]
