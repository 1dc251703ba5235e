"""Derivatives of inverse dynamics in closed form for chains of single joints, many columns at once.

The motions of the links come one after the other, outward; what each link is and needs, what each column
costs, and the products of pairs of columns are the same operations for all links, columns, pairs: programs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symbody.equations.recursive.chains import Chains
from symbody.equations.recursive.links import Link
from symbody.equations.recursive.pseudo_inertia import added
from symbody.equations.recursive.slope_programs import (
    Carried,
    ColumnForces,
    Motion,
    carried_from,
    column,
    column_forces,
    column_numbers,
    forces_from,
    forces_numbers,
    inner_columns,
    link,
    link_numbers,
    link_program,
    motion_from,
    outer_columns,
)
from symbody.equations.recursive.turned import to_child
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.expr.program import mapped
from symbody.vectors.matrix import Matrix, Triple, apply_matrix, identity, inner, opposite, outer

Entries = dict[tuple[int, int], Expr]


@dataclass(frozen=True, slots=True)
class ClosedSlopes:
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
    by_rate: Entries
    by_position: Entries
    mass: Entries


class _Placed(NamedTuple):
    """A link in the frame: where it is, how it moves, and its column with its rate."""

    axes: Matrix
    at: Triple
    motion: Motion
    acceleration: Motion
    s: Motion
    rate: Motion


def closed_slopes(
    graph: Graph, chains: Chains, gravity: Triple, accelerations: Mapping[int, Expr]
) -> ClosedSlopes:
    """Return the derivatives of inverse dynamics, at accelerations by the node of each speed.

    Parameters
    ----------
    gravity : (3,) Expr
        In ground axes.
    """
    links, tree = chains.links, chains.tree
    zero = number(graph, 0)
    still = (zero, zero, zero)
    base = _base(graph, chains, gravity, accelerations)
    placed = _placed(chains, base, accelerations)
    columns = list(
        zip(
            *(link_numbers(p.axes, p.at, p[2:], tree.links[k].inertia) for k, p in placed.items()),
            strict=True,
        )
    )
    results = list(zip(*mapped(graph, [], columns, link_program), strict=True))
    own = {
        k: carried_from(tree.links[k].inertia.mass, found) for k, found in zip(links, results, strict=True)
    }
    carried = {k: part for k, (_, part) in own.items()}
    whole = (
        link(base.axes, still, base.motion, base.acceleration, tree.links[0].inertia) if chains.base else None
    )
    for k in reversed(links):
        parent = tree.links[k].parent
        if parent in carried:
            carried[parent] = carried[parent].plus(carried[k])
        elif whole is not None:
            whole = whole.plus(carried[k])
    return _Assembly(graph, chains, placed, own, carried, base.motion, whole).found()


def _base(graph: Graph, chains: Chains, gravity: Triple, accelerations: Mapping[int, Expr]) -> _Placed:
    """Return the frame: ground, or the free body, in its own axes."""
    zero = number(graph, 0)
    still = Motion((zero, zero, zero), (zero, zero, zero))
    motion = still
    acceleration = Motion(still.w, opposite(gravity))
    if chains.base:
        free = chains.tree.links[0]
        acceleration = Motion(still.w, opposite(to_child(free.steps, gravity)))
        for entry in free.motion.columns:
            s = Motion(entry.turn, entry.slide)
            motion = motion.plus(s.times(Expr(graph, entry.speed)))
            acceleration = acceleration.plus(s.times(accelerations[entry.speed]))
    return _Placed(identity(graph), still.w, motion, acceleration, still, still)


def _placed(chains: Chains, base: _Placed, accelerations: Mapping[int, Expr]) -> dict[int, _Placed]:
    found: dict[int, _Placed] = {}
    for k in chains.links:
        one = chains.tree.links[k]
        before = found.get(one.parent, base)
        found[k] = _on(before, one, accelerations)
    return found


def _on(before: _Placed, one: Link, accelerations: Mapping[int, Expr]) -> _Placed:
    (entry,) = one.motion.columns
    rows = [to_child(one.steps, row) for row in before.axes]
    axes = (rows[0], rows[1], rows[2])
    at = added(before.at, apply_matrix(before.axes, one.arm))
    turn = apply_matrix(axes, entry.turn)
    s = Motion(turn, added(apply_matrix(axes, entry.slide), outer(at, turn)))
    u = Expr(turn[0].graph, entry.speed)
    rate = before.motion.carries(s)
    acceleration = before.acceleration.plus(s.times(accelerations[entry.speed])).plus(rate.times(u))
    return _Placed(axes, at, before.motion.plus(s.times(u)), acceleration, s, rate)


class _Assembly:
    """Puts the products of pairs of columns where they belong."""

    def __init__(
        self,
        graph: Graph,
        chains: Chains,
        placed: Mapping[int, _Placed],
        own: Mapping[int, tuple[Motion, Carried]],
        carried: Mapping[int, Carried],
        motion: Motion,
        whole: Carried | None,
    ) -> None:
        self._graph, self._chains = graph, chains
        self._motions = {k: (p.s, p.rate, own[k][0]) for k, p in placed.items()}
        self._carriers = {k: chains.carriers(k) for k in chains.links}
        self._frame = motion
        self._whole = whole
        tree = chains.tree
        self._base = [Motion(c.turn, c.slide) for c in tree.links[0].motion.columns] if chains.base else []
        speeds = [c.speed for c in tree.links[0].motion.columns] if chains.base else []
        self._place = {k: len(speeds) + place for place, k in enumerate(chains.links)}
        speeds += [tree.links[k].motion.columns[0].speed for k in chains.links]
        self._found = ClosedSlopes(speeds, {}, {}, {})
        self._forces = self._column_forces(carried)

    def found(self) -> ClosedSlopes:
        for number_, segment in enumerate(self._chains.segments):
            for inward in self._chains.inward(number_):
                self._outward_rows(self._chains.segments[inward].links, segment.links)
                self._inward_rows(self._chains.segments[inward].links, segment.links)
        if self._whole is not None:
            self._base_entries(self._whole)
        return self._found

    def _column_forces(self, carried: Mapping[int, Carried]) -> dict[int, ColumnForces]:
        """Return the forces of all columns; what columns of the base cost them is put in its place."""
        order, base = self._chains.links, self._base
        rows = zip(*(column_numbers(*self._motions[k], carried[k]) for k in order), strict=True)

        def compute(shared: list[Expr], own: list[Expr]) -> list[Expr]:
            forces, found = column_forces(own), []
            if base:
                motion = motion_from(shared)
                inside = [Motion(_copied(motion, s.w), _copied(motion, s.v)) for s in base]
                found = [
                    inner(forces.coriolis, s.w) + forces.inertia.power(motion.carries(s)) for s in inside
                ]
            return [*found, *forces_numbers(forces)]

        shared = [*self._frame.w, *self._frame.v] if base else []
        results = mapped(self._graph, shared, list(rows), compute)
        forces = {}
        for item, k in enumerate(order):
            numbers = [row[item] for row in results]
            for b in range(len(base)):
                self._found.by_rate[self._place[k], b] = numbers[b]
            forces[k] = forces_from(numbers[len(base) :])
        return forces

    def _outward_rows(self, rows: Sequence[int], columns: Sequence[int]) -> None:
        """Place dD_i/dq_j and dD_i/du_j for i inward of j."""
        shared = [x for k in rows for part in self._motions[k][0] for x in part]
        own = zip(*(forces_numbers(self._forces[k])[:12] for k in columns), strict=True)
        results = mapped(self._graph, shared, list(own), outer_columns)
        n = len(rows)
        for start, entries in ((0, self._found.by_position), (n, self._found.by_rate)):
            for i, row in enumerate(rows):
                for j, col in enumerate(columns):
                    if row != col and row in self._carriers[col]:
                        entries[self._place[row], self._place[col]] = results[start + i][j]

    def _inward_rows(self, columns: Sequence[int], rows: Sequence[int]) -> None:
        """Place dD_j/dq_i, dD_j/du_i and M_ji for j at or outward of i."""
        shared = [x for k in rows for x in forces_numbers(self._forces[k])[12:]]
        own = zip(
            *([x for motion in self._motions[k] for part in motion for x in part] for k in columns),
            strict=True,
        )
        results = mapped(self._graph, shared, list(own), inner_columns)
        n, found = len(rows), self._found
        for start, entries in ((0, found.by_position), (n, found.by_rate), (2 * n, found.mass)):
            for j, row in enumerate(rows):
                for i, col in enumerate(columns):
                    if col in self._carriers[row]:
                        entries[self._place[row], self._place[col]] = results[start + j][i]

    def _base_entries(self, whole: Carried) -> None:
        """Place what the base meets: its own columns, and the forces of all others along them."""
        zero = self._frame.w[0] * 0
        still = Motion((zero, zero, zero), (zero, zero, zero))
        for b, s in enumerate(self._base):
            forces = column(whole, s, self._frame.carries(s).times(number(self._graph, 1) / 2), still)
            for c, other in enumerate(self._base):
                self._found.by_rate[c, b] = other.power(forces.by_rate)
                if c >= b:
                    self._found.mass[c, b] = other.power(forces.inertia)
            for k, place in self._place.items():
                self._found.by_position[b, place] = s.power(self._forces[k].by_position)
                self._found.by_rate[b, place] = s.power(self._forces[k].by_rate)
                self._found.mass[place, b] = s.power(self._forces[k].inertia)


def _copied(beside: Motion, vector: Triple) -> Triple:
    """Return a vector of numbers in the graph of another motion."""
    x, y, z = (number(beside.w[0].graph, component.number or 0) for component in vector)
    return (x, y, z)
