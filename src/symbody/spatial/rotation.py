"""Rotations as successive steps, so that turns about one axis merge before any matrix is formed.

``R_AB`` takes components in B to components in A (docs/notation.md). A step leads from one frame to
the next: a simple turn, whose axis has the same components in both, Euler parameters, or a matrix.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from symbody.expr.expression import Expr, cos, number, sin
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, MUL, NEG, RATIONAL, SUB
from symbody.spatial.euler_parameters import EulerParameters
from symbody.spatial.matrix import Matrix, Matrix3, Triple, Vector3, identity, matrix3, transpose

Form = dict[int, Fraction]


@dataclass(frozen=True, slots=True)
class AxisRotation:
    """One simple rotation.

    Attributes
    ----------
    axis : (3,) Expr
        Unit vector, the same components before and after the turn.
    angle : Expr
        Angle [rad], right-handed about `axis`.
    """

    axis: Triple
    angle: Expr

    @property
    def inverse(self) -> AxisRotation:
        """The turn back."""
        return AxisRotation(self.axis, -self.angle)

    @property
    def is_identity(self) -> bool:
        """True if the angle is exactly 0."""
        return self.angle.is_zero

    def matrix(self, graph: Graph) -> Matrix3[Expr]:
        """Return ``1 cos + (1 - cos) a a^T + sin a~``."""
        return axis_rotation_matrix(graph, self)


@dataclass(frozen=True, slots=True)
class DirectionCosines:
    """A rotation given by its matrix, end components to start components, taken as orthogonal."""

    cosines: Matrix

    @property
    def inverse(self) -> DirectionCosines:
        """The transposed matrix."""
        return DirectionCosines(transpose(self.cosines))

    @property
    def is_identity(self) -> bool:
        """True if the matrix is exactly the unit matrix."""
        return self.cosines == identity(self.cosines[0][0].graph)

    def matrix(self, graph: Graph) -> Matrix3[Expr]:
        """Return the cosines."""
        return matrix3(*self.cosines)


ElementaryRotation = AxisRotation | EulerParameters | DirectionCosines


@dataclass(frozen=True, slots=True)
class Rotation:
    """Successive body-fixed steps leading from frame A to frame B; none is the identity."""

    turns: tuple[ElementaryRotation, ...] = ()

    def then(self, other: Rotation) -> Rotation:
        """Return this rotation followed by `other`, with neighbours merged until none is left to merge."""
        return compose_steps((*self.turns, *other.turns))

    @property
    def inverse(self) -> Rotation:
        """The rotation back."""
        return Rotation(tuple(step.inverse for step in reversed(self.turns)))


def angle_about(graph: Graph, rotation: Rotation, axis: Triple) -> Expr | None:
    """Return the angle of a rotation that is a turn about an axis, or none at all; None if it is neither."""
    if not rotation.turns:
        return number(graph, 0)
    step = rotation.turns[0]
    if len(rotation.turns) > 1 or not isinstance(step, AxisRotation):
        return None
    if step.axis == axis:
        return step.angle
    return -step.angle if step.axis == -Vector3(axis) else None


def compose_steps(turns: Iterable[ElementaryRotation]) -> Rotation:
    """Return the rotation made of steps, neighbours merged, identities left out."""
    steps: list[ElementaryRotation] = []
    for step in turns:
        if step.is_identity:
            continue
        together = merge_steps(steps[-1], step) if steps else None
        if together is None:
            steps.append(step)
        else:
            steps[-1:] = together
    return Rotation(tuple(steps))


def merge_steps(
    first: ElementaryRotation, second: ElementaryRotation
) -> tuple[ElementaryRotation, ...] | None:
    """Return what two successive steps amount to, no step or one; None if they do not merge.

    Turns about parallel axes add up. Other steps merge only with their inverses.
    """
    if isinstance(first, AxisRotation) and isinstance(second, AxisRotation):
        return _merge_axis_rotations(first, second)
    if isinstance(first, EulerParameters) and isinstance(second, EulerParameters):
        return () if second.undoes(first) else None
    return () if second == first.inverse else None


def rotation_matrix(graph: Graph, rotation: Rotation) -> Matrix3[Expr]:
    """Return ``R_AB``, whose columns are B's axes in A."""
    matrices = [step.matrix(graph) for step in rotation.turns]
    return reduce(lambda a, b: a @ b, matrices) if matrices else identity(graph)


def axis_rotation_matrix(graph: Graph, turn: AxisRotation) -> Matrix3[Expr]:
    """Return ``1 cos + (1 - cos) a a^T + sin a~`` (Euler, Rodrigues)."""
    c, s, one = cos(turn.angle), sin(turn.angle), number(graph, 1)
    x, y, z = turn.axis

    def square(a: Expr) -> Expr:
        return c * (1 - a * a) + a * a

    def product(a: Expr, b: Expr) -> Expr:
        return (one - c) * a * b

    return matrix3(
        (square(x), product(x, y) - z * s, product(x, z) + y * s),
        (product(y, x) + z * s, square(y), product(y, z) - x * s),
        (product(z, x) - y * s, product(z, y) + x * s, square(z)),
    )


def spin(R: Matrix, rate: Matrix) -> Vector3[Expr]:
    """Return the angular velocity in the turning frame's axes, from ``R^T R' = w~``.

    Off the unit sphere of Euler parameters it is ``2 G(q) q'`` times a power of their norm, a smooth
    extension of the angular velocity. The symmetric part is on the diagonal, which is not read.
    """
    x, y, z = transpose(R)
    dx, dy, dz = transpose(rate)
    return Vector3((z.dot(dy), x.dot(dz), y.dot(dx)))


def _merge_axis_rotations(first: AxisRotation, second: AxisRotation) -> tuple[AxisRotation, ...] | None:
    if first.axis == second.axis:
        angle = angle_sum(first.angle, second.angle)
    elif first.axis == -Vector3(second.axis):
        angle = angle_sum(first.angle, -second.angle)
    else:
        return None
    return () if angle.is_zero else (AxisRotation(first.axis, angle),)


def angle_sum(a: Expr, b: Expr) -> Expr:
    """Return ``a + b``, collected if the two have a term in common: ``(a + b) - b`` is ``a``.

    The graph adds two nodes without looking inside them, which is not enough for turns forth and back.
    """
    if a.graph is not b.graph:
        return a + b
    graph = a.graph
    first, second = _linear_form(graph, a.index), _linear_form(graph, b.index)
    if first.keys().isdisjoint(second):
        return a + b  # as it is: longer sums go on sharing the shorter ones
    for node, factor in second.items():
        first[node] = first.get(node, Fraction(0)) + factor
    total = Expr(graph, 0)
    for node, factor in first.items():
        total = total + Expr(graph, node) * factor
    return total


def _linear_form(graph: Graph, node: int) -> Form:
    """Return the terms of a sum with their exact factors, in the order they are written."""
    form: Form = {}
    stack = [(node, Fraction(1))]
    while stack:
        term, factor = stack.pop()
        op, left, right = graph.ops[term], graph.left[term], graph.right[term]
        if op in (ADD, SUB):
            stack.append((right, factor if op == ADD else -factor))
            stack.append((left, factor))
        elif op == NEG:
            stack.append((left, -factor))
        elif op == MUL and graph.ops[left] == RATIONAL:
            stack.append((right, factor * Fraction(graph.constants[graph.left[left]])))
        else:
            form[term] = form.get(term, Fraction(0)) + factor
    return form
