"""Derivatives of inverse dynamics in closed form for chains of single joints, many columns at once.

The motions of the links come one after the other, outward; how each link moves and what it needs, the forces
of each column, and the products of pairs of columns are the same operations for all links, columns, pairs:
programs. The formulas are those of `composite_body`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import NamedTuple

from symbody.equations.recursive.chains import Chains
from symbody.equations.recursive.composite_body import (
    ColumnForces,
    CompositeBody,
    JointColumn,
    column_forces,
    moving_body,
)
from symbody.equations.recursive.item_programs import flatten, map_items, unflatten
from symbody.equations.recursive.links import LinkInertia, LinkTransform, LinkTwist, LinkWrench
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.spatial.inertia import RigidInertia
from symbody.spatial.matrix import Matrix3, SymmetricTensor, Vector3, identity, matrix3, zero_vector
from symbody.spatial.transform import Transform
from symbody.spatial.twist import Twist

Entries = dict[tuple[int, int], Expr]


@dataclass(frozen=True, slots=True)
class InverseDynamicsPartials:
    """``D = M u' - F`` without loads and rotors, differentiated, and M itself.

    Attributes
    ----------
    speeds : list of int
        Nodes of u: of the base, then chain by chain; rows and columns are numbered so.
    by_rate, by_position : mapping of (row, column) to Expr
        ``dD/du`` and ``dD/dq``, the latter but for the columns of the base; what is missing is 0.
    mass : mapping of (row, column) to Expr
        M, at and left of the diagonal.
    """

    speeds: list[int]
    by_rate: Entries = field(default_factory=dict)
    by_position: Entries = field(default_factory=dict)
    mass: Entries = field(default_factory=dict)

    def add_shared_speeds(self) -> InverseDynamicsPartials:
        """Return one row and column for each speed, where coupled joints share it."""
        speeds = list(dict.fromkeys(self.speeds))
        if len(speeds) == len(self.speeds):
            return self
        place = [speeds.index(speed) for speed in self.speeds]
        by_rate, by_position, mass = Entries(), Entries(), Entries()
        for source, target in ((self.by_rate, by_rate), (self.by_position, by_position)):
            for (i, j), entry in source.items():
                _add(target, (place[i], place[j]), entry)
        for (i, j), entry in self.mass.items():
            a, b = max(place[i], place[j]), min(place[i], place[j])
            _add(mass, (a, b), entry * 2 if a == b and i != j else entry)
        return InverseDynamicsPartials(speeds, by_rate, by_position, mass)


def _add(entries: Entries, place: tuple[int, int], entry: Expr) -> None:
    entries[place] = entries[place] + entry if place in entries else entry


class _LinkState(NamedTuple):
    """A link in the common frame: where it is, how it moves, its column and the column's rate."""

    X: LinkTransform
    velocity: LinkTwist
    acceleration: LinkTwist
    S: LinkTwist
    rate: LinkTwist
    inertia: LinkInertia


def inverse_dynamics_partials(
    graph: Graph, chains: Chains, gravity: Vector3[Expr], accelerations: Mapping[int, Expr]
) -> InverseDynamicsPartials:
    """Return the derivatives of inverse dynamics, at accelerations by the node of each speed.

    Parameters
    ----------
    gravity : (3,) Expr
        In ground axes.
    """
    links, tree = chains.links, chains.tree
    velocity, acceleration = _base_motion(graph, chains, gravity, accelerations)
    states = _link_states(graph, chains, velocity, acceleration, accelerations)
    columns: dict[int, JointColumn] = {}
    bodies: dict[int, CompositeBody] = {}
    results = map_items(graph, (), list(states.values()), _moving_link)
    for (k, state), (second, moments, first, momentum, G, f) in zip(states.items(), results, strict=True):
        columns[k] = JointColumn(state.S, state.rate, second)
        bodies[k] = CompositeBody(RigidInertia(moments, first, state.inertia.mass), momentum, G, f)
    base = None
    if chains.base:
        here = Transform((), zero_vector(graph))
        base = moving_body(tree.links[0].inertia, here, velocity, acceleration)
    for k in reversed(links):
        parent = tree.links[k].parent
        if parent in bodies:
            bodies[parent] = bodies[parent] + bodies[k]
        elif base is not None:
            base = base + bodies[k]
    assembly = _Assembly.start(graph, chains, columns)
    forces = assembly.column_forces(bodies, velocity)
    assembly.place_pairs(forces)
    if base is not None:
        assembly.place_base(base, velocity, forces)
    return assembly.partials.add_shared_speeds()


def _base_motion(
    graph: Graph, chains: Chains, gravity: Vector3[Expr], accelerations: Mapping[int, Expr]
) -> tuple[LinkTwist, LinkTwist]:
    """Return velocity and acceleration of the frame: ground, or the free body, in its own axes."""
    zero = zero_vector(graph)
    velocity = Twist(zero, zero)
    if not chains.base:
        return velocity, Twist(-gravity, zero)
    free = chains.tree.links[0]
    acceleration = Twist(-free.transform.to_child(gravity), zero)
    for column in free.motion.columns:
        velocity = velocity + column.twist * Expr(graph, column.speed)
        acceleration = acceleration + column.twist * accelerations[column.speed]
    return velocity, acceleration


def _link_states(
    graph: Graph,
    chains: Chains,
    velocity: LinkTwist,
    acceleration: LinkTwist,
    accelerations: Mapping[int, Expr],
) -> dict[int, _LinkState]:
    """Return ``v = v_p + S u``, ``S' = v_p x S``, ``a = a_p + S u' + S' u`` of all links, outward."""
    states: dict[int, _LinkState] = {}
    axes, origin = identity(graph), zero_vector(graph)
    for k in chains.links:
        link = chains.tree.links[k]
        (column,) = link.motion.columns
        v, a, X = velocity, acceleration, Transform((axes,), origin)
        if link.parent in states:
            X, v, a = states[link.parent][:3]
        position = X.point_to_parent(link.transform.position)
        x, y, z = (link.transform.to_child(row) for row in X.matrix)
        X = Transform((matrix3(x, y, z),), position)
        turn = X.to_parent(column.twist.angular)
        S = Twist(X.to_parent(column.twist.linear) + position.cross(turn), turn)
        u, rate = Expr(graph, column.speed), v.cross(S)
        a = a + S * accelerations[column.speed] + rate * u
        states[k] = _LinkState(X, v + S * u, a, S, rate, link.inertia)
    return states


def _moving_link(
    _: tuple[()], state: _LinkState
) -> tuple[LinkTwist, SymmetricTensor[Expr], Vector3[Expr], Vector3[Expr], Matrix3[Expr], LinkWrench]:
    """Return S" of a link's column, and the link as a composite body of its own, but for the mass."""
    body = moving_body(state.inertia, state.X, state.velocity, state.acceleration)
    second = state.acceleration.cross(state.S) + state.velocity.cross(state.rate)
    return (second, *body.inertia[:2], *body[1:])


@dataclass(frozen=True, slots=True)
class _Assembly:
    """Puts the products of pairs of columns into their rows and columns.

    Attributes
    ----------
    base : list of Twist
        Columns of the free body.
    place : mapping of link to int
        Row of each link's speed.
    """

    graph: Graph
    chains: Chains
    columns: Mapping[int, JointColumn]
    base: list[LinkTwist]
    place: Mapping[int, int]
    partials: InverseDynamicsPartials

    @classmethod
    def start(cls, graph: Graph, chains: Chains, columns: Mapping[int, JointColumn]) -> _Assembly:
        """Return the assembly without entries."""
        links = chains.tree.links
        free = links[0].motion.columns if chains.base else ()
        place = {k: len(free) + row for row, k in enumerate(chains.links)}
        speeds = [column.speed for column in free]
        speeds += [links[k].motion.columns[0].speed for k in chains.links]
        partials = InverseDynamicsPartials(speeds)
        return cls(graph, chains, columns, [column.twist for column in free], place, partials)

    def column_forces(
        self, bodies: Mapping[int, CompositeBody], velocity: LinkTwist
    ) -> dict[int, ColumnForces]:
        """Return the forces of all columns; those that columns of the base cost them are placed."""
        links, base = self.chains.links, self.base

        def compute(
            frame: tuple[LinkTwist, ...], item: tuple[JointColumn, CompositeBody]
        ) -> tuple[tuple[Expr, ...], ColumnForces]:
            column, body = item
            forces, costs = column_forces(body, column), []
            for constant in base if frame else ():
                S = _copy(constant, column.S.linear[0].graph)
                rate = frame[0].cross(S)
                costs.append(S.angular.dot(forces.coriolis) + rate.dot(forces.inertia))
            return tuple(costs), forces

        items = [(self.columns[k], bodies[k]) for k in links]
        results = map_items(self.graph, (velocity,) if base else (), items, compute)
        for k, (costs, _) in zip(links, results, strict=True):
            for b, cost in enumerate(costs):
                self.partials.by_rate[self.place[k], b] = cost
        return {k: forces for k, (_, forces) in zip(links, results, strict=True)}

    def place_pairs(self, forces: Mapping[int, ColumnForces]) -> None:
        """Place the products of columns that carry each other, segment by segment."""
        carriers = {k: self.chains.carriers(k) for k in self.chains.links}
        segments = self.chains.segments
        for n, segment in enumerate(segments):
            for inward in self.chains.inward(n):
                rows = segments[inward].links
                self._place_inward_rows(rows, segment.links, forces, carriers)
                self._place_outward_rows(segment.links, rows, forces, carriers)

    def _place_inward_rows(
        self,
        rows: Sequence[int],
        columns: Sequence[int],
        forces: Mapping[int, ColumnForces],
        carriers: Mapping[int, Set[int]],
    ) -> None:
        """Place dD_i/dq_j and dD_i/du_j for i inward of j."""

        def compute(
            inward: tuple[LinkTwist, ...], outward: tuple[LinkWrench, LinkWrench]
        ) -> tuple[tuple[Expr, ...], ...]:
            return tuple(tuple(S.dot(wrench) for S in inward) for wrench in outward)

        shared = tuple(self.columns[i].S for i in rows)
        results = map_items(self.graph, shared, [forces[j][:2] for j in columns], compute)
        targets = (self.partials.by_position, self.partials.by_rate)
        for j, values in zip(columns, results, strict=True):
            for entries, entries_of_j in zip(targets, values, strict=True):
                for i, entry in zip(rows, entries_of_j, strict=True):
                    if i != j and i in carriers[j]:
                        entries[self.place[i], self.place[j]] = entry

    def _place_outward_rows(
        self,
        rows: Sequence[int],
        columns: Sequence[int],
        forces: Mapping[int, ColumnForces],
        carriers: Mapping[int, Set[int]],
    ) -> None:
        """Place dD_j/dq_i, dD_j/du_i and M_ji for j at or outward of i."""

        def compute(
            outward: tuple[tuple[LinkWrench, Vector3[Expr]], ...], column: JointColumn
        ) -> tuple[tuple[Expr, ...], ...]:
            S, rate, second = column
            return (
                tuple(rate.angular.dot(b) + second.dot(inertia) for inertia, b in outward),
                tuple(S.angular.dot(b) + (rate * 2).dot(inertia) for inertia, b in outward),
                tuple(S.dot(inertia) for inertia, _ in outward),
            )

        shared = tuple(forces[j][2:] for j in rows)
        results = map_items(self.graph, shared, [self.columns[i] for i in columns], compute)
        targets = (self.partials.by_position, self.partials.by_rate, self.partials.mass)
        for i, values in zip(columns, results, strict=True):
            for entries, entries_of_i in zip(targets, values, strict=True):
                for j, entry in zip(rows, entries_of_i, strict=True):
                    if i in carriers[j]:
                        entries[self.place[j], self.place[i]] = entry

    def place_base(
        self, body: CompositeBody, velocity: LinkTwist, forces: Mapping[int, ColumnForces]
    ) -> None:
        """Place the products with columns of the base, whose rates are ``S'/2``: v is their own motion."""
        partials = self.partials
        half, zero = number(self.graph, 1) / 2, zero_vector(self.graph)
        for b, S in enumerate(self.base):
            forces_of_base = column_forces(body, JointColumn(S, velocity.cross(S) * half, Twist(zero, zero)))
            for c, other in enumerate(self.base):
                partials.by_rate[c, b] = other.dot(forces_of_base.by_rate)
                if c >= b:
                    partials.mass[c, b] = other.dot(forces_of_base.inertia)
            for k, row in self.place.items():
                partials.by_position[b, row] = S.dot(forces[k].by_position)
                partials.by_rate[b, row] = S.dot(forces[k].by_rate)
                partials.mass[row, b] = S.dot(forces[k].inertia)


def _copy(twist: LinkTwist, graph: Graph) -> LinkTwist:
    """Return a twist of numbers in another graph."""
    return unflatten(twist, (number(graph, x.number or 0) for x in flatten(twist)))
