"""Shapes with few numbers: boxes, cylinders, spheres, capsules and cones."""

from __future__ import annotations

from typing import final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.fields import Quantity, VectorQuantity, part
from symbody.model.frame import RotationMatrix, Turns
from symbody.model.shapes.shape import CENTRE, COLOR, MATRIX, OPACITY, ROTATE, BodyShape, Color


@final
@part
class Box(BodyShape):
    """A box with its edges along its axes."""

    size: VectorQuantity = VectorQuantity("Edges along x, y and z.", unit="m")
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The edges."""
        return tuple((f"size[{k}]", edge) for k, edge in enumerate(self.size))


@part
class RoundShape(BodyShape):
    """A shape about its z axis, given by a radius and a length."""

    radius: Quantity = Quantity(unit="m")
    length: Quantity = Quantity(unit="m")
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """Radius and length."""
        return (("radius", self.radius), ("length", self.length))


@final
@part
class Cylinder(RoundShape):
    """A cylinder about its z axis."""


@final
@part
class Capsule(RoundShape):
    """A cylinder about its z axis with half a sphere on each end."""

    length: Quantity = Quantity("Length without the caps.", unit="m")


@final
@part
class Cone(RoundShape):
    """A cone that points along its z axis; its centre is half way up the axis."""

    radius: Quantity = Quantity("Radius of its base.", unit="m")
    length: Quantity = Quantity("Height from base to tip.", unit="m")


@final
@part
class Sphere(BodyShape):
    """A sphere."""

    radius: Quantity = Quantity(unit="m")
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The radius."""
        return (("radius", self.radius),)
