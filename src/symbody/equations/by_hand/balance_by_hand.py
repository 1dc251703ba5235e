"""Newton's and Euler's equations of bodies placed by hand, written out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from symbody.equations.by_hand.mechanism import (
    PlacedBody,
    PlacedForce,
    PlacedLoad,
    PlacedObject,
    PlacedTorque,
)
from symbody.expr.expression import Expr, common_graph, number
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph
from symbody.spatial.matrix import Vector3, matrix3
from symbody.spatial.moving import acceleration, angular_velocity, rate
from symbody.spatial.placed import GROUND_FRAME, PlacedPoint, PlacedVector, vector_between


def newton(graph: Graph, objects: Sequence[PlacedObject], gravity: PlacedVector | None) -> PlacedVector:
    """Return ``sum of m a - F`` over bodies and what acts on them, in ground axes; 0 in every motion [N].

    Forces between two of the bodies cancel; weights are added where there is gravity.
    """
    bodies = _bodies(objects)
    total = _null(graph)
    for body in bodies:
        total = total + acceleration(body.centre) * body.mass
        if gravity is not None:
            total = total + -(gravity * body.mass)
    for load, sign in _signed_loads(objects, bodies):
        if isinstance(load, PlacedForce):
            total = total + load.vector * number(graph, -sign)
    return total


def euler(
    graph: Graph, objects: Sequence[PlacedObject], pole: PlacedPoint, gravity: PlacedVector | None
) -> PlacedVector:
    """Return the moment equation of bodies about a pole, in the axes of the pole's frame [N m].

    ``sum of I alpha + w x I w + (G - pole) x (m a - m g) - (P - pole) x F - T``, 0 in every motion, whatever
    the pole and however it moves: moments are taken of ``m a``, not of momenta.
    """
    bodies = _bodies(objects)
    total = PlacedVector(pole.frame, _null(graph).components)
    for body in bodies:
        needed = acceleration(body.centre) * body.mass
        if gravity is not None:
            needed = needed + -(gravity * body.mass)
        total = total + vector_between(pole, body.centre).cross(needed) + _swirl(graph, body)
    for load, sign in _signed_loads(objects, bodies):
        less = number(graph, -sign)
        if isinstance(load, PlacedForce):
            total = total + vector_between(pole, load.point).cross(load.vector) * less
        else:
            total = total + load.vector * less
    return total


def is_weight(force: PlacedForce, gravity: PlacedVector) -> bool:
    """Return whether a force is ``m g`` of the body it acts on, by fingerprint."""
    weight = gravity * force.on.mass
    apart = (weight + -force.vector).components
    graph, nodes = common_graph((*apart, *weight.components))
    gone = find_zeros(graph, nodes)
    return all(gone[:3]) and not all(gone[3:])


def _swirl(graph: Graph, body: PlacedBody) -> PlacedVector:
    """Return ``I alpha + w x I w`` in the body's axes."""
    w, I = Vector3(angular_velocity(graph, body.centre.frame).components), matrix3(*body.tensor)
    return PlacedVector(body.centre.frame, I @ rate(w) + w.cross(I @ w))


def _bodies(objects: Iterable[PlacedObject]) -> list[PlacedBody]:
    return [item for item in objects if isinstance(item, PlacedBody)]


def _signed_loads(
    objects: Iterable[PlacedObject], bodies: Sequence[PlacedBody]
) -> Iterator[tuple[PlacedLoad, int]]:
    """Return each load with 1 where it acts on a body of the set, -1 where it reacts on one."""
    inside = {id(body) for body in bodies}
    for item in objects:
        if isinstance(item, PlacedForce | PlacedTorque):
            for body, sign in ((item.on, 1), (item.reaction_on, -1)):
                if id(body) in inside:
                    yield item, sign


def _null(graph: Graph) -> PlacedVector:
    zero: Expr = number(graph, 0)
    return PlacedVector(GROUND_FRAME, (zero, zero, zero))
