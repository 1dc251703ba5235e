"""Jumps of prescribed rates: the speeds jump as well, by what the joints and constraints transmit.

Where a prescribed rate jumps from one value to another, the mechanism is struck: of all speeds that fit the
new rates, those are taken to which the momenta of the free directions do not change,
``M u' + b' - (M u + b) = J^T P`` [Pars, A treatise on analytical dynamics, chapter 14], b the momenta that
prescribed rates give. A jump of a prescribed position is refused: at once, or where a constraint reads
coordinates as well, at the state in which the motion comes to it.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.errors import Problem, SimulationError, UsageError
from symbody.expr import opcodes as op
from symbody.expr.graph import TIME, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.graph.linear_graph import Edge, breadth_first
from symbody.kernels.configurations.strike_problem import RateJump
from symbody.model.declarations.element_fields import Connection
from symbody.model.naming import GROUND
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import AT_REST

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Nor where it is less, of the mechanism's size: rows that always hold are zero but for rounding.
_ROUNDED: Final = 1e-12
_TORN: Final = 1e-5  # of the mechanism's size, and of its speeds: more than a motion has drifted by then
_ELSEWHERE: Final = 0.137  # of coordinates and speeds, by which they are others
_SAMPLES: Final = 33  # of a motion, for the size of what is prescribed
_BESIDE: Final = 1e-9  # of times, in which jumps at its ends are looked for
_MOST_NOTES: Final = 20
_WITH_CORNERS: Final = frozenset(
    {op.LT, op.LE, op.EQ, op.MIN, op.MAX, op.ABS, op.SIGN, op.FLOOR, op.ATAN2, op.SELECT}
)
_TIMED: Final = _WITH_CORNERS - {op.SELECT}  # whose arguments say when; a choice has conditions below it


def may_jump(eqs: EquationSet) -> bool:
    """Return whether prescribed rates may jump: conditions, or the like, in time alone stand in them."""
    return bool(corners_in_time(eqs))


def jump_parameters(eqs: EquationSet) -> frozenset[str]:
    """Return the parameters that say when prescribed rates jump."""
    graph = eqs.formed.graph
    corners = corners_in_time(eqs, _TIMED)
    symbols = [graph.symbols[graph.left[place]] for place in symbols_of(graph, corners)]
    return frozenset(symbol.name for symbol in symbols if symbol.kind is SymbolKind.PARAMETER)


def corners_in_time(eqs: EquationSet, kinds: Container[int] = _WITH_CORNERS) -> list[int]:
    """Return the nodes in prescribed motions at which formulas of time alone may have corners."""
    graph, names = eqs.formed.graph, eqs.formed.names
    nodes = [names.value(f"{name}{end}").index for name in _prescribed_names(eqs) for end in ("", "_dot")]
    nodes += [expression.index for row in eqs.formed.rows for expression in (row.value, row.drift)]
    moving = {SymbolKind.COORDINATE, SymbolKind.SPEED}
    found = []
    for node in (node for node in graph.reachable(nodes) if graph.ops[node] in kinds):
        symbols = {graph.symbols[graph.left[place]] for place in symbols_of(graph, [node])}
        if TIME in symbols and not any(symbol.kind in moving for symbol in symbols):
            found.append(node)
    return found


def jump_notes(jumps: Sequence[tuple[float, float]]) -> Iterator[str]:
    """Yield what to note about jumps: when [s], and by how much the energy changed [J]."""
    for t, change in jumps[:_MOST_NOTES]:
        yield (
            f"at t = {t:.9g} s prescribed rates jump: the speeds jump with them, and the energy "
            f"by {change:.6g} J"
        )
    if len(jumps) > _MOST_NOTES:
        yield f"{len(jumps) - _MOST_NOTES} more jumps of prescribed rates until t = {jumps[-1][0]:.9g} s"


class PlannedJumps(NamedTuple):
    """When prescribed rates jump along a motion [s], in its order, and how far beside it sides are clear."""

    times: tuple[float, ...] = ()
    margin: float = 0.0

    def part(self, span: tuple[float, float]) -> PlannedJumps:
        """Return those that a part of the motion passes."""
        low, high = min(span), max(span)
        return PlannedJumps(tuple(t for t in self.times if low < t <= high), self.margin)

    def rows(self, span: tuple[float, float]) -> Floats:
        """Return the rows of a `RateJump` for each."""
        way = 1.0 if span[1] >= span[0] else -1.0
        rows = np.zeros((len(self.times), RateJump.size))
        for k, t in enumerate(self.times):
            before = max(t - way * self.margin, span[0], key=lambda time: way * time)
            behind = min(t + way * self.margin, span[1], key=lambda time: way * time)
            rows[k, :3] = before, t if way > 0.0 else math.nextafter(t, -math.inf), behind
        return rows


NO_JUMPS: Final = PlannedJumps()


def jump_times(problem: SimulationProblem, x: Floats, span: tuple[float, float]) -> PlannedJumps:
    """Return when prescribed rates jump in a span.

    A jump is the first time at which formulas have the values of later times: motions forward pass it where
    they come to it, motions backward where they leave it. So one that goes on from an end misses none.

    Raises
    ------
    UsageError
        If a prescribed position jumps.
    """
    (start, end) = span
    times, margin = _jumps(problem, x, (start, end))
    low, high = min(span), max(span)
    return PlannedJumps(tuple(t for t in times if low < t <= high), margin)


def _jumps(problem: SimulationProblem, x: Floats, span: tuple[float, float]) -> tuple[list[float], float]:
    """Return the jumps in a span and beside it, in its order; see `jump_times`."""
    eqs = problem.eqs
    if not eqs.plans.get("may jump", lambda: may_jump(eqs)) or span[0] == span[1]:
        return [], 0.0
    names = _prescribed_names(eqs)
    closed = ("constraints", "velocity_constraints") if eqs.multiplier_names else ()
    low, high = min(span), max(span)
    beside = _BESIDE * max(high - low, abs(low), abs(high))  # a search keeps away from the ends
    bounds = problem.breakpoints(
        (low - beside, high + beside), (*names, *(f"{name}_dot" for name in names), *closed)
    )
    margin = float(bounds.margins.max(initial=0.0))
    inside = (bounds.times > low - margin) & (bounds.times < high + margin) & bounds.jumps
    times = bounds.times[inside]
    if not times.size:
        return [], 0.0
    prescribed = _PrescribedMotions(problem, x, np.linspace(*span, _SAMPLES), times, margin)
    rates, fastest = prescribed.changes((*(f"{name}_dot" for name in names), *closed[1:]))
    positions, largest = prescribed.changes((*names, *closed[:1]))
    turning = [eqs.units.get(name) == "rad" for name in names]
    positions[: len(names)] = remove_turns(positions[: len(names)], np.array(turning, dtype=np.bool_))
    width = 4.0 * margin * (fastest[: len(largest)] + np.abs(rates[: len(largest)]).max(axis=1, initial=0.0))
    rounded = _ROUNDED * _sizes(problem, names)
    limits = (AT_REST * largest + width + rounded[: len(largest)])[:, np.newaxis]
    torn = np.abs(positions) > limits
    # One that changes nothing at this state may tear at another.
    by_state = np.abs(positions - _changes_elsewhere(prescribed, names, closed)) > limits
    if (torn & ~by_state).any():
        row, k = np.argwhere(torn & ~by_state)[0]
        raise UsageError(_jump_problem(_row_name(eqs, names, int(row)), float(times[k])))
    least = (AT_REST * fastest + rounded / problem.scales.time)[:, np.newaxis]
    is_jump = np.abs(rates) > least
    places = np.flatnonzero(is_jump.any(axis=0) | by_state.any(axis=0))
    outputs = (*(f"{name}_dot" for name in names), *closed[1:])
    found = [prescribed.first_behind(outputs, float(times[k]), is_jump[:, k]) for k in places]
    return found if span[1] >= span[0] else found[::-1], margin


def _changes_elsewhere(
    prescribed: _PrescribedMotions, names: tuple[str, ...], closed: tuple[str, ...]
) -> Floats:
    """Return how much positions change at the times if all states are others: the same, if by time alone."""
    shifted = prescribed.x + _ELSEWHERE * (1.0 + np.arange(prescribed.x.size) % 7)
    changes, _ = replace(prescribed, x=shifted).changes((*names, *closed[:1]))
    turning = [prescribed.problem.eqs.units.get(name) == "rad" for name in names]
    changes[: len(names)] = remove_turns(changes[: len(names)], np.array(turning, dtype=np.bool_))
    return changes


def _row_name(eqs: EquationSet, names: tuple[str, ...], row: int) -> str:
    """Return the prescribed coordinate, or the constraint, of a row of changes."""
    return [*names, *(each.coordinate or each.name for each in eqs.formed.rows)][row]


def torn_constraint(eqs: EquationSet, place: int, t: float) -> UsageError:
    """Return what to say about a constraint that the state before a jump does not fulfil behind it."""
    return UsageError(_jump_problem(_row_name(eqs, (), place), t))


def _sizes(problem: SimulationProblem, names: tuple[str, ...]) -> Floats:
    """Return what counts as large for prescribed coordinates, and for constraints."""
    scales, eqs = problem.scales, problem.eqs
    own = [scales.length if eqs.units.get(name) == "m" else 1.0 for name in names]
    return np.concatenate([own, scales.constraints(eqs)])


def _prescribed_names(eqs: EquationSet) -> tuple[str, ...]:
    """Return the names of the prescribed coordinates that are functions of time."""
    return tuple(name for role in eqs.formed.joint_roles for name in role.prescribed_coordinates)


@dataclass(frozen=True, slots=True, eq=False)
class _PrescribedMotions:
    """What prescribed motions say of positions and of rates; those that are constraints about one state."""

    problem: SimulationProblem
    x: Floats
    samples: Floats
    times: Floats
    margin: float

    def changes(self, outputs: tuple[str, ...]) -> tuple[Floats, Floats]:
        """Return how much outputs change at the times, (n, N), and how large they are otherwise, (n,)."""
        if not outputs:
            return np.zeros((0, self.times.size)), np.zeros(0)
        before, behind = (
            self._values(outputs, self.times - self.margin),
            self._values(outputs, self.times + self.margin),
        )
        return behind - before, np.abs(self._values(outputs, self.samples)).max(axis=1)

    def first_behind(self, outputs: tuple[str, ...], t: float, jumping: Flags) -> float:
        """Return the first time, as a number, at which outputs that jump have the values behind the jump."""
        low, high = t - self.margin, t + self.margin
        ends = self._values(outputs, np.array([low, high]))[jumping]
        while jumping.any() and math.nextafter(low, high) < high:
            middle = low + 0.5 * (high - low)
            here = self._values(outputs, np.array([middle]))[jumping, 0]
            passed = (here - ends[:, 0]) / (ends[:, 1] - ends[:, 0])
            low, high = (low, middle) if passed.mean() > 0.5 else (middle, high)
        return high if jumping.any() else t

    def _values(self, outputs: tuple[str, ...], t: Floats) -> Floats:
        columns = []
        for time in t.tolist():
            values = self.problem.values_at(outputs, time, self.x)
            columns.append(np.concatenate([np.ravel(value) for value in values]))
        return np.array(columns).T


def remove_turns(changes: Floats, is_angle: Flags) -> Floats:
    """Return changes without the whole turns of angles."""
    turns = 2.0 * np.pi * np.round(changes / (2.0 * np.pi))
    found: Floats = np.where(is_angle[:, np.newaxis], changes - turns, changes)
    return found


def _jump_problem(name: str, t: float) -> Problem:
    return Problem(
        "simulation.torn_motion", f"motion {name}", f"the prescribed position jumps at t = {t:.9g} s",
        "a position cannot change instantly",
        "use a transition from one value to the other, such as smoothstep(t, t1, t2)",
    )  # fmt: skip


def struck_friction(formed: EquationsOfMotion, *, switches: bool) -> list[str]:
    """Return the joints whose friction depends on reactions to which jumps of prescribed rates may be passed.

    Those that stick and slip by events, or those of smooth friction.

    Joints and constraints pass impulses from body to body, but not through the ground.
    """
    edges = [Edge(part.name, part.start.body, part.end.body) for part in _links(formed)]
    body = {edge.name: edge.start if edge.end == GROUND else edge.end for edge in edges}
    edges = [edge for edge in edges if GROUND not in (edge.start, edge.end)]
    roles, symbols = formed.joint_roles, formed.graph.symbols
    owner = {symbol: body[role.joint.name] for role in roles for symbol in role.speeds}
    sources = {body[role.joint.name] for role in roles if role.joint.motions}
    for row in formed.rows:  # of gears and formulas: they tie the bodies whose speeds they contain
        tied = [owner[symbols[formed.graph.left[speed]]] for speed in row.jacobian]
        edges += [Edge(row.name, first, second) for first, second in pairwise(tied)]
        read = symbols_of(formed.graph, [row.drift.index])
        if TIME in {symbols[formed.graph.left[place]] for place in read}:
            sources.update(tied)
    reached = sources | {node for start in sources for _, _, node in breadth_first(edges, start)}
    laws = [law for law in formed.friction if law.reads_reaction and law.switches == switches]
    loaded = [law.owner for law in laws]
    return [name for name in loaded if body[name] in reached]


def _links(formed: EquationsOfMotion) -> list[Connection]:
    """Return all that connects two frames."""
    return [*formed.topology.joints, *formed.topology.contacts.values()]


def neglect_note(formed: EquationsOfMotion) -> Iterator[str]:
    """Yield what to note about smooth friction where prescribed rates jump."""
    names = struck_friction(formed, switches=False)
    if names:
        yield (
            f"friction of {', '.join(names)} is neglected where prescribed rates jump, though its reactions "
            f"are infinite there; prescribe a motion without corners, for instance with smoothstep"
        )


def strikes(problem: SimulationProblem, change: float) -> bool:
    """Return whether the largest change of a state is one of a speed, and not of its rounding."""
    return change > _TORN * min(1.0, problem.scales.length) / problem.scales.time


def no_speeds(t: float) -> SimulationError:
    """Return what to say where no speeds fit rates behind a jump."""
    return SimulationError(
        Problem("simulation.impulse", "motion", f"no speeds satisfy the prescribed rates after t = {t:.9g} s",
                "the constraints do not allow them, or the mass matrix is singular",
                "prescribe a motion without corners")
    )  # fmt: skip
