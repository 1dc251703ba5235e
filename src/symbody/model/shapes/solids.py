"""Shapes with few numbers: boxes, cylinders, spheres, capsules and cones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

from symbody.arguments import checked_arguments
from symbody.expr.language.formula import Formula
from symbody.model.door import Door, Value
from symbody.model.shapes.shape import BodyShape, Rows, Turns, set_shape
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Box(BodyShape):
    """A box with its edges along its axes.

    Parameters
    ----------
    size : (3,) number or formula
        Edges along x, y and z [m].
    at : (3,) number or formula
        Its centre [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """

    size: Triple

    @checked_arguments
    def __init__(
        self,
        size: Iterable[Value],
        at: Iterable[Value] = (0, 0, 0),
        rotate: Turns = (),
        matrix: Rows | None = None,
        color: str = "",
        opacity: Value = 1,
    ) -> None:
        sizes = {"size": (Door.triple, size)}
        set_shape(self, sizes, at, rotate, matrix, color, opacity)

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The edges."""
        return tuple((f"size[{k}]", edge) for k, edge in enumerate(self.size))


@dataclass(frozen=True, slots=True, init=False)
class RoundShape(BodyShape):
    """A shape about its z axis, given by a radius and a length [m]."""

    radius: Formula
    length: Formula

    @checked_arguments
    def __init__(
        self,
        radius: Value,
        length: Value,
        at: Iterable[Value] = (0, 0, 0),
        rotate: Turns = (),
        matrix: Rows | None = None,
        color: str = "",
        opacity: Value = 1,
    ) -> None:
        sizes = {"radius": (Door.formula, radius), "length": (Door.formula, length)}
        set_shape(self, sizes, at, rotate, matrix, color, opacity)

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """Radius and length."""
        return (("radius", self.radius), ("length", self.length))


@final
@dataclass(frozen=True, slots=True, init=False)
class Cylinder(RoundShape):
    """A cylinder about its z axis.

    Parameters
    ----------
    radius, length : number or formula
        [m]
    at : (3,) number or formula
        Its centre [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """


@final
@dataclass(frozen=True, slots=True, init=False)
class Capsule(RoundShape):
    """A cylinder about its z axis with half a sphere on each end.

    Parameters
    ----------
    radius, length : number or formula
        The length is that of the cylinder, without its caps [m].
    at : (3,) number or formula
        Its centre [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """


@final
@dataclass(frozen=True, slots=True, init=False)
class Cone(RoundShape):
    """A cone about its z axis, to which it points.

    Parameters
    ----------
    radius, length : number or formula
        Of its base, and from base to tip [m].
    at : (3,) number or formula
        The point half way up its axis [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """


@final
@dataclass(frozen=True, slots=True, init=False)
class Sphere(BodyShape):
    """A sphere.

    Parameters
    ----------
    radius : number or formula
        [m]
    at : (3,) number or formula
        Its centre [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """

    radius: Formula

    @checked_arguments
    def __init__(
        self,
        radius: Value,
        at: Iterable[Value] = (0, 0, 0),
        rotate: Turns = (),
        matrix: Rows | None = None,
        color: str = "",
        opacity: Value = 1,
    ) -> None:
        sizes = {"radius": (Door.formula, radius)}
        set_shape(self, sizes, at, rotate, matrix, color, opacity)

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The radius."""
        return (("radius", self.radius),)
