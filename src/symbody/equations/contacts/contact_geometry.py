"""Where two shapes touch: gap, normal and point of contact, and the velocities there.

This knows nothing of forces: a law makes them of the gap and of these velocities.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Final, NamedTuple

from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr import canonical
from symbody.expr.expression import Expr, number, sqrt
from symbody.expr.language.formula import Formula
from symbody.expr.opcodes import LT
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import ZERO, Vector, components, cross, dot, vector

# Squares of lengths [m^2] and of sines below which there is no direction: a root is then that of 1.
_TINY: Final = 1e-24


class PlacedShape(NamedTuple):
    """A shape of a contact in its frame.

    Attributes
    ----------
    frame : str
        Whose origin and axes are those of the shape.
    sizes : tuple of Expr
        In the order of its kind; none of a shape that is given by a formula.
    formula : Formula or None
        Of such a shape.
    """

    word: str
    frame: str
    sizes: tuple[Expr, ...]
    formula: Formula | None = None

    @property
    def radius(self) -> Expr | int:
        """Its first size; 0 of a point."""
        return self.sizes[0] if self.sizes else 0


class Touch(NamedTuple):
    """One point in which two shapes touch.

    Attributes
    ----------
    gap : Expr
        Distance of the surfaces along the normal, negative where they overlap [m].
    point : Vector
        From the origin of the first frame to the middle between the surfaces.
    """

    gap: Expr
    point: Vector


class ContactGeometry(NamedTuple):
    """The points in which two shapes touch, and the axes of the contact.

    Attributes
    ----------
    normal, forward : Vector
        Unit vectors z, from the first shape to the second, and x, across it.
    touches : tuple of Touch
        The points; of one gap each.
    home : str
        The frame of the axes of one of the shapes, in which slip is resolved.
    """

    normal: Vector
    forward: Vector
    touches: tuple[Touch, ...]
    home: str

    def axes(self, kinematics: Kinematics) -> tuple[Vector, Vector, Vector]:
        """Return the unit vectors x, y and z."""
        return self.forward, cross(kinematics.tree, self.normal, self.forward), self.normal


class RelativeVelocity(NamedTuple):
    """The velocity of the body at end relative to that at start, in a point of contact.

    Attributes
    ----------
    normal : Expr
        Along the normal: the rate of the gap [m/s].
    slip : Vector
        Across it, in the axes of one of the shapes [m/s].
    """

    normal: Expr
    slip: Vector


@dataclass(frozen=True, slots=True)
class ShapePair:
    """Two shapes and the kinematics of their frames, with the vectors that formulas of pairs consist of."""

    names: Names
    kinematics: Kinematics
    first: PlacedShape
    second: PlacedShape
    where: str

    @property
    def arm(self) -> Vector:
        """From the origin of the first frame to that of the second."""
        return self.kinematics.position(self.first.frame, self.second.frame)

    def axis(self, shape: PlacedShape, letter: str) -> Vector:
        """Return a unit vector of a shape's frame."""
        graph = self.kinematics.graph
        x, y, z = (number(graph, int(letter == each)) for each in "xyz")
        return vector(self.home(shape), (x, y, z))

    def home(self, shape: PlacedShape) -> str:
        """Return the frame of a shape's axes."""
        return self.kinematics.tree.orientation_frame(shape.frame)

    def dot(self, a: Vector, b: Vector) -> Expr:
        """Return the scalar product."""
        return dot(self.kinematics.tree, a, b)

    def cross(self, a: Vector, b: Vector) -> Vector:
        """Return the vector product."""
        return cross(self.kinematics.tree, a, b)

    def components(self, a: Vector, shape: PlacedShape) -> Triple:
        """Return the components of a vector in the axes of a shape."""
        return components(self.kinematics.tree, a, self.home(shape))

    def ball(self, normal: Vector, centre: Vector, radius: Expr | int, distance: Expr) -> Touch:
        """Return where a sphere of the second body touches a surface.

        Parameters
        ----------
        centre : Vector
            From the origin of the first frame.
        distance : Expr
            Of the centre from the surface, along the normal.
        """
        gap = distance - radius
        return Touch(gap, centre - normal * (distance - gap / 2))


def choose(condition: Expr, then: Expr, otherwise: Expr) -> Expr:
    """Return one of two values by a condition."""
    return Expr(
        condition.graph, canonical.select(condition.graph, condition.index, then.index, otherwise.index)
    )


def is_less(a: Expr, b: Expr) -> Expr:
    """Return the condition that one value is below another."""
    return a.apply(LT, b)


def unit_vector(pair: ShapePair, a: Vector, otherwise: Vector) -> tuple[Vector, Expr]:
    """Return the direction and the length of a vector; at length 0 another direction, and slopes of 0."""
    graph = pair.kinematics.graph
    square = pair.dot(a, a)
    if square.is_zero:
        return otherwise, square
    is_zero = is_less(square, number(graph, _TINY))
    length = sqrt(choose(is_zero, number(graph, 1), square))
    zero, one = number(graph, 0), number(graph, 1)
    direction = a * choose(is_zero, zero, 1 / length) + otherwise * choose(is_zero, one, zero)
    return direction, choose(is_zero, zero, length)


def perpendicular(pair: ShapePair, normal: Vector, first: str = "x", second: str = "y") -> Vector:
    """Return a unit vector across a unit vector: an axis of the first frame without its part along it.

    Where the two are within 26 degrees it is another axis, so that it is finite for each normal. No vector is
    continuous for all of them; this one is on each face of a box, and on both sides of it.
    """
    graph = pair.kinematics.graph
    axes = pair.axis(pair.first, first), pair.axis(pair.first, second)
    cosines = [pair.dot(axis, normal) for axis in axes]
    is_along = is_less(number(graph, Fraction(4, 5)), cosines[0] * cosines[0])
    zero, one = number(graph, 0), number(graph, 1)
    axis = axes[0] * choose(is_along, zero, one) + axes[1] * choose(is_along, one, zero)
    cosine = choose(is_along, cosines[1], cosines[0])
    return (axis - normal * cosine) * (1 / sqrt(1 - choose(is_along, cosines[1] ** 2, cosines[0] ** 2)))


def relative_velocity(
    kinematics: Kinematics, frames: tuple[str, str], geometry: ContactGeometry, touch: Touch
) -> RelativeVelocity:
    """Return the velocity of the body at end relative to that at start in a point of contact.

    Parameters
    ----------
    frames : (frame, frame)
        Of the shapes at start and end.
    """
    tree = kinematics.tree
    total = ZERO
    for sign, frame in zip((-1, 1), frames, strict=True):
        reach = touch.point - kinematics.position(frames[0], frame)
        spin = cross(tree, kinematics.angular_velocities[frame].value, reach)
        total = total + (kinematics.velocities[frame].value + spin) * sign
    rate = dot(tree, geometry.normal, total)
    slip = components(tree, total - geometry.normal * rate, geometry.home)
    return RelativeVelocity(rate, vector(geometry.home, slip))


def least_gap(touches: tuple[Touch, ...]) -> Expr:
    """Return the least of the gaps."""
    least = touches[0].gap
    for touch in touches[1:]:
        least = choose(is_less(touch.gap, least), touch.gap, least)
    return least


def at_least_gap(touches: tuple[Touch, ...], values: tuple[Expr, ...]) -> Expr:
    """Return the value, of one for each point, where the gap is least; of equal ones the first."""
    least, value = touches[0].gap, values[0]
    for touch, other in zip(touches[1:], values[1:], strict=True):
        is_lower = is_less(touch.gap, least)
        least, value = choose(is_lower, touch.gap, least), choose(is_lower, other, value)
    return value
