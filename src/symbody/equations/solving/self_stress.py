"""Self-stress: loads that redundant constraints put on each other, and the reactions of least norm.

All reactions that fit a motion differ by self-stress: multipliers nu of all rows, redundant ones too, with
``J^T nu = 0``. Motions, forces on bodies and accelerations do not depend on it, so the equations of motion
leave it open. Of all reactions those of least norm are given: with the components ``r + B nu`` of all
reactions and of all efforts that hold motions, moments divided by the length L of the mechanism, nu is the
least squares solution under ``J^T nu = 0``, which ``solve_saddle(B^T W B, J^T, -B^T W r, 0)`` finds. It
depends neither on the trees, which make the rows, nor on names and their order, and is 0 where no row is
redundant. docs/derivations/trees_and_constraints.md has the derivation.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.elimination.coupling_multipliers import coupling_multipliers
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.measured_wrenches import static_wrenches
from symbody.equations.outputs.joint_outputs import prescribed_efforts, reaction_entries
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr, maximum, number, saddle_entry
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import KernelNode, Symbol, SymbolKind
from symbody.expr.opcodes import LT, SELECT
from symbody.expr.rewrite import Substitution
from symbody.model.constraints import Distance, Rolling
from symbody.model.declarations.element_fields import Connection
from symbody.model.output_names import WRENCH
from symbody.single_flight import SingleFlight
from symbody.spatial.vector import dot


class Component(NamedTuple):
    """One number that constraints decide: a component of a reaction, or an effort.

    Attributes
    ----------
    name : str
        Its output; "lambda_C_1 theta" is the effort of a coupling along a coordinate, which is not an output.
    is_moment : bool
    """

    name: str
    is_moment: bool


@dataclass(frozen=True, slots=True)
class StressBlock:
    """Rows that may put loads on each other, apart from all others.

    Attributes
    ----------
    rows : tuple of int
        Places among all rows that bear loads.
    slopes : tuple of tuple of Expr
        J^T, one tuple a speed.
    changes : mapping of int to tuple of Expr
        B, by component: what a unit of each multiplier changes.
    weighted : mapping of int to tuple of Expr
        W B.
    """

    rows: tuple[int, ...]
    slopes: tuple[tuple[Expr, ...], ...]
    changes: Mapping[int, tuple[Expr, ...]]
    weighted: Mapping[int, tuple[Expr, ...]]

    def shares(self, values: Sequence[Expr], zero: Expr) -> list[Expr]:
        """Return nu for some values of all components without self-stress."""
        graph, n, m = zero.graph, len(self.rows), len(self.slopes)
        mass = [[zero] * n for _ in range(n)]
        loads = [zero] * n
        for place, weighted in self.weighted.items():
            for i, entry in enumerate(weighted):
                if entry.is_zero:
                    continue
                loads[i] = loads[i] - entry * values[place]
                for j, other in enumerate(self.changes[place][: i + 1]):
                    mass[i][j] = mass[i][j] + entry * other
        for i in range(n):  # a row that bears nothing here bears nothing else
            loaded = zero.apply(LT, mass[i][i])
            mass[i][i] = mass[i][i] if mass[i][i].number else loaded.apply(SELECT, mass[i][i], zero + 1)
        operands = [mass[max(i, j)][min(i, j)] for i in range(n) for j in range(n)]
        operands += [entry for row in self.slopes for entry in row]
        nodes = tuple(x.index for x in (*operands, *loads, *([zero] * m)))
        kernel = graph.kernel(KernelNode(n, m))
        return [saddle_entry(graph, kernel, nodes, k) for k in range(n)]


@dataclass(frozen=True, slots=True)
class SelfStress:
    """Self-stress of a mechanism, block by block.

    Attributes
    ----------
    rows : tuple of Row
        All that bear loads: those of the equations, then redundant ones.
    components : tuple of Component
        All that depend on the multipliers.
    blocks : tuple of Block
    """

    rows: tuple[ConstraintEquation, ...]
    components: tuple[Component, ...]
    blocks: tuple[StressBlock, ...]
    zero: Expr
    # Made on first request, from the equations these belong to; the first by `find_identically_undetermined`.
    always: SingleFlight[None, tuple[str, ...]] = field(default_factory=SingleFlight, repr=False)
    _values: SingleFlight[None, list[Expr]] = field(default_factory=SingleFlight, repr=False)
    _shared: SingleFlight[None, Substitution] = field(default_factory=SingleFlight, repr=False)

    def values(self, formed: EquationsOfMotion) -> list[Expr]:
        """Return the components in u', the multipliers and friction efforts."""
        return self._values.get(None, lambda: self.values_by(formed, formed.solved_wrenches))

    def values_by(self, formed: EquationsOfMotion, totals: Mapping[str, Wrench]) -> list[Expr]:
        """Return the components for the wrenches of all joints, of equations that may have more rows."""
        listed = dict(_components(formed, totals))
        return [listed[component] for component in self.components]

    def least_norm(self, formed: EquationsOfMotion) -> Substitution:
        """Return what replaces each multiplier in reactions of least norm."""
        return self._shared.get(None, partial(self._form_least_norm, formed))

    def _form_least_norm(self, formed: EquationsOfMotion) -> Substitution:
        symbols = multiplier_nodes(formed)
        shares = self.shares(self.values(formed))
        known = [Expr(formed.graph, node) for node in symbols[: len(formed.rows)]]
        known += [self.zero] * len(formed.redundant)
        pairs = zip(symbols, known, shares, strict=True)
        return Substitution(formed.graph, {node: (x + y).index for node, x, y in pairs})

    def shares(self, values: Sequence[Expr]) -> list[Expr]:
        """Return the change of each multiplier, for values of all components without self-stress."""
        found = [self.zero] * len(self.rows)
        for block in self.blocks:
            for place, share in zip(block.rows, block.shares(values, self.zero), strict=True):
                found[place] = share
        return found


def self_stress(formed: EquationsOfMotion) -> SelfStress:
    """Return the self-stress of a mechanism; without blocks where there are no constraints."""
    found = formed.self_stress.get(None, partial(_self_stress, formed))
    assert isinstance(found, SelfStress)
    return found


def substitute_shares(formed: EquationsOfMotion, values: Sequence[Expr]) -> list[Expr]:
    """Return expressions in the multipliers with those of least norm, in the multipliers of the solution."""
    graph = formed.graph
    symbols = multiplier_nodes(formed)
    if not symbols or set(symbols).isdisjoint(graph.reachable([value.index for value in values])):
        return list(values)
    found = self_stress(formed).least_norm(formed).roots([x.index for x in values])
    return [Expr(graph, node) for node in found]


def multiplier_nodes(formed: EquationsOfMotion) -> list[int]:
    """Return the symbols of the multipliers of all rows that bear loads."""
    rows = (*formed.rows, *formed.redundant)
    return [formed.graph.symbol(Symbol(row.name, SymbolKind.MULTIPLIER)) for row in rows]


def _self_stress(formed: EquationsOfMotion) -> SelfStress:
    zero = number(formed.graph, 0)
    rows = (*formed.rows, *formed.redundant)
    if not rows:
        return SelfStress((), (), (), zero)
    listed = list(_components(formed, static_wrenches(formed, formed.bearing_rows)))
    changes = _changes(formed, [value.index for _, value in listed])
    loaded = [k for k, row in enumerate(changes) if not all(entry.is_zero for entry in row)]
    components = tuple(listed[k][0] for k in loaded)
    matrix = [changes[k] for k in loaded]
    slopes = _slopes(formed)
    square = 1 / _squared_length(formed)
    weights = [square if component.is_moment else zero + 1 for component in components]
    blocks = []
    for members in _group_columns(len(rows), [*matrix, *slopes]):
        own = {
            k: tuple(row[i] for i in members)
            for k, row in enumerate(matrix)
            if not all(row[i].is_zero for i in members)
        }
        held = [tuple(row[i] for i in members) for row in slopes]
        held = [row for row in held if not all(entry.is_zero for entry in row)]
        if own and not (len(members) == 1 and held):  # a row alone that holds something is not redundant
            weighted = {k: tuple(entry * weights[k] for entry in row) for k, row in own.items()}
            blocks.append(StressBlock(tuple(members), tuple(held), own, weighted))
    return SelfStress(rows, components, tuple(blocks), zero)


def _components(formed: EquationsOfMotion, totals: Mapping[str, Wrench]) -> Iterator[tuple[Component, Expr]]:
    """Return the components of all reactions, and all efforts that constraints give."""
    for name in (*(joint.name for joint in formed.topology.joints), *formed.topology.contacts):
        for entry, value in zip(WRENCH, reaction_entries(formed, name, totals), strict=True):
            yield Component(f"reaction {name} {entry}", entry.startswith("M")), value
    turning = {name for role in formed.joint_roles for name in role.joint.rotation_coordinates}
    for name, coordinate, effort in prescribed_efforts(formed, totals):
        yield Component(f"effort {name}", coordinate in turning), effort
    for row, multiplier in formed.bearing_rows:
        for component in _row_components(formed, row, turning):
            yield component, multiplier
        for coordinate, share in row.shares.items():
            yield Component(f"{row.name} {coordinate}", coordinate in turning), multiplier * share
    substituted = coupling_multipliers(formed, totals, formed.bearing_rows) if formed.coupled.rows else {}
    for row in formed.coupled.rows:
        for coordinate, share in row.shares.items():
            yield Component(f"{row.name} {coordinate}", coordinate in turning), substituted[row.name] * share


def _row_components(
    formed: EquationsOfMotion, row: ConstraintEquation, turning: Collection[str]
) -> Iterator[Component]:
    """Yield what the multiplier of a row itself is, if it is an effort that no wrench shows."""
    if row.coordinate:
        name = formed.topology.joint(row.element).effort_name(row.coordinate)
        yield Component(f"effort {name}", row.coordinate in turning)
    elif row.gap not in ("", row.element):  # points of a contact, whose wrench is that of all
        yield Component(row.name, is_moment=False)
    else:
        for law in formed.friction:
            if row.name == law.holding_effort:
                yield Component(f"friction {law.name}", law.coordinate in turning)


def _changes(formed: EquationsOfMotion, nodes: Sequence[int]) -> list[list[Expr]]:
    """Return B, one row a component; entries that vanish identically are 0."""
    return _clear_zeros(formed, jacobian(formed.graph, nodes, multiplier_nodes(formed)))


def _slopes(formed: EquationsOfMotion) -> list[list[Expr]]:
    """Return J^T, one row a speed, with columns of 0 for rows that hold identically."""
    zero = number(formed.graph, 0)
    rows = (*formed.rows, *formed.redundant)
    found = [[row.jacobian.get(u, zero).index for row in rows] for u in formed.kinematics.speeds]
    return _clear_zeros(formed, found)


def _clear_zeros(formed: EquationsOfMotion, matrix: Sequence[Sequence[int]]) -> list[list[Expr]]:
    """Return a matrix with entries 0 where they vanish identically."""
    gone = iter(find_zeros(formed.graph, [node for row in matrix for node in row]))
    return [[Expr(formed.graph, 0 if next(gone) else node) for node in row] for row in matrix]


def _group_columns(count: int, matrix: Iterable[Sequence[Expr]]) -> list[list[int]]:
    """Return the columns of a matrix in groups that have no row in common."""
    group = list(range(count))
    for row in matrix:
        inside = {group[k] for k, entry in enumerate(row) if not entry.is_zero}
        if inside:
            first = min(inside)
            group = [first if k in inside else k for k in group]
    return [[k for k in range(count) if group[k] == first] for first in sorted(set(group))]


def _squared_length(formed: EquationsOfMotion) -> Expr:
    """Return the square of the length L of a mechanism: 1 m where all its lengths are 0.

    It is the largest distance between two frames of joints and constraints on one body, or on ground, length
    of a rod or radius of a wheel.
    """
    zero, tree = number(formed.graph, 0), formed.kinematics.tree
    links: list[Connection] = [*formed.topology.model.joints, *formed.topology.contacts.values()]
    frames: dict[str, list[str]] = {}
    for end in (end for link in links for end in (link.start, link.end)):
        own = frames.setdefault(end.body, [])
        if end.full_name not in own:
            own.append(end.full_name)
    squares = []
    for own in frames.values():
        arms = [formed.kinematics.position(a, b) for k, a in enumerate(own) for b in own[:k]]
        squares += [dot(tree, arm, arm) for arm in arms]
    for link in links:
        formula = link.radius if isinstance(link, Rolling) else None
        formula = link.value if isinstance(link, Distance) else formula
        if formula is not None:
            squares.append(formed.names.expression(formula, f"constraint {link.name}") ** 2)
    largest = zero
    for square in dict.fromkeys(squares):
        largest = maximum(largest, square) if not largest.is_zero else square
    return zero.apply(LT, largest).apply(SELECT, largest, zero + 1)
