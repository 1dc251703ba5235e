"""Derivatives of the accelerations of a tree without differentiating their solution.

``M u' = F`` says that the inverse dynamics ``D(q, u, u', r) = M u' - F`` vanish, so ``du'/dx = -M^-1 dD/dx``
with u' held fixed in D and the factors of M at hand. [Carpentier & Mansard, Analytical derivatives of rigid
body dynamics algorithms, RSS 2018]

For code, columns of one chain of joints are solved for side by side, with dD/dx in closed form: a column of a
joint has entries only in the rows of joints inward and outward of it, so that columns of one chain take the
same operations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from symbody.equations.dynamics.linear_solve import TreeFactors, factor, solve_factored
from symbody.equations.recursive.chains import TOGETHER, Chains, chains
from symbody.equations.recursive.inverse_dynamics_partials import (
    InverseDynamicsPartials,
    inverse_dynamics_partials,
)
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.system import MultibodySystem
from symbody.expr.calculus import forward
from symbody.expr.canonical import ONE, ZERO
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.program import map_program

# Below so many speeds, and where less is asked for, operations one after the other are fewer and as fast.
FEWEST_SPEEDS: Final = 8

# A column of the right-hand sides: entries by rows.
Right = dict[int, Expr]


def acceleration_slopes(
    system: MultibodySystem,
    recursion: Recursion,
    udot: Sequence[Expr],
    by: Sequence[Symbol],
    *,
    side_by_side: bool,
) -> list[list[Expr]]:
    """Return the derivatives of u' by symbols, one row a speed, all other symbols held fixed.

    Parameters
    ----------
    side_by_side : bool
        Whether programs for several columns may be among the nodes: faster as code, but for nothing else.
    """
    if side_by_side:
        rows = _columns_side_by_side(system, recursion, by, udot)
        if rows is not None:
            return rows
    graph, nodes = system.graph, [system.graph.symbol(symbol) for symbol in by]
    symbols = system.expressions([u.derivative for u in system.u])
    roots = [x.index for x in recursion.inverse_dynamics(symbols)]
    entries = [entry for column in columns_of_slopes(graph, roots, nodes) for entry in column]
    values = {symbol.index: value.index for symbol, value in zip(symbols, udot, strict=True)}
    slopes = [-Expr(graph, entry) for entry in substitute(graph, entries, values)]
    n = len(roots)
    columns = recursion.solve_columns([slopes[k : k + n] for k in range(0, len(slopes), n)])
    return [list(row) for row in zip(*columns, strict=True)] if columns else [[] for _ in udot]


def columns_of_slopes(graph: Graph, roots: Sequence[int], by: Sequence[int]) -> list[list[int]]:
    """Return the derivatives of inverse dynamics by symbols, one column a symbol.

    Forward, whatever the numbers of both: the rotation of one joint changes few links, while each root is
    reached from all.
    """
    still = dict.fromkeys(by, ZERO)
    return [forward(graph, roots, {**still, node: ONE}) for node in by]


def _columns_side_by_side(
    system: MultibodySystem, recursion: Recursion, by: Sequence[Symbol], udot: Sequence[Expr]
) -> list[list[Expr]] | None:
    """Return du'/dx, one row a speed, or None where that is not of this form or does not pay."""
    graph, n = system.graph, len(system.u)
    variables = {*system.q, *system.u}
    if not all(symbol in variables or symbol.kind in (SymbolKind.INPUT, SymbolKind.SIGNAL) for symbol in by):
        return None
    if n < FEWEST_SPEEDS or len(by) < n or recursion.method_for_columns != "composite":
        return None
    rates = {q.index: system.variables.rates[q.index] for q in system.expressions(system.q)}
    tree = chains(graph, recursion.base_tree, rates)
    if tree is None:
        return None
    speeds = [u.index for u in system.expressions(system.u)]
    values = dict(zip(speeds, udot, strict=True))
    closed = inverse_dynamics_partials(graph, tree, recursion.gravity, values)
    if set(closed.speeds) != set(speeds):
        return None  # some speed moves no link
    columns = _Columns(system, recursion, tree, closed, udot).solve([graph.symbol(symbol) for symbol in by])
    place = {speed: row for row, speed in enumerate(closed.speeds)}
    return [[column[place[speed]] for column in columns] for speed in speeds]


class _Columns:
    """Right-hand sides by chain, and their solutions."""

    def __init__(
        self,
        system: MultibodySystem,
        recursion: Recursion,
        tree: Chains,
        closed: InverseDynamicsPartials,
        udot: Sequence[Expr],
    ) -> None:
        self._graph, self._system, self._recursion = system.graph, system, recursion
        self._tree, self._closed, self._udot = tree, closed, udot
        self._zero = number(system.graph, 0)
        self._count = len(closed.speeds)
        rows = [
            {j: closed.mass[i, j] for j in range(i + 1) if (i, j) in closed.mass} for i in range(self._count)
        ]
        place = {speed: row for row, speed in enumerate(closed.speeds)}
        for (one, two), inertia in recursion.rotor_entries().items():
            i, j = place[one], place[two]
            if j <= i:
                rows[i][j] = rows[i].get(j, self._zero) + inertia
        self._factors = factor(rows)

    def solve(self, by: Sequence[int]) -> list[list[Expr]]:
        """Return the columns of du'/dx, rows in the order of the closed form."""
        right = self._right_hand_sides(by)
        found = {x: [self._zero] * self._count for x in by}
        for rows, members in self._groups(right):
            solution = self._solve_group(rows, [right[x] for x in members])
            found |= {x: [row[k] for row in solution] for k, x in enumerate(members)}
        for x, fall in self._falls(by).items():
            found[x] = [entry + fall.get(row, self._zero) for row, entry in enumerate(found[x])]
        return [found[x] for x in by]

    def _right_hand_sides(self, by: Sequence[int]) -> dict[int, Right]:
        """Return dD/dx by x, without what the position of the base changes by gravity; no zeros."""
        right: dict[int, Right] = {x: {} for x in by}
        place = {speed: column for column, speed in enumerate(self._closed.speeds)}
        moved = {q: place[u] for u, q in self._tree.coordinates.items() if u in place}
        for columns, entries in ((place, self._closed.by_rate), (moved, self._closed.by_position)):
            owner = {column: x for x, column in columns.items()}
            for (row, column), entry in entries.items():
                x = owner.get(column)
                if x in right and not entry.is_zero:
                    right[x][row] = entry
        for x, added in zip(by, self._load_columns(by), strict=True):
            for row, entry in added.items():
                right[x][row] = right[x].get(row, self._zero) + entry
        return right

    def _load_columns(self, by: Sequence[int]) -> list[Right]:
        """Return what loads and rotors add to the columns."""
        graph, system = self._graph, self._system
        symbols = system.expressions([u.derivative for u in system.u])
        roots = [x.index for x in self._recursion.inverse_dynamics_of_loads(symbols)]
        known = {symbol.index: value.index for symbol, value in zip(symbols, self._udot, strict=True)}
        place = {speed: row for row, speed in enumerate(self._closed.speeds)}
        rows = [place[u.index] for u in system.expressions(system.u)]
        still = dict.fromkeys(by, ZERO)
        columns = (substitute(graph, forward(graph, roots, {**still, x: ONE}), known) for x in by)
        return [
            {row: Expr(graph, entry) for row, entry in zip(rows, column, strict=True) if entry != ZERO}
            for column in columns
        ]

    def _groups(self, right: Mapping[int, Right]) -> list[tuple[tuple[int, ...], list[int]]]:
        """Return columns with the rows they have entries in: those of one chain and kind together."""
        homes, reached = self._homes()
        every = frozenset(range(self._count))
        kinds = {u: (homes.get(row, -1), 0) for row, u in enumerate(self._closed.speeds)}
        kinds |= {self._tree.coordinates[u]: (home, 1) for u, (home, _) in kinds.items() if home >= 0}
        order = {x: k for k, x in enumerate((*self._closed.speeds, *self._tree.coordinates.values()))}
        members: dict[tuple[int, int, frozenset[int]], list[int]] = {}
        for x in sorted(right, key=lambda x: order.get(x, -1)):
            if right[x]:
                home, kind = kinds.get(x, (homes.get(max(right[x]), -1), 2))
                rows = reached.get(home, every)
                rows = rows if right[x].keys() <= rows else every
                members.setdefault((home, kind, rows), []).append(x)
        groups: list[tuple[int, int, frozenset[int], list[int]]] = []
        for (home, kind, rows), some in sorted(members.items(), key=lambda item: item[0][:2]):
            for k, (other, same, before, those) in enumerate(groups):
                if len(those) + len(some) <= TOGETHER and (other == home or kind == same == 2):
                    groups[k] = (home, min(kind, same), before | rows, those + some)
                    break
            else:
                groups.append((home, kind, rows, some))
        return [(tuple(sorted(rows)), some) for _, _, rows, some in groups]

    def _homes(self) -> tuple[dict[int, int], dict[int, frozenset[int]]]:
        """Return the segment of each row but those of the base, and the rows that a column of one reaches."""
        segments, links = self._tree.segments, self._tree.tree.links
        first = len(links[0].motion.columns) if self._tree.base else 0
        rows = {speed: row for row, speed in enumerate(self._closed.speeds)}
        place = {k: rows[links[k].motion.columns[0].speed] for k in self._tree.links}
        homes = {place[k]: home for home, segment in enumerate(segments) for k in segment.links}
        reached = {home: set(range(first)) for home in range(len(segments))}
        for home in reached:
            for inward in self._tree.inward(home):
                reached[home] |= {place[k] for k in segments[inward].links}
                reached[inward] |= {place[k] for k in segments[home].links}
        return homes, {home: frozenset(rows) for home, rows in reached.items()}

    def _solve_group(self, rows: Sequence[int], columns: Sequence[Right]) -> list[list[Expr]]:
        """Return the solutions, one row a speed, one column a right-hand side."""
        lower, inverse = self._factors.lower, self._factors.inverse
        pattern = [tuple(row) for row in lower]
        shared = [entry for row in lower for entry in row.values()] + [-x for x in inverse]

        def compute(given: list[Expr], own: list[Expr]) -> list[Expr]:
            left = iter(given)
            factors = TreeFactors([{i: next(left) for i in row} for row in pattern], [], list(left))
            x = [number(own[0].graph, 0)] * len(pattern)
            for row, entry in zip(rows, own, strict=True):
                x[row] = entry
            return solve_factored(factors, x)

        return map_program(
            self._graph,
            shared,
            [[column.get(row, self._zero) for column in columns] for row in rows],
            compute,
        )

    def _falls(self, by: Sequence[int]) -> dict[int, Right]:
        """Return what turning the base changes: what falls with it accelerates along other axes of it."""
        if not self._tree.base:
            return {}
        free, graph = self._recursion.base_tree.links[0], self._graph
        gravity = [x.index for x in free.transform.to_child(self._recursion.gravity)]
        own = set(self._tree.coordinates.values())
        places = {
            [x.number for x in column.twist.linear].index(1): row
            for row, column in enumerate(free.motion.columns)
            if all(x.is_zero for x in column.twist.angular)
        }
        falls = {}
        for x in by:
            if x not in own:
                slopes = forward(graph, gravity, {x: ONE})
                falls[x] = {
                    places[axis]: Expr(graph, slope) for axis, slope in enumerate(slopes) if slope != ZERO
                }
        return {x: fall for x, fall in falls.items() if fall}
