"""Frames placed by hand, and points and vectors in them: the algebra of 4 x 4 homogeneous matrices.

A frame is a chain of steps from ground, each a turn, a shift or a matrix, whose entries are any expressions
of coordinates and time. It is kept as a chain, not as one matrix: what two frames have in common cancels
before anything is multiplied, and turns about one axis add up.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.spatial.matrix import Matrix3, Triple, Vector3, identity, zero_vector
from symbody.spatial.rotation import AxisRotation, DirectionCosines, compose_steps, rotation_matrix


@dataclass(frozen=True, slots=True)
class Shift:
    """One displacement, by components in the axes before and after it, which are the same [m]."""

    by: Triple

    @property
    def inverse(self) -> Shift:
        """The displacement back."""
        return Shift(-Vector3(self.by))


PlacedStep = AxisRotation | DirectionCosines | Shift


@dataclass(frozen=True, slots=True)
class PlacedFrame:
    """A frame by the steps that lead to it from ground; no steps is ground itself."""

    steps: tuple[PlacedStep, ...] = ()

    def __mul__(self, other: PlacedFrame) -> PlacedFrame:
        return PlacedFrame((*self.steps, *other.steps))

    @property
    def inverse(self) -> PlacedFrame:
        """The frame that leads back: ``F F^-1`` is ground."""
        return PlacedFrame(tuple(step.inverse for step in reversed(self.steps)))

    def relative_to(self, other: PlacedFrame) -> PlacedFrame:
        """Return ``other^-1 self``; the steps that both begin with cancel."""
        common = 0
        for mine, its in zip(self.steps, other.steps, strict=False):
            if mine != its:
                break
            common += 1
        return PlacedFrame(other.steps[common:]).inverse * PlacedFrame(self.steps[common:])

    @property
    def expressions(self) -> Iterator[Expr]:
        """What the steps are written in."""
        for step in self.steps:
            if isinstance(step, AxisRotation):
                yield from (*step.axis, step.angle)
            elif isinstance(step, Shift):
                yield from step.by
            else:
                yield from (entry for row in step.cosines for entry in row)

    def rotation(self, graph: Graph) -> Matrix3[Expr]:
        """Return R: components in this frame to components in ground."""
        return rotation_matrix(graph, compose_steps(_rotations(self.steps)))

    def origin(self, graph: Graph) -> Vector3[Expr]:
        """Return the position of the origin, in ground axes [m]."""
        return self.place(zero_vector(graph))

    def place(self, point: Triple) -> Vector3[Expr]:
        """Return the ground coordinates of a point given by its coordinates in this frame."""
        graph, x = point[0].graph, Vector3(point)
        for k in range(len(self.steps) - 1, -1, -1):
            step = self.steps[k]
            if isinstance(step, Shift):
                x = x + step.by
            elif k == 0 or isinstance(self.steps[k - 1], Shift):
                # A run of turns is one matrix, so that parallel ones add up first.
                run = compose_steps(_rotations(_rotations_to_next_shift(self.steps, k)))
                x = rotation_matrix(graph, run) @ x
        return x

    def rotate(self, x: Triple) -> Vector3[Expr]:
        """Return the ground components of the vector with components `x` in this frame."""
        return Vector3(x) if not self.steps else self.rotation(x[0].graph) @ x


GROUND_FRAME = PlacedFrame()


@dataclass(frozen=True, slots=True)
class PlacedPoint:
    """A point by its coordinates in a frame [m]."""

    frame: PlacedFrame
    coordinates: Triple

    def express_in(self, frame: PlacedFrame) -> PlacedPoint:
        """Return the same point by its coordinates in another frame."""
        return PlacedPoint(frame, self.frame.relative_to(frame).place(self.coordinates))

    @property
    def position(self) -> Vector3[Expr]:
        """The coordinates in ground."""
        return self.frame.place(self.coordinates)


@dataclass(frozen=True, slots=True)
class PlacedVector:
    """A vector by its components in a frame."""

    frame: PlacedFrame
    components: Triple

    def express_in(self, frame: PlacedFrame) -> PlacedVector:
        """Return the same vector by its components in another frame."""
        return PlacedVector(frame, self.frame.relative_to(frame).rotate(self.components))

    def __add__(self, other: PlacedVector) -> PlacedVector:
        return PlacedVector(self.frame, self._own + other.express_in(self.frame).components)

    def __neg__(self) -> PlacedVector:
        return PlacedVector(self.frame, -self._own)

    def __mul__(self, factor: Expr) -> PlacedVector:
        return PlacedVector(self.frame, self._own * factor)

    def dot(self, other: PlacedVector) -> Expr:
        """Return the scalar product."""
        return self._own.dot(other.express_in(self.frame).components)

    def cross(self, other: PlacedVector) -> PlacedVector:
        """Return the vector product, in the frame of the first factor."""
        return PlacedVector(self.frame, self._own.cross(other.express_in(self.frame).components))

    @property
    def _own(self) -> Vector3[Expr]:
        return Vector3(self.components)

    @property
    def in_ground(self) -> Vector3[Expr]:
        """The components in ground."""
        return self.frame.rotate(self.components)


def vector_between(start: PlacedPoint, end: PlacedPoint) -> PlacedVector:
    """Return the vector from one point to another, in the frame of the first."""
    there = Vector3(end.express_in(start.frame).coordinates)
    return PlacedVector(start.frame, there - start.coordinates)


def homogeneous(frame: PlacedFrame, graph: Graph) -> tuple[tuple[Expr, ...], ...]:
    """Return the frame as a 4 x 4 matrix, row by row: coordinates in the frame to coordinates in ground."""
    zero, one = number(graph, 0), number(graph, 1)
    rows = frame.rotation(graph) if frame.steps else identity(graph)
    placed = tuple((*row, x) for row, x in zip(rows, frame.origin(graph), strict=True))
    return (*placed, (zero, zero, zero, one))


def _rotations(steps: Iterable[PlacedStep]) -> list[AxisRotation | DirectionCosines]:
    return [step for step in steps if not isinstance(step, Shift)]


def _rotations_to_next_shift(steps: Sequence[PlacedStep], start: int) -> Sequence[PlacedStep]:
    """Return the turns from `start` up to the next shift."""
    end = start
    while end < len(steps) and not isinstance(steps[end], Shift):
        end += 1
    return steps[start:end]
