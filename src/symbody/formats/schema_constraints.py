"""The constraints of a model file as pydantic classes, called like those of the model with `Entry` behind."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from symbody.formats.schema_types import Angle, Axis, Between, Entry, Expression, Triple

Axes = Annotated[
    list[Axis],
    Field(min_length=2, max_length=2, description="A direction in the start frame and one in the end frame."),
]
Equations = Annotated[
    Expression | list[Expression], Field(description="What vanishes: one formula or several.")
]
Pair = Annotated[list[str], Field(min_length=2, max_length=2)]
Three = Annotated[list[str], Field(min_length=3, max_length=3)]


class ContactEntry(Entry):
    """What every constraint between two frames has."""

    name: str
    between: Between


class CouplingEntry(Entry):
    """What every coupling of coordinates has."""

    name: str
    offset: Angle = Field(default=0, description="What the sum of factors times coordinates equals.")


class DistanceEntry(ContactEntry):
    """Holds two points at a distance."""

    type: Literal["distance"]
    value: Expression = Field(description="The distance in parameters and t [m].")
    rope: bool = Field(default=False, description="Whether the points may come closer.")


class PointOnLineEntry(ContactEntry):
    """Holds a point on a line."""

    type: Literal["point_on_line"]
    axis: Axis = Field(default="x", description="Direction of the line, in the start frame.")


class PointOnPlaneEntry(ContactEntry):
    """Holds a point in a plane."""

    type: Literal["point_on_plane"]
    axis: Axis = Field(default="z", description="Normal of the plane, in the start frame.")


class PointOnCurveEntry(ContactEntry):
    """Holds a point on a curve given by a parameter."""

    type: Literal["point_on_curve"]
    curve: Triple = Field(description="Position in the start frame, in the parameter [m].")
    parameter: str = Field(description="Name of the parameter, which becomes a coordinate.")


class PointOnSurfaceEntry(ContactEntry):
    """Holds a point on a surface."""

    type: Literal["point_on_surface"]
    equations: Equations = Field(description="What vanishes, in x, y, z of the point in the start frame [m].")


class ParallelEntry(ContactEntry):
    """Holds two directions parallel."""

    type: Literal["parallel"]
    axes: Axes = ["z", "z"]


class PerpendicularEntry(ContactEntry):
    """Holds two directions perpendicular."""

    type: Literal["perpendicular"]
    axes: Axes


class AngleEntry(ContactEntry):
    """Holds two directions at an angle."""

    type: Literal["angle"]
    axes: Axes
    value: Angle = Field(description="The angle in parameters and t [rad].")


class KnifeEdgeEntry(ContactEntry):
    """A blade that does not slide sideways."""

    type: Literal["knife_edge"]
    axis: Axis = Field(default="y", description="Normal of the blade, in the end frame.")


class RollingEntry(ContactEntry):
    """A disc or sphere that rolls on a plane without slipping."""

    type: Literal["rolling"]
    radius: Expression = Field(description="[m]")
    normal: Axis = Field(default="z", description="Of the plane, towards the wheel, in the start frame.")
    axis: Axis = Field(default=None, description="Axle of a disc, in the end frame; left out: a sphere.")


class GearEntry(CouplingEntry):
    """Two wheels in mesh: first = ratio second + offset."""

    type: Literal["gear"]
    coupled: Pair = Field(description="The angles of two joints.")
    ratio: Expression = Field(
        description="Turns of the first for one of the second; negative on the outside."
    )


class RackPinionEntry(CouplingEntry):
    """A rack moved by a wheel: displacement = radius angle + offset."""

    type: Literal["rack_pinion"]
    coupled: Pair = Field(description="The displacement of a joint and the angle of another.")
    radius: Expression = Field(description="[m]")


class BeltEntry(CouplingEntry):
    """Two pulleys and a belt: radius1 first = radius2 second + offset."""

    type: Literal["belt"]
    coupled: Pair = Field(description="The angles of two joints.")
    radii: Annotated[list[Expression], Field(min_length=2, max_length=2, description="[m]")]
    crossed: bool = Field(default=False, description="Whether the pulleys turn against each other.")


class DifferentialEntry(CouplingEntry):
    """A differential: 2 carrier = left + right + offset."""

    type: Literal["differential"]
    coupled: Three = Field(description="The angles of carrier, left and right shaft.")


class EquationEntry(Entry):
    """Equations in coordinates, or of first degree in speeds."""

    type: Literal["equation"]
    name: str
    equations: Equations


ConstraintEntry = Annotated[
    DistanceEntry
    | PointOnLineEntry
    | PointOnPlaneEntry
    | PointOnCurveEntry
    | PointOnSurfaceEntry
    | ParallelEntry
    | PerpendicularEntry
    | AngleEntry
    | KnifeEdgeEntry
    | RollingEntry
    | GearEntry
    | RackPinionEntry
    | BeltEntry
    | DifferentialEntry
    | EquationEntry,
    Field(discriminator="type"),
]
