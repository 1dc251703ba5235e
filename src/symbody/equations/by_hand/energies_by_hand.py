"""Energies of bodies placed by hand, and Lagrange's equations written out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symbody.equations.by_hand.mechanism import (
    MechanismByHand,
    PlacedBody,
    PlacedForce,
    PlacedLoad,
)
from symbody.expr.calculus import gradient, time_derivative
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph, Symbol, SymbolKind, copy_nodes
from symbody.expr.rewrite import symbols_of
from symbody.spatial.matrix import Triple, Vector3, matrix3
from symbody.spatial.moving import angular_velocity, rate
from symbody.spatial.placed import PlacedVector


def kinetic_energy(graph: Graph, bodies: Iterable[PlacedBody], natural: bool = False) -> Expr:
    """Return ``sum of (m v^2 + w . I w) / 2`` [J].

    Parameters
    ----------
    natural : bool
        Whether the turning part is ``tr(R' E R'^T) / 2`` with ``E = tr(I)/2 1 - I`` instead. The two agree
        where the columns of R are orthogonal unit vectors; this one has a constant mass matrix in natural
        coordinates (Garcia de Jalon & Bayo 1994, section 4.2).
    """
    total = number(graph, 0)
    for body in bodies:
        v = rate(body.centre.position)
        total = total + body.mass * v.dot(v)
        if natural:
            total = total + _stretching_energy(graph, body)
        else:
            w = Vector3(angular_velocity(graph, body.centre.frame).components)
            total = total + w.dot(matrix3(*body.tensor) @ w)
    return total / 2


def gravitational_energy(graph: Graph, bodies: Iterable[PlacedBody], gravity: PlacedVector | None) -> Expr:
    """Return ``-sum of m g . r``, zero at the origin of ground [J]."""
    total = number(graph, 0)
    if gravity is None:
        return total
    g = gravity.in_ground
    for body in bodies:
        total = total - body.mass * g.dot(body.centre.position)
    return total


def lagrange(mechanism: MechanismByHand, coordinates: Sequence[str], natural: bool = False) -> list[Expr]:
    """Return ``d/dt dT/dq' - dT/dq + dV/dq - Phi_q^T lambda - Q``, one a coordinate, then the constraints.

    A constraint on velocities enters by its derivatives by q'.
    """
    graph = mechanism.graph
    q = [graph.symbol(Symbol(name, SymbolKind.COORDINATE)) for name in coordinates]
    rates = [graph.symbol(Symbol(name, SymbolKind.COORDINATE, 1)) for name in coordinates]
    kinetic = _node_in(graph, kinetic_energy(graph, mechanism.bodies, natural))
    potential = _node_in(graph, gravitational_energy(graph, mechanism.bodies, mechanism.gravity))
    momenta = time_derivative(graph, gradient(graph, kinetic, rates))
    slopes, pulls = gradient(graph, kinetic, q), gradient(graph, potential, q)
    equations = [
        Expr(graph, p) - Expr(graph, t) + Expr(graph, v)
        for p, t, v in zip(momenta, slopes, pulls, strict=True)
    ]
    for force in generalized_forces(graph, mechanism.loads, rates):
        equations = [left - right for left, right in zip(equations, force, strict=True)]
    closing = []
    for constraint in mechanism.constraints:
        for value, name in zip(constraint.values, constraint.multipliers, strict=True):
            node = _node_in(graph, value)
            multiplier = Expr(graph, graph.symbol(Symbol(name, SymbolKind.COORDINATE)))
            slopes = gradient(graph, node, rates if is_on_velocities(graph, node) else q)
            equations = [
                left - Expr(graph, slope) * multiplier for left, slope in zip(equations, slopes, strict=True)
            ]
            closing.append(Expr(graph, node))
    return [*equations, *closing]


def generalized_forces(
    graph: Graph, loads: Iterable[PlacedLoad], rates: Sequence[int]
) -> Iterable[list[Expr]]:
    """Return for each load and each body it acts on its power per unit rate.

    The velocity is that of the body's material at the point, also where the point slides along the body.
    """
    for load in loads:
        for body, sign in ((load.on, 1), (load.reaction_on, -1)):
            if body is None:
                continue
            speed = _material(graph, load, body)
            nodes = [_node_in(graph, x) for x in speed]
            acting = load.vector.in_ground
            columns = [gradient(graph, node, rates) for node in nodes]
            yield [
                acting.dot((Expr(graph, x), Expr(graph, y), Expr(graph, z))) * sign
                for x, y, z in zip(*columns, strict=True)
            ]


def is_on_velocities(graph: Graph, node: int) -> bool:
    """Return whether an expression contains rates of coordinates."""
    reached = (graph.symbols[graph.left[k]] for k in symbols_of(graph, [node]))
    return any(symbol.kind is SymbolKind.COORDINATE and symbol.order for symbol in reached)


def _material(graph: Graph, load: PlacedLoad, body: PlacedBody) -> Triple:
    """Return what a load does work on, in ground: the velocity of a body at a point, or how it turns."""
    frame = body.centre.frame
    w = frame.rotate(angular_velocity(graph, frame).components)
    if not isinstance(load, PlacedForce):
        return w
    arm = load.point.position - body.centre.position
    return rate(body.centre.position) + w.cross(arm)


def _stretching_energy(graph: Graph, body: PlacedBody) -> Expr:
    """Return ``tr(R' E R'^T)``, twice the energy of turning and stretching."""
    R = body.centre.frame.rotation(graph)
    columns = matrix3(*map(rate, R)).T
    half = (body.tensor[0][0] + body.tensor[1][1] + body.tensor[2][2]) / 2
    total = number(graph, 0)
    for i in range(3):
        for j in range(3):
            moment = half - body.tensor[i][i] if i == j else -body.tensor[i][j]
            total = total + moment * columns[i].dot(columns[j])
    return total


def _node_in(graph: Graph, value: Expr) -> int:
    """Return the node of an expression in a graph, copied there if it stands in another."""
    if value.graph is graph:
        return value.index
    return copy_nodes(value.graph, graph, [value.index], graph.copies_of(value.graph))[0]
