"""Shapes of bodies in the model file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from symbody.formats.schema_types import Entry, Expression, Factors, Triple, Turn


class ShapeKeys(Entry):
    """What all shapes have; they are seen, and have no influence on the motion."""

    at: Triple = Field(default=[0, 0, 0], description="Centre [m], in the body's axes.")
    rotate: list[Turn] = Field(default=[], description="Successive turns: axis and angle.")
    matrix: Annotated[list[Triple], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="Rotation matrix instead of turns."
    )
    color: str = Field(default="", description='"#rrggbb", a CSS name, or "" for the colour of the body.')
    opacity: Expression = Field(default=1, description="From 0 to 1.")


class BoxEntry(ShapeKeys):
    """A box."""

    type: Literal["box"]
    size: Triple = Field(description="Edges along x, y and z [m].")


class CylinderEntry(ShapeKeys):
    """A cylinder about z."""

    type: Literal["cylinder"]
    radius: Expression = Field(description="[m]")
    length: Expression = Field(description="[m]")


class CapsuleEntry(ShapeKeys):
    """A cylinder about z with half a sphere on each end."""

    type: Literal["capsule"]
    radius: Expression = Field(description="[m]")
    length: Expression = Field(description="Without the caps [m].")


class ConeEntry(ShapeKeys):
    """A cone about z, to which it points; it stands half way up its axis."""

    type: Literal["cone"]
    radius: Expression = Field(description="Of its base [m].")
    length: Expression = Field(description="From base to tip [m].")


class SphereEntry(ShapeKeys):
    """A sphere."""

    type: Literal["sphere"]
    radius: Expression = Field(description="[m]")


class MeshEntry(ShapeKeys):
    """Triangles of a file: STL, OBJ, glTF or GLB, DAE."""

    type: Literal["mesh"]
    path: str = Field(description="Of the file, from the directory of this one.")
    scale: Factors = Field(default=1, description="Metres for one unit of the file; one number or three.")


ShapeEntry = Annotated[
    BoxEntry | CylinderEntry | SphereEntry | CapsuleEntry | ConeEntry | MeshEntry,
    Field(discriminator="type"),
]
