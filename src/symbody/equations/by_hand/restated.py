"""A mechanism by hand in another graph, with symbols replaced: functions of time become inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.equations.by_hand.mechanism import (
    MechanismByHand,
    PlacedBody,
    PlacedConstraint,
    PlacedForce,
    PlacedLoad,
    PlacedTorque,
)
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol, copy_nodes
from symbody.expr.rewrite import substitute, symbols_of
from symbody.spatial.matrix import Matrix, Triple
from symbody.spatial.placed import PlacedFrame, PlacedPoint, PlacedStep, PlacedVector, Shift
from symbody.spatial.rotation import AxisRotation, DirectionCosines


@dataclass(frozen=True, slots=True)
class Restatement:
    """Copies expressions, and all that is made of them, to a graph.

    Attributes
    ----------
    replaced : mapping of Symbol to Symbol or int
        What symbols become; all others stay.
    """

    graph: Graph
    replaced: Mapping[Symbol, Symbol | int]

    def mechanism(self, given: MechanismByHand) -> MechanismByHand:
        """Return the same mechanism, bodies without name called body1, body2."""
        bodies = {
            id(body): self._body(body, body.name or f"body{k}")
            for k, body in enumerate(given.bodies, start=1)
        }
        return MechanismByHand(
            tuple(bodies.values()),
            tuple(self._load(load, bodies) for load in given.loads),
            tuple(
                PlacedConstraint(tuple(map(self.value, item.values)), item.multipliers)
                for item in given.constraints
            ),
            None if given.gravity is None else self._vector(given.gravity),
        )

    def value(self, x: Expr) -> Expr:
        """Return one expression."""
        source = x.graph
        places = {source.symbols[source.left[node]]: node for node in symbols_of(source, [x.index])}
        swapped = {node: self.replaced[symbol] for symbol, node in places.items() if symbol in self.replaced}
        nodes = {
            node: source.symbol(new) if isinstance(new, Symbol) else source.constant(new)
            for node, new in swapped.items()
        }
        (root,) = substitute(source, [x.index], nodes) if nodes else [x.index]
        if source is self.graph:
            return Expr(source, root)
        return Expr(self.graph, copy_nodes(source, self.graph, [root], self.graph.copies_of(source))[0])

    def _triple(self, x: Triple) -> Triple:
        return (self.value(x[0]), self.value(x[1]), self.value(x[2]))

    def _matrix(self, a: Matrix) -> Matrix:
        return (self._triple(a[0]), self._triple(a[1]), self._triple(a[2]))

    def _step(self, step: PlacedStep) -> PlacedStep:
        if isinstance(step, AxisRotation):
            return AxisRotation(self._triple(step.axis), self.value(step.angle))
        if isinstance(step, Shift):
            return Shift(self._triple(step.by))
        return DirectionCosines(self._matrix(step.cosines))

    def _frame(self, frame: PlacedFrame) -> PlacedFrame:
        return PlacedFrame(tuple(map(self._step, frame.steps)))

    def _vector(self, vector: PlacedVector) -> PlacedVector:
        return PlacedVector(self._frame(vector.frame), self._triple(vector.components))

    def _point(self, point: PlacedPoint) -> PlacedPoint:
        return PlacedPoint(self._frame(point.frame), self._triple(point.coordinates))

    def _body(self, body: PlacedBody, name: str) -> PlacedBody:
        return PlacedBody(name, self._point(body.centre), self.value(body.mass), self._matrix(body.tensor))

    def _load(self, load: PlacedLoad, bodies: Mapping[int, PlacedBody]) -> PlacedLoad:
        on = bodies[id(load.on)]
        back = None if load.reaction_on is None else bodies[id(load.reaction_on)]
        vector = self._vector(load.vector)
        if isinstance(load, PlacedForce):
            return PlacedForce(vector, self._point(load.point), on, back)
        return PlacedTorque(vector, on, back)
