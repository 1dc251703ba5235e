"""Equations for impulses: gaps and friction as inputs and as rows, which nothing decides here.

A method that steps over impacts finds the impulses of all gaps and of their friction by itself. It needs the
motion without them, how the speeds answer to each, and afterwards the equations with what it found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.solving.modal_equations import free_names
from symbody.equations.solving.unilateral import gap_of, open_gaps, unilateral_elements
from symbody.expr.expression import Expr, number, sqrt, symbol
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import LT, SELECT
from symbody.expr.sequences.sequence import Roots

# Outputs of `ImpulsiveEquations.free`, see `response_roots`.
GAPS: Final = "impulse gaps"
RESPONSES: Final = "impulse responses"
# Friction below this share of its bound sticks.
_WITHIN: Final = 1.0 - 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class ImpulsePoint:
    """Where an impulse acts along one row, with friction in up to two others; or friction of a joint alone.

    Attributes
    ----------
    name : str
        The gap; of friction alone the joint.
    row : ConstraintEquation or None
        The row of the gap.
    laws : tuple of FrictionLaw
        Those that act here.
    """

    name: str
    row: ConstraintEquation | None
    laws: tuple[FrictionLaw, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ImpulsiveEquations:
    """Equations of a mechanism whose gaps and friction are moved by impulses.

    Attributes
    ----------
    free : EquationSet
        Without any effort of gaps and of friction that sticks, and with what tells how they act as outputs.
    eqs : EquationSet
        With these efforts as its last inputs.
    points : tuple of ImpulsePoint
        In the order of their names, whatever order the model has: results do not depend on it.
    inputs : tuple of str
        The efforts, by point: along the normal, then those of its laws.
    pattern : ResponsePattern
        Where the numbers of `RESPONSES` belong.
    """

    free: EquationSet
    eqs: EquationSet
    points: tuple[ImpulsePoint, ...]
    inputs: tuple[str, ...]
    pattern: ResponsePattern


@dataclass(frozen=True, slots=True)
class ResponsePattern:
    """What the numbers of `RESPONSES` are.

    They are, block by block, the mass matrix and the slopes of the rows that always hold, both dense; then
    for each row of the points the rate without speeds and the slopes that are not identically zero; then for
    each point restitution, and friction while it slips and sticks.

    Attributes
    ----------
    blocks : tuple of (speeds, rows)
        Speeds that M or rows that always hold connect, by their places, and these rows.
    slopes : tuple of tuple of int
        For each row of the points, the speeds of its slopes.
    """

    blocks: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    slopes: tuple[tuple[int, ...], ...]


def impulsive_equations(eqs: EquationSet) -> ImpulsiveEquations:
    """Return the equations for impulses of a mechanism."""
    made: ImpulsiveEquations = eqs.plans.get("impulsive equations", lambda: _impulsive_equations(eqs))
    return made


def _impulsive_equations(eqs: EquationSet) -> ImpulsiveEquations:
    formed, gaps = eqs.formed, unilateral_elements(eqs.formed)
    points = impulse_points(formed)
    loose = open_gaps(formed, frozenset(gaps))
    zero = number(formed.graph, 0)
    smooth = {law.name: -(law.slip * law.strength) for law in formed.friction if not law.switches}
    rows = [point.row for point in points if point.row is not None]
    idle = {name: zero for name in (*(row.name for row in rows), *(law.name for law in formed.friction))}
    free = replace(loose.with_rows(loose.rows), slack=(), given={**idle, **smooth})
    roots, pattern = response_roots(free, points)
    own = [name for point in points for name in _effort_names(point)]
    inputs = [Symbol(name, SymbolKind.INPUT) for name in free_names(formed, own, "effort_")]
    efforts = dict(zip(own, (symbol(formed.graph, each) for each in inputs), strict=True))
    given = {name: efforts.get(name, zero) for name in idle} | smooth
    for row in rows:
        given[row.name] = given[row.name] * row.sense
    acting = _with_efforts(loose, points, given)
    symbols = {**formed.names.symbols, **{each.name: each for each in inputs}}
    known = Names(
        formed.names.graph, symbols, {**acting.names.values, **{row.name: given[row.name] for row in rows}}
    )
    acting = replace(acting, names=known, inputs=(*formed.inputs, *inputs))
    return ImpulsiveEquations(
        EquationSet(eqs.model, free, eqs.notes, {each.name: each for each in roots}),
        EquationSet(eqs.model, acting, eqs.notes),
        points,
        tuple(each.name for each in inputs),
        pattern,
    )


def impulse_points(formed: EquationsOfMotion) -> tuple[ImpulsePoint, ...]:
    """Return all points at which impulses act, in the order of their names."""
    rubbing: dict[str, list[FrictionLaw]] = {}
    for law in formed.friction:
        if law.switches:
            rubbing.setdefault(law.element if law.touch is None else law.touch.row, []).append(law)
    gaps = {row.gap: row for row in (*formed.slack, *formed.rows) if row.sense}
    points = [ImpulsePoint(name, row, tuple(rubbing.pop(row.name, ()))) for name, row in gaps.items()]
    points += [ImpulsePoint(name, None, tuple(laws)) for name, laws in rubbing.items()]
    return tuple(sorted(points, key=lambda point: (point.row is None, point.name)))


def _effort_names(point: ImpulsePoint) -> Iterator[str]:
    if point.row is not None:
        yield point.row.name
    for law in point.laws:
        yield law.name


def _with_efforts(
    loose: EquationsOfMotion, points: tuple[ImpulsePoint, ...], given: Mapping[str, Expr]
) -> EquationsOfMotion:
    """Return equations in which efforts are given, and modes are what these tell."""
    zero, one = number(loose.graph, 0), number(loose.graph, 1)
    modes: dict[str, Expr] = {}
    slips: dict[str, Expr] = {}
    for point in points:
        pressing = one
        if point.row is not None:
            pressing = given[point.row.name] * point.row.sense
            modes[point.name] = zero.apply(LT, pressing).apply(SELECT, zero, one)
        if point.laws:
            squares = [given[law.name] * given[law.name] for law in point.laws]
            bound = point.laws[0].limit * pressing * _WITHIN
            held = sqrt(sum(squares[1:], squares[0])).apply(LT, bound)
            if point.row is None:
                slip = point.laws[0].slip
                slips[point.laws[0].name] = held.apply(SELECT, zero, slip)
            else:
                modes[point.laws[0].element] = held.apply(SELECT, zero, one)
    friction = tuple(
        replace(law, slip=slips.get(law.name, law.slip), switches=False) for law in loose.friction
    )
    return replace(loose.with_rows(loose.rows), friction=friction, modes=modes, given=dict(given))


def response_roots(
    free: EquationsOfMotion, points: tuple[ImpulsePoint, ...]
) -> tuple[tuple[Roots, Roots], ResponsePattern]:
    """Return the outputs `GAPS` and `RESPONSES` of equations without gaps, and what these numbers are."""
    graph, speeds = free.graph, list(free.kinematics.speeds)
    place = {node: k for k, node in enumerate(speeds)}
    blocks = _blocks(free, place)
    mass, jacobian = free.dynamics.mass_matrix, free.jacobian
    values: list[Expr] = []
    for own, rows in blocks:
        values += [mass[i][j] for i in own for j in own]
        values += [jacobian[k][i] for k in rows for i in own]
    slopes: list[tuple[int, ...]] = []
    zero = number(graph, 0)
    for point in points:
        for drift, partials in _rates(free, point):
            kept = [(place[node], slope) for node, slope in partials.items() if not slope.is_zero]
            kept.sort(key=lambda pair: pair[0])
            slopes.append(tuple(k for k, _ in kept))
            values += [drift, *(slope for _, slope in kept)]
    for point in points:
        restitution = None if point.row is None else point.row.restitution
        rubbing = (point.laws[0].strength, point.laws[0].limit) if point.laws else (zero, zero)
        values += [zero if restitution is None else restitution, *rubbing]
    gaps = [gap_of(point.row) for point in points if point.row is not None]
    roots = (
        Roots(GAPS, (len(gaps),), tuple(value.index for value in gaps)),
        Roots(RESPONSES, (len(values),), tuple(value.index for value in values)),
    )
    return roots, ResponsePattern(tuple(blocks), tuple(slopes))


def _rates(free: EquationsOfMotion, point: ImpulsePoint) -> Iterator[tuple[Expr, Mapping[int, Expr]]]:
    """Yield the rates along the rows of a point: without speeds, and the slopes by these."""
    kinematics = free.kinematics
    if point.row is not None:
        yield (
            point.row.drift * point.row.sense,
            {u: slope * point.row.sense for u, slope in point.row.jacobian.items()},
        )
    for law in point.laws:
        yield kinematics.at_zero_speeds(law.rate), kinematics.speed_partials(law.rate)


def _blocks(
    free: EquationsOfMotion, place: Mapping[int, int]
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Return the speeds that the mass matrix or rows that always hold connect, with these rows."""
    mass, n = free.dynamics.mass_matrix, len(place)
    entries = [(i, j) for i in range(n) for j in range(i) if not mass[i][j].is_zero]
    zeros = find_zeros(free.graph, [mass[i][j].index for i, j in entries])
    owner = list(range(n))

    def root(k: int) -> int:
        while owner[k] != k:
            k = owner[k]
        return k

    pairs = [pair for pair, is_zero in zip(entries, zeros, strict=True) if not is_zero]
    tied = [[place[u] for u, slope in row.jacobian.items() if not slope.is_zero] for row in free.rows]
    pairs += [(own[0], k) for own in tied for k in own[1:]]
    for i, j in pairs:
        owner[max(root(i), root(j))] = min(root(i), root(j))
    groups: dict[int, list[int]] = {}
    for k in range(n):
        groups.setdefault(root(k), []).append(k)
    return [
        (tuple(own), tuple(k for k, speeds in enumerate(tied) if speeds and root(speeds[0]) == first))
        for first, own in groups.items()
    ]  # fmt: skip


def friction_of_reactions(formed: EquationsOfMotion) -> list[str]:
    """Return what has friction from reactions, which impulses change, but is not a contact that sticks."""
    return list(dict.fromkeys(
        law.owner for law in formed.friction if law.reads_reaction and not (law.switches and law.touch)
    ))  # fmt: skip
